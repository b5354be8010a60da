#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests a user of a root folder who replaces folders by links to the outside at any moment. Meanwhile jobs of every
type read from one folder and write into another, results are downloaded, and uploads arrive. Outside are files with
the same names and other contents. Everything that a job reads or a download returns must come from inside the root,
and no file outside may be written, changed or removed.

  fault_injection/swapped_links.py MULTUM [--seconds 60]
"""
import argparse
import collections
import hashlib
import http.client
import os
import random
import shutil
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from service_harness import QUICK, Service, fail  # noqa: E402
from tiny_animation import SIDE, write_animation  # noqa: E402

SCENE = ('[[map]]\nname = "m"\nnormal = "map_normal.png"\ngreen = "up"\n[[material]]\nname = "p"\nbrdf = "lambert"\n'
         '[[object]]\nname = "o"\nmap = "m"\nmaterial = "p"\nwidth = 1\ndistance = [1, 2]\n[[light]]\n'
         'direction = [0, 0, 1]\n')
# For each type of job, names the file in the result that shows which input was used.
RESULTS = {"bake": "", "scene": "m.ndf.exr", "infer": None, "pack": ""}


def make_inputs(multum, folder, is_inside):
    os.makedirs(folder)
    subprocess.run([multum, "testmap", os.path.join(folder, "map"), "--size", str(SIDE if is_inside else 2 * SIDE)],
                   check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(folder, "scene.toml"), "w", encoding="utf-8") as file:
        file.write(SCENE)
    write_animation(folder, 0.25 if is_inside else 0.75)
    subprocess.run([multum, "infer", os.path.join(folder, "animation.toml"), "-o", os.path.join(folder, "field"),
                    "--context=osmesa", "--no-frames", "--no-comparison"], check=True, stdout=subprocess.DEVNULL)


def hash_of(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def state_of(folder):
    """Returns every file of the folder with its content and times."""
    files = [os.path.join(above, name) for above, _, names in os.walk(folder) for name in names]
    return {path: (hash_of(path), os.lstat(path).st_mtime_ns) for path in files}


class Swapper(threading.Thread):
    """Repeatedly turns each folder into a link to the outside for a moment, with varying pauses."""

    def __init__(self, folders, outside):
        super().__init__()
        self.folders, self.outside = folders, outside
        self.ends, self.swaps = threading.Event(), 0

    def run(self):
        while not self.ends.is_set():
            for path in self.folders:
                try:
                    os.rename(path, path + ".real")
                    os.symlink(self.outside, path)
                    time.sleep(0.0005)
                    os.unlink(path)
                    os.rename(path + ".real", path)
                    self.swaps += 1
                except OSError:
                    pass
            time.sleep(random.choice((0, 0, 0, 0.001, 0.005, 0.02, 0.2)))


def job_of(kind, source, target, number):
    parameters = {"bake": {"input": os.path.join(source, "map_normal.png"), "green": "up", "no_measure": True},
                  "scene": {"scene": os.path.join(source, "scene.toml")},
                  "infer": {"job": os.path.join(source, "animation.toml"), "context": "osmesa", "no_frames": True,
                            "no_comparison": True},
                  "pack": {"manifest": os.path.join(source, "field/inferred.json"), "lambda": 1}}[kind]
    # Some results replace an earlier result. In that case the service exchanges the folders.
    name = f"{kind}{number % 5}" + {"bake": ".ndf.exr", "pack": ".mpt"}.get(kind, "")
    return {"type": kind, "parameters": parameters, "output": os.path.join(target, name), "again": True,
            "attempt_max": 10}


def result_hash(kind, output):
    if kind != "infer":
        return hash_of(os.path.join(output, RESULTS[kind]).rstrip("/"))
    return {os.path.relpath(name, output): hash_of(name) for name in sorted(state_of(output)) if name.endswith(".exr")}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("multum")
    parser.add_argument("--seconds", type=float, default=60)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        service = Service(options.multum, folder, config=QUICK).start()
        source, target = os.path.join(service.root, "source"), os.path.join(service.root, "target")
        outside = os.path.join(folder, "outside")
        make_inputs(options.multum, source, True)
        make_inputs(options.multum, outside, False)
        os.mkdir(target)
        kinds, right = tuple(RESULTS), {}
        first = {}
        for kind in kinds:
            first[kind] = service.submit(**job_of(kind, source, target, 0))
            job = service.wait_for(first[kind])
            if job["state"] != "succeeded":
                fail(f"{kind}: {job['message']}")
            right[kind] = result_hash(kind, job["output"])
        # These files are outside the root folder and have the names of results. A download or a job that follows a link
        # would find them.
        for name in os.listdir(target):
            result = os.path.join(target, name)
            (shutil.copytree if os.path.isdir(result) else shutil.copy)(result, os.path.join(outside, name))
        with open(os.path.join(outside, "bake0.ndf.exr"), "wb") as file:
            file.write(b"secret" * 1000)
        # The listing is also copied, so the size and time of this file match the published file.
        baked = os.path.join(outside, "scene0", RESULTS["scene"])
        times = os.stat(baked)
        with open(baked, "r+b") as file:
            file.write((b"secret" * times.st_size)[:times.st_size])
        os.utime(baked, ns=(times.st_atime_ns, times.st_mtime_ns))
        before = state_of(outside)
        swapper = Swapper([source, target], outside)
        swapper.start()
        counts, downloads, answers, number = collections.Counter(), 0, collections.Counter(), 0
        waiting = []
        try:
            deadline = time.monotonic() + options.seconds
            while time.monotonic() < deadline:
                kind = "scene" if downloads % 4 == 0 else "bake"
                try:
                    status, answer = service.ask("GET", f"/v1/jobs/{first[kind]}/result")
                except http.client.IncompleteRead as cut:  # an archive whose files disappear while it is being sent
                    status, answer = "cut", cut.partial
                downloads += 1
                answers[kind, status] += 1
                if status in (200, "cut") and b"secret" in answer:
                    fail("a download returned contents from outside")
                waiting = [one for one in waiting if service.job(one[1])["state"] not in
                           ("succeeded", "dead", "cancelled")] if downloads % 50 == 0 else waiting
                if downloads % 10 == 0 and len(waiting) < 6:
                    number += 1
                    kind = kinds[number % len(kinds)]
                    status, answer = service.ask("POST", "/v1/jobs", job_of(kind, source, target, number))
                    if status == 201:
                        waiting.append((kind, answer["id"]))
                        counts[kind] += 1
                    elif status not in (200, 400, 503):
                        fail(f"a submission was answered {status}: {answer}")
        finally:
            swapper.ends.set()
            swapper.join()
        for _, one in waiting:
            service.wait_for(one)
        done = collections.Counter()
        for job in service.ask("GET", "/v1/jobs?limit=1000")[1]["jobs"]:
            done[f"{job['type']} {job['state']}"] += 1
        for name in os.listdir(target):
            kind = name[:5].rstrip("01234.")
            if kind not in kinds or ".kept-" in name:
                continue
            made = result_hash(kind, os.path.join(target, name))
            if made != right[kind]:
                fail(f"{name} was made from files outside: {made}, expected {right[kind]}")
        if state_of(outside) != before:
            fail(f"files outside have changed: {sorted(set(state_of(outside).items()) ^ set(before.items()))[:5]}")
        if service.process.poll() is not None:
            fail(f"the daemon ended: {service.log_text()[-2000:]}")
        service.stop()
        if min(done[f"{kind} succeeded"] for kind in kinds) < 2:
            fail(f"almost no job succeeded: {dict(done)}")
        sums = sorted((f"{kind} {status}", count) for (kind, status), count in answers.items())
        listed = ", ".join(f"{what}: {count}" for what, count in sums)
        print(f"{swapper.swaps} swaps, {downloads} downloads ({listed}), jobs {dict(counts)}, the last 1000: "
              f"{dict(done)}: no file outside was read or written")
        if downloads < 20 or min(counts[kind] for kind in kinds) == 0 or swapper.swaps < 100:
            fail("too little happened")
        if answers["scene", 200] == 0 or answers["bake", 200] == 0:
            fail("too little happened")


if __name__ == "__main__":
    main()
