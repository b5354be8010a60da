#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes each system call with which the daemon writes files fail once, while jobs end and their results are published.
One result is a file, and one is a folder that replaces an earlier result. Whatever fails, the daemon must survive or
be able to start again, the job must succeed without help, its result must be complete, and no other file may remain
next to it.

  fault_injection/failed_calls.py MULTUM_DRILL SHIM [--every 1]
"""
import argparse
import errno
import mmap
import os
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from service_harness import Service, fail  # noqa: E402

ERRORS = (errno.EIO, errno.ENOSPC, errno.EMFILE, errno.ENOMEM)
SCENE = ('[[map]]\nname = "m"\nnormal = "map_normal.png"\ngreen = "up"\n[[material]]\nname = "p"\nbrdf = "lambert"\n'
         '[[object]]\nname = "o"\nmap = "m"\nmaterial = "p"\nwidth = 1\ndistance = [1, 2]\n[[light]]\n'
         'direction = [0, 0, 1]\n')


class Faults:
    """The memory that this test shares with the shim."""

    def __init__(self, path):
        with open(path, "wb") as file:
            file.write(bytes(32))
        self.file = open(path, "r+b")
        self.memory = mmap.mmap(self.file.fileno(), 32)

    def order(self, call, error):
        self.memory[:] = struct.pack("4q", call, error, 0, 0)

    def seen(self):
        """Returns the number of calls, and of failed ones."""
        return struct.unpack("4q", self.memory[:])[2:]


def job_of(kind, root, number):
    if kind == "file":
        return {"type": "drill", "parameters": {"seconds": 0.05, "text": f"text {number}"},
                "output": os.path.join(root, f"{number}.txt")}
    return {"type": "scene", "parameters": {"scene": os.path.join(root, "scene.toml")}, "again": True,
            "output": os.path.join(root, "baked")}


def check_result(kind, root, number, job):
    if job["state"] != "succeeded":
        fail(f"{kind}: job {job['id']} is {job['state']}: {job['message']}")
    if kind == "file":
        with open(job["output"], encoding="utf-8") as file:
            text = file.read()
        if text.strip() != f"text {number}":
            fail(f"{kind}: its result holds {text!r}")
    elif not {"plan.json"} <= set(os.listdir(job["output"])):
        fail(f"{kind}: its result is incomplete: {os.listdir(job['output'])}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("multum")
    parser.add_argument("shim")
    parser.add_argument("--every", type=int, default=1, help="fail only every Nth call")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        faults = Faults(os.path.join(folder, "faults"))
        service = Service(options.multum, folder, config="back_off_first_s = 0.02\nback_off_max_s = 0.1\n",
                          environment={"LD_PRELOAD": options.shim, "MULTUM_FAULTS": faults.file.name}).start()
        root = service.root
        subprocess.run([options.multum, "testmap", os.path.join(root, "map"), "--size", "16"], check=True,
                       stdout=subprocess.DEVNULL)
        with open(os.path.join(root, "scene.toml"), "w", encoding="utf-8") as file:
            file.write(SCENE)
        number = restarts = failed = 0
        for kind in ("file", "folder"):
            service.wait_for(service.submit(**job_of(kind, root, "first")))
            for error in ERRORS:
                call = 1
                while True:
                    number += 1
                    job = service.submit(**job_of(kind, root, number))
                    faults.order(call, error)
                    deadline = time.monotonic() + 60
                    while True:
                        if service.process.poll() is not None:  # the daemon may end, but it must be able to start again
                            faults.order(0, 0)
                            restarts += 1
                            service.start()
                        try:
                            state = service.job(job)
                        except (AssertionError, OSError):  # the daemon answers 503, or has just ended
                            state = {"state": "unknown"}
                        if state["state"] in ("succeeded", "dead", "cancelled"):
                            break
                        if time.monotonic() > deadline:
                            fail(f"{kind}, call {call}, {os.strerror(error)}: job {job} stays {state}: "
                                 f"{service.log_text()[-1500:]}")
                        time.sleep(0.005)
                    calls, hit = faults.seen()
                    faults.order(0, 0)
                    check_result(kind, root, number, state)
                    failed += hit
                    if call > calls:  # the job made fewer calls than this
                        break
                    call += options.every
        service.stop()
        service.start()  # a restart cleans up
        left = [name for name in os.listdir(root) if name.startswith(".multum")]
        if left:
            fail(f"left behind: {left}")
        service.stop()
        print(f"{number} jobs, {failed} failed calls, {restarts} restarts of the daemon")
        if failed < 20:
            fail("almost no call failed: the shim is not loaded")


if __name__ == "__main__":
    main()
