#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs multum-farm-simulation with some hundred maps. Every map must be finished, whatever fails. Also tests the page
that tools/lab/farm_document.py makes from such runs.

  farm_simulation_test.py SIMULATION
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/lab"))
import farm_document  # noqa: E402

PROGRAM = ""


class FarmSimulationTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        self.count = 0

    def simulate(self, *options):
        self.count += 1
        folder = self.folder / str(self.count)
        folder.mkdir()
        result = self.folder / f"{self.count}.json"
        done = subprocess.run([PROGRAM, "--folder", folder, "-o", result, *options], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(result.read_text())

    def test_every_map_ends(self):
        run = self.simulate("--maps", "600", "--nodes", "20", "--jobs", "100", "--fail", "0.2", "--refuse", "0.02",
                            "--node-hours", "0.5")
        self.assertEqual(set(run["states"]), {"succeeded", "dead"})
        self.assertEqual(sum(run["states"].values()), 600)
        self.assertLess(run["states"]["dead"], 40)
        self.assertGreater(run["failed_attempts"], 60)
        self.assertGreater(run["node_failures"], 5)
        self.assertTrue(0.1 < run["busy_share"] <= 1.0, run)
        self.assertEqual([row["when"] for row in run["page"]], ["full", "half", "done"])

    def test_nodes_that_do_not_fail_are_kept_at_work(self):
        options = ("--maps", "600", "--nodes", "10", "--fail", "0", "--refuse", "0", "--node-hours", "1e9")
        run = self.simulate(*options, "--jobs", "600")
        self.assertEqual(run["states"], {"succeeded": 600})
        self.assertEqual((run["failed_attempts"], run["node_failures"]), (0, 0))
        self.assertGreater(run["busy_share"], 0.8)
        # Some nodes do not get a job.
        self.assertLess(self.simulate(*options, "--jobs", "5")["busy_share"], 0.55)

    def test_lists_of_folders_are_quicker_than_files_one_by_one(self):
        options = ("--maps", "600", "--nodes", "20", "--jobs", "600")
        each = self.simulate(*options, "--ask-for-each")["look_median_s"]
        self.assertLess(self.simulate(*options)["look_median_s"], 0.8 * each)

    def test_the_page(self):
        run = self.simulate("--maps", "60", "--nodes", "5")
        text = farm_document.page_text([run] * len(farm_document.RUNS), 60, 5, "commit of a test")
        for expected in ("# A farm of 5 nodes", "commit of a test", "bakes 60 maps", "one map is 20 s", "| all |"):
            self.assertIn(expected, text)

    def test_refusals(self):
        (self.folder / "jobs.sqlite").write_text("")
        for options, code, expected in ((("--nodes", "0"), 2, "--nodes is 0"), (("--fail", "2"), 2, "--fail"),
                                        ((), 3, "has a jobs.sqlite")):
            done = subprocess.run([PROGRAM, "--folder", self.folder, "-o", self.folder / "none.json", *options],
                                  capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(expected, done.stderr)
            self.assertFalse((self.folder / "none.json").exists())


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
