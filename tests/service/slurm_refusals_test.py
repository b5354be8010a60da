#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests refusals of sbatch. Arrays beyond MaxArraySize are divided into smaller arrays. A job that Slurm never accepts
ends once, with Slurm's message. A job that Slurm does not accept at the moment waits. Runs with a stand-in for Slurm's
commands (stand_in_slurm.py), and with a real Slurm if one can be started (slurm_harness.py). MULTUM names the program.

  MULTUM=build/release/bin/multum slurm_refusals_test.py [-v] [StandInTest.test_...]
"""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from service_harness import MULTUM, ClientCase  # noqa: E402
from slurm_harness import Slurm, why_not  # noqa: E402

NOT_HERE = why_not()
CONFIG = """
workers = 1
back_off_first_s = 0.05
back_off_max_s = 0.2
[[queue]]
name = "default"
[[queue]]
name = "farm"
[slurm]
folder = "{folder}"
queues = ["farm"]
cpus = 1
poll_s = 0.1
visible_s = 0.5
share_s = 0.2
"""
ACCOUNT = "Invalid account or account/partition combination specified"


class RefusalCase(ClientCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.holder)
        cls.map = os.path.join(cls.holder, "map.png")  # the file contains its own name
        subprocess.run([MULTUM, "testmap", os.path.join(cls.holder, "map"), "--size", "256"], check=True,
                       capture_output=True)
        os.rename(os.path.join(cls.holder, "map_normal.png"), cls.map)
        cls.whole = os.path.join(cls.holder, "whole.ndf.exr")
        subprocess.run([MULTUM, "bake", cls.map, "-o", cls.whole, "--no-measure"], check=True, capture_output=True)

    def start_with(self, environment, more=""):
        shared = os.path.join(self.folder, "shared")
        os.mkdir(shared, mode=0o700)
        service = self.start(config=CONFIG.format(folder=shared) + more, environment=environment)
        shutil.copy(self.map, os.path.join(service.root, "map.png"))
        return service

    def bake(self, **job):
        return self.service.submit(type="bake", parameters={"input": os.path.join(self.service.root, "map.png"),
                                                            "no_measure": True},
                                   queue="farm", output=self.output("map.ndf.exr"), **job)

    def succeed(self, number):
        """Returns the parts of the job. Checks that the result equals the result of one process."""
        job = self.service.wait_for(number)
        self.assertEqual((job["state"], len(job["attempts"])), ("succeeded", 1), self.service.log_text()[-2000:])
        with open(self.output("map.ndf.exr"), "rb") as mine, open(self.whole, "rb") as other:
            self.assertEqual(mine.read(), other.read())
        return job["parts"]

    def check_bands(self, parts, array_max):
        """Checks that each band succeeded once, in arrays that Slurm accepts."""
        done = [part for part in parts if part["state"] == "succeeded"]
        count = int(done[0]["part"].split("/")[1])
        self.assertGreater(count, array_max)  # otherwise the map would not be split
        self.assertEqual([part["round"] for part in parts], [1] * len(parts))
        self.assertEqual(sorted(part["part"] for part in done),
                         sorted([f"{i}/{count}" for i in range(count + 1)] + [f"merge {count}"]))
        bands = [part for part in done if not part["part"].startswith(("0/", "merge"))]
        arrays = {part["slurm_job"] for part in bands}
        self.assertGreaterEqual(len(arrays) * array_max, count)
        for part in bands:
            self.assertLess(part["item"], array_max)


class StandInTest(RefusalCase):
    def start_stand_in(self, refusals="", array_max=1001, more=""):
        self.stand_in = os.path.join(self.folder, "slurm")
        programs = os.path.join(self.folder, "bin")
        os.mkdir(self.stand_in)
        os.mkdir(programs)
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "stand_in_slurm.py")
        for name in ("sbatch", "squeue", "scancel"):
            with open(os.path.join(programs, name), "w", encoding="utf-8") as file:
                file.write(f'#!/bin/sh\nexec {sys.executable} {script} {name} "$@"\n')
            os.chmod(os.path.join(programs, name), 0o755)
        with open(os.path.join(programs, "scontrol"), "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\nexit 1\n")  # scontrol fails, so the limit is not known
        os.chmod(os.path.join(programs, "scontrol"), 0o755)
        for name, text in (("refusals", refusals), ("array_max", str(array_max))):
            with open(os.path.join(self.stand_in, name), "w", encoding="utf-8") as file:
                file.write(text)
        return self.start_with({"PATH": programs + ":" + os.environ["PATH"], "SLURM_STAND_IN": self.stand_in}, more)

    def calls(self):
        with open(os.path.join(self.stand_in, "calls"), encoding="utf-8") as file:
            return file.read().split()

    def test_arrays_are_halved_until_they_are_taken(self):
        self.start_stand_in(array_max=2)
        parts = self.succeed(self.bake())
        self.check_bands(parts, 2)
        refused = [part for part in parts if part["state"] == "lost"]
        self.assertTrue(refused)
        self.assertIn("sent again in a smaller array", refused[0]["message"])
        # There is a call for share 0, for each half that was too long, for each array, and for the merge.
        arrays = [call for call in self.calls() if call != "-"]
        too_long = [call for call in arrays if max(map(int, call.split(","))) >= 2]
        self.assertEqual(len(set(len(call.split(",")) for call in too_long)), len(too_long), "each length once")

    def test_what_is_never_taken_ends_once(self):
        self.start_stand_in(f"{ACCOUNT}\n*\n")
        job = self.service.wait_for(self.bake())
        self.assertEqual((job["state"], job["exit_code"], len(job["attempts"])), ("dead", 2, 1), job["message"])
        self.assertIn(ACCOUNT, job["message"])
        self.assertEqual(self.calls(), ["-"])

    def test_what_is_never_taken_ends_what_was(self):
        self.start_stand_in(f"\n{ACCOUNT}\n*\n")  # share 0 is accepted
        job = self.service.wait_for(self.bake())
        self.assertEqual((job["state"], job["exit_code"], len(job["attempts"])), ("dead", 2, 1), job["message"])
        self.assertIn(ACCOUNT, job["message"])
        self.assertEqual([call == "-" for call in self.calls()], [True, False])

    def test_an_array_that_is_never_taken(self):
        self.start_stand_in(array_max=0)
        job = self.service.wait_for(self.bake())
        self.assertEqual((job["state"], job["exit_code"], len(job["attempts"])), ("dead", 2, 1), job["message"])
        self.assertIn("Invalid job array specification", job["message"])
        self.assertLess(len(self.calls()), 8)

    def test_what_is_not_taken_now_waits(self):
        self.start_stand_in("Unable to contact slurm controller (connect failure)\n" * 2 +
                            "Slurm temporarily unable to accept job, sleeping and retrying\n" * 2)
        self.succeed(self.bake())
        self.assertEqual(self.calls()[:5], ["-"] * 5)  # four refusals, which is one more than is allowed for unknown
                                                       # reasons

    def test_reasons_unknown_end_the_attempt(self):
        self.start_stand_in("A text of another version\n*\n")
        job = self.service.wait_for(self.bake(attempt_max=2))
        self.assertEqual((job["state"], job["exit_code"], len(job["attempts"])), ("dead", 4, 2), job["message"])
        self.assertIn("A text of another version", job["message"])
        self.assertEqual(len(self.calls()), 6)  # three tries for each attempt


@unittest.skipIf(NOT_HERE, NOT_HERE)
class RealSlurmTest(RefusalCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.slurm = Slurm(os.path.join(cls.holder, "slurm"), more="MaxArraySize=2\n")
        cls.addClassCleanup(cls.slurm.stop)
        cls.slurm.start()

    def tearDown(self):
        self.slurm.run("scancel", "--user=root")
        super().tearDown()

    def test_arrays_are_as_long_as_slurm_says(self):
        self.start_with(self.slurm.environment)
        self.check_bands(self.succeed(self.bake()), 2)
        self.assertNotIn("not sent to Slurm", self.service.log_text())

    def test_an_account_that_is_not_there(self):
        self.start_with(self.slurm.environment, 'arguments = ["--qos=nowhere", "--partition=nowhere"]\n')
        job = self.service.wait_for(self.bake())
        self.assertEqual((job["state"], job["exit_code"], len(job["attempts"])), ("dead", 2, 1), job["message"])
        self.assertIn("sbatch: ", job["message"])


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    unittest.main()
