#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the ledger of the service when it is damaged, rescued, removed, or from another version. Also tests jobs that
need other jobs. MULTUM names the program.

  MULTUM=build/release/bin/multum-drill ledger_test.py [-v] [LedgerTest.test_...]
"""
import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from service_harness import MULTUM, QUICK, ClientCase  # noqa: E402


class LedgerTest(ClientCase):
    checks_answers = True

    def test_a_second_daemon_and_a_damaged_ledger_are_refused(self):
        service = self.start()
        other = subprocess.run([MULTUM, "serve", "--data", service.data, "--root", service.root, "--listen",
                                "127.0.0.1:0"], timeout=30, capture_output=True, text=True, check=False)
        self.assertEqual(other.returncode, 4)
        self.assertIn(service.data, other.stderr)
        service.stop()
        path = os.path.join(service.data, "jobs.sqlite")
        with open(path, "r+b") as file:
            file.seek(100)
            file.write(b"\xee" * 4000)
        service.start(wait=False)
        self.assertEqual(service.process.wait(30), 3)
        self.assertIn("jobs.sqlite", service.log_text().splitlines()[-1])
        self.assertIn("docs/reference/service.md", service.log_text().splitlines()[-1], "and a way out")

    def damage(self):
        """Overwrites the list of tables."""
        with open(os.path.join(self.service.data, "jobs.sqlite"), "r+b") as file:
            file.seek(100)
            file.write(b"\xee" * 3900)

    def test_a_damaged_ledger_is_rescued(self):
        service = self.start()
        done = service.wait_for(self.drill(text="one", output=self.output("a.txt")))
        service.ask("POST", "/v1/queues/default/pause")
        waiting = self.drill(label="still to do")
        service.stop()
        self.damage()
        service.start(wait=False)
        self.assertEqual(service.process.wait(30), 3)
        rescued = subprocess.run([MULTUM, "serve", "--rescue", "--data", service.data], capture_output=True, text=True,
                                 check=True)
        self.assertRegex(rescued.stdout, r"(?m)^jobs +2 rows saved, 0 ")
        self.assertIn("jobs.sqlite.damaged-1", rescued.stdout)
        service.start()
        self.assertEqual(service.job(done["id"])["attempts"], done["attempts"])
        self.assertEqual(service.wait_for(waiting)["label"], "still to do")

    def test_a_ledger_that_is_missing_at_a_start_is_not_begun_anew_by_itself(self):
        service = self.start()
        result = os.path.join(service.data, "results", "a.txt")
        old = self.drill(output=result, text="kept")
        service.wait_for(old)
        service.stop()
        ledger = os.path.join(service.data, "jobs.sqlite")
        os.rename(ledger, os.path.join(self.folder, "away"))
        service.start(wait=False)
        self.assertEqual(service.process.wait(30), 4)
        for words in ("jobs.sqlite", "missing", "multum serve --rescue", "--new-ledger"):
            self.assertIn(words, service.log_text().splitlines()[-1])
        self.assertFalse(os.path.exists(ledger))
        service.options.append("--new-ledger")
        service.start()
        new = self.drill()
        self.assertGreater(new, old, "the log of an old job would become that of a new one")
        service.wait_for(new)
        service.process.send_signal(signal.SIGHUP)
        service.wait_for_log("read again")
        self.client("purge", str(new))
        service.stop()
        service.start(wait=False)
        self.assertEqual(service.process.wait(30), 2, "an existing ledger must not be forgotten")
        service.options.remove("--new-ledger")
        service.start()
        self.assertEqual(self.drill(), new + 1)
        with open(result, encoding="utf-8") as file:
            self.assertEqual(file.read(), "kept\n", "the removed ledger may come back")
        self.assertTrue(os.path.exists(os.path.join(service.data, "logs", f"{old}.log")))

    def test_a_ledger_that_is_taken_away_meanwhile_is_an_alarm(self):
        service = self.start(QUICK + "workers = 2\n")
        done = service.wait_for(self.drill())["id"]
        running = self.drill(1.0)
        service.wait_for(running, ["running"])
        ledger = os.path.join(service.data, "jobs.sqlite")
        for part in ("", "-wal"):
            os.rename(ledger + part, os.path.join(self.folder, "away" + part))
        shutil.copy(os.path.join(self.folder, "away"), ledger)  # another file replaces the ledger
        for _ in range(3):
            self.refused(503, "environment", ["jobs.sqlite", "replaced", "put back"], "POST", "/v1/jobs",
                         {"type": "drill"})
        self.refused(503, "environment", ["jobs.sqlite", "replaced"], "GET", "/readyz")
        with contextlib.closing(service.connection()) as connection:
            connection.request("PUT", "/v1/uploads/a.bin", b"1")
            self.assertEqual(connection.getresponse().status, 503)
        self.assertEqual(service.ask("GET", "/healthz")[0], 200)
        self.assertEqual(service.job(done)["state"], "succeeded", "looking goes on")
        time.sleep(1.5)
        self.assertEqual(service.job(running)["state"], "running", "its end cannot be noted")
        self.assertEqual(service.log_text().count("ALARM"), 1)
        begun = time.monotonic()
        self.assertEqual(service.stop(), 0)
        self.assertLess(time.monotonic() - begun, 10)
        for part in ("", "-wal"):
            os.replace(os.path.join(self.folder, "away" + part), ledger + part)
        service.start()
        job = service.wait_for(running)
        self.assertEqual([one["outcome"] for one in job["attempts"]], ["lost", "succeeded"])
        self.assertEqual(self.drill(), running + 1)

    def test_jobs_of_a_type_that_the_program_lacks_end_as_refused(self):
        service = self.start(QUICK + "workers = 1\n")
        done = self.drill(output=self.output("a.txt"), text="kept")
        service.wait_for(done)
        running, waiting = self.drill(60), self.drill()
        service.wait_for(running, ["running"])
        service.kill()
        service.multum = os.path.join(os.path.dirname(os.path.abspath(MULTUM)), "multum")
        service.start()
        for number in (running, waiting):
            job = service.wait_for(number)
            self.assertEqual(job["state"], "dead")
            self.assertIn('type is "drill", expected one of bake, scene', job["message"])
        self.assertEqual([one["outcome"] for one in job["attempts"]], ["refused"])
        self.assertEqual(service.job(done)["state"], "succeeded")
        self.refused(400, "usage", ["drill"], "POST", "/v1/jobs", {"type": "drill", "parameters": {}})
        self.assertIn("drill", self.client("list"))

    def test_a_retry_reaches_the_roots_and_purged_ones_are_gone(self):
        service = self.start(QUICK + "workers = 1\n")
        root = self.drill(then="refuse")
        service.wait_for(root)
        service.ask("POST", "/v1/queues/default/pause")
        first = self.drill()
        needing = self.drill(needs=[first])
        self.client("cancel", str(first))
        self.assertEqual(service.wait_for(needing)["state"], "dead")
        self.client("retry", str(needing))
        self.assertEqual([service.job(one)["state"] for one in (first, needing)], ["queued", "waiting"])
        self.client("cancel", str(first))
        self.client("purge", str(first))
        self.assertEqual(service.job(needing)["needs"], [first])
        self.refused(409, "need_purged", [f"job {first}", "purged"], "POST", f"/v1/jobs/{needing}/retry")
        self.assertRegex(self.client("retry", "--all-dead"), r"\A1 ")
        self.assertIn(f"job {first}", service.job(needing)["message"])
        self.refused(409, "not_dead", ["queued"], "POST", f"/v1/jobs/{root}/retry")


if __name__ == "__main__":
    unittest.main(verbosity=2)
