#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that several processes that bake a scene give the same files and the same plan as one process, whatever the
number, order and repetition of the shares. Messages name missing, damaged or hostile records, and only these are made
again.

  tests/cli/farms/scene_shares_test.py --programs FOLDER
"""
import json
import pathlib
import tempfile
import unittest

import farm_programs
import merged_shares

MAPS = 3


class SceneSharesTest(merged_shares.MergedSharesTest):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = pathlib.Path(cls.holder.name)
        maps = []
        for i in range(MAPS):
            farm_programs.run("testmap", cls.folder / f"map{i}", "--size", 32, "--seed", i + 1)
            maps.append((f"wall{i}", f"map{i}", f'albedo = "map{i}_albedo.png"' if i % 2 == 0 else ""))
        cls.scenes = {}
        # A target makes the bake choose the number of lobes by trials. If all maps have a common budget, each share
        # plans all maps.
        for name, budget in (("plain", ""), ("target", "[budget]\ntarget_error = 0.3\n"),
                             ("bytes", "[budget]\nbytes = 90000\n")):
            cls.scenes[name] = cls.folder / f"{name}.toml"
            cls.scenes[name].write_text(farm_programs.scene_of(maps, budget))
        cls.wholes = {name: cls.whole_of(scene) for name, scene in cls.scenes.items()}

    @classmethod
    def whole_of(cls, scene):
        out = cls.folder / f"whole-{scene.stem}"
        done = farm_programs.run("bake", scene, "-o", out)
        if done.returncode != 0:
            raise AssertionError(done.stderr)
        return merged_shares.hashes(out)

    def setUp(self):
        super().setUp()
        self.use("plain")

    def use(self, name):
        self.words = ("bake", self.scenes[name])
        self.whole = self.wholes[name]

    def test_any_number_of_shares_makes_the_same_files(self):
        self.assertEqual(sum(name.endswith(".ndf.exr") for name in self.whole), MAPS)
        self.assertIn("plan.json", self.whole)
        self.check_any_number_of_shares()

    def test_targets_and_budgets(self):
        for name in ("target", "bytes"):
            with self.subTest(name):
                self.use(name)
                self.out = self.out.with_name(name)
                for index in (2, 1, 3):
                    self.succeed("--shard", f"{index}/3")
                self.succeed("--merge", 3)
                self.assertEqual(merged_shares.hashes(self.out), self.whole)
        plans = [json.loads((self.folder / f"whole-{name}/plan.json").read_text()) for name in ("plain", "bytes")]
        self.assertLess(plans[1]["bytes"], plans[0]["bytes"])  # the budget changes the result

    def test_the_report_has_what_shares_measured(self):
        self.succeed("--shard", "1-3/3")
        self.succeed("--merge", 3)
        report, expected = (json.loads((folder / "report.json").read_text())
                            for folder in (self.out, self.folder / "whole-plain"))
        self.assertEqual(set(report), set(expected))
        self.assertEqual(report["launches"], expected["launches"])
        for mine, other in zip(report["maps"], expected["maps"], strict=True):
            self.assertEqual(set(mine), set(other))
            self.assertEqual(mine["bake"]["error"], other["bake"]["error"])

    def test_what_is_missing_or_damaged_is_made_again(self):
        self.check_damage("wall1.ndf.exr")

    @staticmethod
    def hostile(content):
        """Returns invalid parts of a record, each as a name and the invalid value."""
        [one] = content["maps"]
        return [("maps", []), ("maps", [one, one]), ("maps", [{**one, "name": "../wall"}]),
                ("maps", [{**one, "row": {"name": "other"}}]), ("maps", [{**one, "baked": 3}])]

    def test_hostile_records(self):
        self.check_hostile_records()

    def test_refusals(self):
        self.check_refusals()

    def test_shares_of_another_scene(self):
        self.succeed("--shard", "1-3/3")
        self.use("bytes")
        self.refused("1-of-3.shard: was made with different inputs, different settings or a different version")


if __name__ == "__main__":
    farm_programs.main()
