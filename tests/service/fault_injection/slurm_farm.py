#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs many small jobs and a large map in shares on a real Slurm with four nodes, while everything fails that can
fail: controllers right after they have accepted a job, nodes with all of their tasks, and the daemon. One node is
drained for a while, the clock of another node is one hour fast, and the shared folder is full for a while. Every
result must exist exactly once, and no other file may be left.

  fault_injection/slurm_farm.py MULTUM_DRILL [--jobs 500] [--map 8192] [--faults 3]

It needs root, the right to mount a tmpfs, and Debian's slurmctld, slurmd, slurm-client and munge; faketime for the
clock. Exits with 77 (skipped) if no Slurm can be started.
"""
import argparse
import collections
import contextlib
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from service_harness import Service, fail  # noqa: E402
from slurm_harness import Slurm, why_not  # noqa: E402
from slurm_test import SBATCH, write_program  # noqa: E402

NODES = 4
FOLDER_BYTES = 64 << 20
CONFIG = """
workers = 1
back_off_first_s = 0.1
back_off_max_s = 1
[[queue]]
name = "default"
[[queue]]
name = "farm"
[slurm]
folder = "{folder}"
queues = ["farm"]
program = "{program}"
cpus = 1
poll_s = 0.3
visible_s = 1
lease_s = 5
chunk_s = 2
share_s = {share}
rounds = 10
"""
# munge refuses a node whose clock is wrong, so slurmd sees the right time. Only multum on that node sees the wrong
# time.
PROGRAM = """#!/bin/sh
[ "$SLURMD_NODENAME" != bake4 ] || exec {faketime} -f +1h {multum} "$@"
exec {multum} "$@"
"""


class Farm:
    def __init__(self, options, folder):
        self.options = options
        self.folder = folder
        self.done = collections.Counter()
        self.slurm = Slurm(os.path.join(folder, "slurm"), nodes=NODES).start()
        self.flag = os.path.join(folder, "kill-controller")
        programs = os.path.join(folder, "bin")
        os.mkdir(programs)
        write_program(os.path.join(programs, "sbatch"),
                      SBATCH.format(sbatch=shutil.which("sbatch", path=self.slurm.environment["PATH"]), flag=self.flag))
        self.faketime = shutil.which("faketime")
        self.multum = os.path.abspath(options.multum)
        program = self.multum
        if self.faketime:
            program = write_program(os.path.join(folder, "node-program"),
                                    PROGRAM.format(faketime=self.faketime, multum=self.multum))
        self.shared = os.path.join(folder, "shared")
        os.mkdir(self.shared, mode=0o700)
        self.is_mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={FOLDER_BYTES},mode=700", "multum",
                                          self.shared], capture_output=True, check=False).returncode == 0
        self.service = Service(self.multum, os.path.join(folder, "service"),
                               config=CONFIG.format(folder=self.shared, program=program,
                                                    share=options.share_seconds),
                               environment=dict(self.slurm.environment,
                                                PATH=programs + ":" + self.slurm.environment["PATH"])).start()
        self.small, self.map, self.baked, self.map_job = {}, "", "", 0

    def close(self):
        if self.service.process.poll() is None:
            self.service.kill()
        self.slurm.stop()
        if self.is_mounted:
            subprocess.run(["umount", self.shared], check=False)

    # ---- Faults

    def kill_controller(self):
        """Kills the controller right after it has accepted the next job. The controller is started again some seconds
        later."""
        if self.slurm.processes["slurmctld"].poll() is not None:
            return
        with open(self.flag + ".pid", "w", encoding="utf-8") as file:
            file.write(str(self.slurm.processes["slurmctld"].pid))
        open(self.flag, "w", encoding="utf-8").close()
        # Submits a job that the controller can accept.
        self.submit_small()
        deadline = time.monotonic() + 20
        while os.path.exists(self.flag) and time.monotonic() < deadline:
            time.sleep(0.05)
        if os.path.exists(self.flag):
            os.remove(self.flag)
            return
        self.slurm.processes["slurmctld"].wait()
        time.sleep(2)
        self.slurm.start_controller()
        self.done["controllers killed after they had accepted"] += 1

    def crash_node(self):
        self.slurm.crash_node("bake2")
        time.sleep(4)
        self.slurm.return_node("bake2")
        self.done["nodes crashed"] += 1

    def kill_daemon(self):
        self.service.kill()
        time.sleep(1)
        self.service.start()
        self.done["daemons killed"] += 1

    def drain_node(self):
        self.slurm.run("scontrol", "update", "NodeName=bake3", "State=DRAIN", "Reason=test")
        time.sleep(4)
        self.slurm.run("scontrol", "update", "NodeName=bake3", "State=RESUME")
        self.done["nodes drained"] += 1

    def fill_folder(self):
        if not self.is_mounted:
            return
        path = os.path.join(self.shared, "filler")
        with contextlib.suppress(OSError), open(path, "wb", buffering=0) as file:
            while True:
                file.write(b"\0" * 4096)
        time.sleep(4)
        os.remove(path)
        self.done["times the shared folder was full"] += 1

    # ---- Work

    def submit_small(self):
        number = len(self.small)
        output = os.path.join(self.service.root, f"{number}.txt")
        self.small[output] = self.service.submit(
            type="drill", queue="farm", parameters={"seconds": 0.05, "text": f"job {number}"}, output=output,
            attempt_max=100)

    def submit(self):
        for _ in range(self.options.jobs):
            self.submit_small()
        self.map = os.path.join(self.service.root, "map.png")
        subprocess.run([self.multum, "testmap", "--size", str(self.options.map), self.map[:-4]], check=True,
                       capture_output=True)
        os.rename(self.map[:-4] + "_normal.png", self.map)
        os.remove(self.map[:-4] + "_albedo.png")
        self.baked = os.path.join(self.service.root, "map.ndf.exr")
        self.map_job = self.service.submit(type="bake", queue="farm", parameters={"input": self.map},
                                           output=self.baked, attempt_max=100)

    def wait(self):
        deadline = time.monotonic() + self.options.timeout
        while True:
            counts = self.service.counts("farm")
            if all(counts[state] == 0 for state in ("waiting", "queued", "running", "publishing")):
                return counts
            if time.monotonic() > deadline:
                fail(f"jobs did not end: {counts} {self.service.log_text()[-3000:]}")
            time.sleep(0.5)

    def check(self, counts):
        jobs = len(self.small) + 1
        assert counts["succeeded"] == jobs, f"{counts} of {jobs}"
        for number, path in enumerate(self.small):
            with open(path, encoding="utf-8") as file:
                assert file.read() == f"job {number}\n", path
        expected = {os.path.basename(path) for path in self.small} | {"map.png", "map.ndf.exr"}
        found = set(os.listdir(self.service.root))
        assert found == expected, f"unexpected or missing files: {sorted(found ^ expected)[:5]}"
        self.slurm.wait_until("Slurm is empty", lambda: not self.slurm.jobs(), timeout=60)
        with open(os.path.join(self.service.data, "instance"), encoding="utf-8") as file:
            place = os.path.join(self.shared, "multum-" + file.read().strip())
        self.slurm.wait_until("the shared folder is empty", lambda: os.listdir(place) == ["task.sh"])
        whole = os.path.join(self.folder, "whole.ndf.exr")
        subprocess.run([self.multum, "bake", self.map, "-o", whole, "--quiet"], check=True)
        with open(whole, "rb") as one, open(self.baked, "rb") as other:
            assert one.read() == other.read(), "the map differs from that of one process"

    def report(self, seconds, metrics):
        ledger = sqlite3.connect(os.path.join(self.service.data, "jobs.sqlite"))
        one = lambda sql: ledger.execute(sql).fetchone()[0]  # noqa: E731
        assert one("PRAGMA integrity_check") == "ok"
        assert one("SELECT COUNT(*) FROM attempts WHERE outcome = 0") == 0, "attempts without an end"
        twice = one("SELECT COUNT(*) FROM (SELECT job FROM attempts WHERE outcome = 1 GROUP BY job "
                    "HAVING COUNT(*) > 1)")
        assert twice == 0, f"{twice} results were published more than once"
        parts = dict(ledger.execute("SELECT state, COUNT(*) FROM slurm_parts GROUP BY state"))
        assert 0 not in parts, f"{parts[0]} parts have no end"
        shares = one("SELECT COUNT(*) FROM slurm_parts WHERE share <> ''")
        rounds = one("SELECT MAX(round) FROM slurm_parts")
        print(json.dumps({
            "small jobs": len(self.small), "map": self.options.map, "seconds": round(seconds, 1),
            "faults": dict(self.done),
            "clock of a node an hour fast": bool(self.faketime) or "no faketime here",
            "folder full": self.is_mounted or "no tmpfs can be mounted here",
            "results, each once": len(self.small) + 1,
            "attempts made again": one("SELECT COUNT(*) FROM attempts WHERE outcome NOT IN (0, 1)"),
            "jobs of Slurm": one("SELECT COUNT(DISTINCT batch) FROM slurm_parts"),
            "parts of the map": shares, "rounds": rounds,
            "parts by end (succeeded, failed, lost, cancelled)": [parts.get(state, 0) for state in range(1, 5)],
            "submitting all small jobs": metrics}, indent=1))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("multum")
    parser.add_argument("--jobs", type=int, default=500)
    parser.add_argument("--map", type=int, default=8192)
    parser.add_argument("--share-seconds", type=float, default=10.0)
    parser.add_argument("--faults", type=int, default=3, help="of each kind")
    parser.add_argument("--timeout", type=float, default=540.0)
    options = parser.parse_args()
    if why_not():
        print(f"skipped: {why_not()}")
        sys.exit(77)
    folder = tempfile.mkdtemp()
    farm = Farm(options, folder)
    try:
        begun = time.monotonic()
        farm.submit()
        time.sleep(3)  # the daemon is sending the last jobs to Slurm
        submitted = farm.service.metric("multum_slurm_submitted_total")
        spent = farm.service.metric("multum_slurm_submit_seconds_total")
        per_job = {"sbatch calls": submitted, "ms a call": round(1000 * spent / max(1, submitted), 1),
                   "ms a job": round(1000 * spent / max(1, len(farm.small)), 2)}
        for _ in range(options.faults):
            for fault in (farm.kill_controller, farm.crash_node, farm.kill_daemon, farm.drain_node, farm.fill_folder):
                fault()
        counts = farm.wait()
        seconds = time.monotonic() - begun
        farm.check(counts)
        assert farm.service.stop() == 0
        farm.report(seconds, per_job)
    finally:
        farm.close()
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
