#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kills workers and the daemon (kill -9) during many small jobs that write one file each. No job may be lost, no
result may be published twice, no half-written file may be left, and no job may stay "running".

  fault_injection/kills.py MULTUM_DRILL [--jobs 2000] [--worker-kills 200] [--daemon-kills 20]
"""
import argparse
import glob
import os
import random
import signal
import sqlite3
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from service_harness import Service  # noqa: E402

CONFIG = """
workers = 4
back_off_first_s = 0.01
back_off_max_s = 0.1
"""


def submit_all(service, count):
    connection = service.connection()
    for number in range(count):
        output = os.path.join(service.root, f"{number % 10}", f"{number}.txt")
        os.makedirs(os.path.dirname(output), exist_ok=True)
        status, answer = service.ask(
            "POST", "/v1/jobs",
            {"type": "drill", "parameters": {"seconds": 0.05, "text": f"job {number}"}, "output": output,
             "attempt_max": 100}, connection=connection)
        assert status == 201, answer
    connection.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("multum")
    parser.add_argument("--jobs", type=int, default=2000)
    parser.add_argument("--worker-kills", type=int, default=200)
    parser.add_argument("--daemon-kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=7)
    options = parser.parse_args()
    random.seed(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        service = Service(options.multum, folder, config=CONFIG).start()
        submit_all(service, options.jobs)
        kills = ["worker"] * options.worker_kills + ["daemon"] * options.daemon_kills
        random.shuffle(kills)
        done = {"worker": 0, "daemon": 0}
        longest_restart = 0.0
        for kill in kills:
            time.sleep(random.uniform(0.02, 0.3))
            if kill == "worker":
                workers = service.workers()
                deadline = time.monotonic() + 10
                while not workers and time.monotonic() < deadline:
                    time.sleep(0.01)
                    workers = service.workers()
                assert workers, f"no workers for 10 s after {done}: {service.log_text()[-1500:]} {service.counts()}"
                try:
                    os.kill(random.choice(workers), signal.SIGKILL)
                except ProcessLookupError:
                    continue
            else:
                service.kill()
                begun = time.monotonic()
                service.start()
                # A job that an earlier daemon started must not count as running if it has no worker.
                running = service.counts()["running"]
                longest_restart = max(longest_restart, time.monotonic() - begun)
                assert running <= 4, f"{running} jobs count as running after a restart"
            done[kill] += 1
        counts = service.wait_until_idle()
        attempts_lost = 0
        code = service.stop()
        assert code == 0, f"the daemon ended with {code}"

        assert counts["succeeded"] == options.jobs, f"lost: {counts}"
        names = sorted(glob.glob(os.path.join(service.root, "*", "*.txt")))
        assert len(names) == options.jobs, f"{len(names)} results of {options.jobs}"
        for name in names:
            number = os.path.basename(name)[:-4]
            with open(name, encoding="utf-8") as file:
                text = file.read()
            assert text == f"job {number}\n", f"{name} holds {text!r}"
        left = [path for path in glob.glob(os.path.join(service.root, "*", ".*"))]
        assert not left, f"left behind: {left[:5]}"
        ledger = sqlite3.connect(os.path.join(service.data, "jobs.sqlite"))
        assert ledger.execute("PRAGMA integrity_check").fetchone()[0] == "ok"
        twice = ledger.execute(
            "SELECT job, COUNT(*) FROM attempts WHERE outcome = 1 GROUP BY job HAVING COUNT(*) <> 1").fetchall()
        assert not twice, f"published more than once: {twice[:5]}"
        attempts_lost = ledger.execute("SELECT COUNT(*) FROM attempts WHERE outcome = 4").fetchone()[0]
        unended = ledger.execute("SELECT COUNT(*) FROM attempts WHERE outcome = 0").fetchone()[0]
        assert unended == 0, f"{unended} attempts have no end"
        print(f"{options.jobs} jobs, {done['worker']} workers and {done['daemon']} daemons killed: all results in "
              f"place, once each; {attempts_lost} attempts lost and repeated; restart within "
              f"{longest_restart:.2f} s")


main()
