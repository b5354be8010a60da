#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the cost of the queue. Alternately, a shell loop and a service with one worker make the same bakes, each
time from scratch. Prints numbers without judging them.

  fault_injection/overhead.py MULTUM [--maps 8] [--size 512] [--rounds 5]
"""
import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from service_harness import Service  # noqa: E402


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("multum")
    parser.add_argument("--maps", type=int, default=8)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        service = Service(options.multum, folder, options=["--workers", "1"])
        names = [os.path.join(service.root, f"m{number}") for number in range(options.maps)]
        for number, name in enumerate(names):
            subprocess.run([options.multum, "testmap", name, "--size", str(options.size), "--seed", str(number)],
                           check=True, capture_output=True)
        outputs = os.path.join(service.root, "out")

        def by_loop():
            lines = [f"'{options.multum}' bake {name}_normal.png -o {outputs}/{os.path.basename(name)}.ndf.exr -q"
                     for name in names]
            subprocess.run(["sh", "-ec", "\n".join(lines)], check=True, env=service.environment)

        def by_service():
            environment = dict(service.environment, MULTUM_SERVER=f"http://127.0.0.1:{service.port}")
            for name in names:
                subprocess.run([options.multum, "jobs", "submit", "bake", name + "_normal.png", "--again", "-o",
                                f"{outputs}/{os.path.basename(name)}.ndf.exr"],
                               check=True, env=environment, capture_output=True)
            subprocess.run([options.multum, "jobs", "wait", "--all"], check=True, env=environment, capture_output=True)
            assert len(os.listdir(outputs)) == len(names), os.listdir(outputs)

        def timed(bakes):
            shutil.rmtree(outputs, ignore_errors=True)
            os.mkdir(outputs)
            begun = time.monotonic()
            bakes()
            return time.monotonic() - begun

        service.start()
        timed(by_loop)  # this run builds the kernels
        timed(by_service)
        ratios = []
        for _ in range(options.rounds):
            loop, queue = timed(by_loop), timed(by_service)
            ratios.append(queue / loop)
            print(f"loop {loop:.2f} s, service {queue:.2f} s: {queue / loop:.3f}")
        print(f"{options.maps} bakes of {options.size} x {options.size}, service over loop: median "
              f"{statistics.median(ratios):.3f}, {min(ratios):.3f} to {max(ratios):.3f}")
        assert service.stop() == 0


if __name__ == "__main__":
    main()
