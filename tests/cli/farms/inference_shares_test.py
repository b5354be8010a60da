#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that texture inference by several processes gives the same textures, matrices and manifest as one process,
whatever the number, order and repetition of the shares. Messages name missing, damaged or hostile records, and only
these are made again.

  tests/cli/farms/inference_shares_test.py --programs FOLDER --traced-folder PROGRAM
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import farm_programs
import merged_shares

at = sys.argv.index("--traced-folder")
TRACED_FOLDER = sys.argv[at + 1]
del sys.argv[at:at + 2]


class InferenceSharesTest(merged_shares.MergedSharesTest):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = pathlib.Path(cls.holder.name)
        (cls.folder / "renders").mkdir()
        subprocess.run([TRACED_FOLDER, cls.folder / "renders", "3", "2"], check=True)
        cls.job = cls.folder / "animation.toml"
        done = farm_programs.run("animation", cls.folder / "renders", "-o", cls.job)
        if done.returncode != 0:
            raise AssertionError(done.stderr)
        # Two blocks of views give 2 objects x 2 layers x 2 blocks.
        text = cls.job.read_text()
        views = "view = true  # moves the camera\nblock = 0"
        assert views in text
        cls.job.write_text(text.replace(views, "view = true\nblock = 2"))
        cls.words = ("infer", cls.job, "--context", "osmesa", "--no-frames", "--no-comparison",
                     "--absolute-geometry")
        done = farm_programs.run(*cls.words, "-o", cls.folder / "whole")
        if done.returncode != 0:
            raise AssertionError(done.stderr)
        cls.whole = merged_shares.hashes(cls.folder / "whole")

    def report(self, folder):
        report = json.loads((folder / "report.json").read_text())
        for name in ("seconds", "matrices_measured"):  # Two shares may measure the same filter matrices.
            report.pop(name)
        return report

    def test_any_number_of_shares_makes_the_same_files(self):
        self.assertGreater(sum(name.startswith("textures/") for name in self.whole), 8)
        self.assertGreater(sum(name.endswith(".fmx") for name in self.whole), 5)
        self.check_any_number_of_shares()

    def test_the_report_is_that_of_one_run(self):
        for index in (3, 1, 4, 2):
            self.succeed("--shard", f"{index}/4")
        self.succeed("--merge", 4)
        self.assertEqual(self.report(self.out), self.report(self.folder / "whole"))

    def test_more_shares_than_there_is_to_infer(self):
        for shares in ("7-12/12", "1-6/12"):
            self.succeed("--shard", shares)
        self.succeed("--merge", 12)
        self.assertEqual(merged_shares.hashes(self.out), self.whole)

    def test_shares_at_the_same_time(self):
        words = [farm_programs.multum(), *map(str, self.words), "-o", self.out]
        running = [subprocess.Popen([*words, "--shard", f"{i}/3"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                    text=True) for i in (1, 2, 3, 2)]
        for one in running:
            _, said = one.communicate()
            self.assertEqual(one.returncode, 0, said)
        self.succeed("--merge", 3)
        self.assertEqual(merged_shares.hashes(self.out), self.whole)

    def test_what_is_missing_or_damaged_is_made_again(self):
        self.succeed("--shard", "2/3")
        inferred = sorted(path for path in (self.out / "textures").rglob("*.exr"))
        name = str(inferred[0].relative_to(self.out))
        self.record(2).unlink()
        self.check_damage(name)

    @staticmethod
    def hostile(content):
        """Returns invalid parts of a record, each as a name and the invalid value."""
        one = next(texture for texture in content["textures"] if texture["sha256"])
        others = [texture for texture in content["textures"] if texture is not one]
        return [("textures", others), ("textures", [*content["textures"], one]), ("seconds", [1]),
                *(("textures", [*others, {**one, **change}]) for change in (
                    {"object": 99}, {"point": -1}, {"layer": 1 << 40}, {"errors": []}, {"pixels": [0.5] * 1000},
                    {"iterations": 1 << 60}, {"history": [[1, 2, 3]]}, {"sha256": 5}))]

    def test_hostile_records(self):
        self.check_hostile_records()

    def test_refusals(self):
        self.check_refusals()

    def test_shares_of_other_pictures_or_settings(self):
        self.succeed("--shard", "1-3/3")
        words = type(self).words
        self.words = (*words, "--tolerance", "0.01")
        self.refused("1-of-3.shard: was made with different inputs, "
                     "different settings or a different version", "3-of-3.shard")
        self.words = words
        picture = self.folder / "renders/rad_v02_p01.exr"
        before = picture.read_bytes()
        self.addCleanup(picture.write_bytes, before)
        picture.write_bytes((self.folder / "renders/rad_v02_p00.exr").read_bytes())
        self.refused("3-of-3.shard: was made with different inputs, different settings or a different version")


if __name__ == "__main__":
    farm_programs.main()
