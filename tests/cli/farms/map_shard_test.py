#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that several processes that bake one map give the same bytes as one process, whatever the number, order and
repetition of the shares. Messages name shares that are missing, damaged or from another bake, and these are made
again.

  tests/cli/farms/map_shard_test.py --programs FOLDER
"""
import json
import os
import pathlib
import random
import shutil
import struct
import subprocess
import tempfile
import unittest

import farm_programs


def write_tiff(path, width, height):
    """Writes noisy normals with tilts of up to about 14 degrees in 8-bit RGB, uncompressed."""
    pixels = bytearray(128 + (value - 128) // 4 for value in random.Random(7).randbytes(3 * width * height))
    pixels[2::3] = bytes([250]) * (width * height)
    short, long, entries = 3, 4, []
    for tag, kind, value in ((256, long, width), (257, long, height), (258, short, 8), (259, short, 1), (262, short, 2),
                             (273, long, 8), (277, short, 3), (278, long, height), (279, long, len(pixels))):
        entries.append(struct.pack("<HHII", tag, kind, 1, value))
    directory = struct.pack("<H", len(entries)) + b"".join(entries) + bytes(4)
    path.write_bytes(b"II*\0" + struct.pack("<I", 8 + len(pixels)) + pixels + directory)


class MapShardTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.maps = pathlib.Path(cls.holder.name)
        for size in (256, 250):
            farm_programs.run("testmap", cls.maps / f"map{size}", "--size", size)

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        self.output = self.folder / "shared.ndf.exr"

    def bake(self, *words, size=256, output=None):
        return farm_programs.run("bake", self.maps / f"map{size}_normal.png", "-o", output or self.output, *words)

    def succeed(self, *words, **more):
        done = self.bake(*words, **more)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def share(self, index, count):
        return self.folder / f"shared.ndf.exr.shard-{index}-of-{count}"

    def test_any_number_of_shares_makes_the_same_file(self):
        albedo = self.maps / "map256_albedo.png"
        for size, count, order, words in ((256, 2, (0, 2, 1), ()), (256, 5, (0, 5, 3, 1, 2, 4, 2), ()),
                                          (250, 3, (0, 2, 3, 1), ("--wrap", "clamp")),
                                          (256, 3, (0, 1, 2, 3), ("--wrap", "periodic", "--lobes", 2)),
                                          (256, 2, (0, 1, 2), ("--albedo", albedo, "--memory", "300M")),
                                          (256, 2, (0, 1, 2), ("--ndf", "gmm")),
                                          (256, 2, (0, 2, 1), ("--first-level", 2, "--data-format", "half"))):
            with self.subTest(size=size, count=count, words=words):
                whole = self.folder / "whole.ndf.exr"
                self.succeed(*words, size=size, output=whole)
                for index in order:
                    self.succeed(*words, "--shard", f"{index}/{count}", size=size)
                self.assertFalse(self.output.exists())
                self.succeed(*words, "--merge", count, size=size)
                self.assertEqual(self.output.read_bytes(), whole.read_bytes())
                self.assertEqual(sorted(path.name for path in self.folder.iterdir()), [self.output.name, whole.name])
                self.output.unlink()
                whole.unlink()

    def test_rows_longer_than_a_block_of_a_share(self):
        wide = self.maps / "wide.tif"
        write_tiff(wide, 12288, 160)
        whole, words = self.folder / "whole.ndf.exr", ("--lobes", 2, "--first-level", 1, "--no-measure", "--quiet")

        def bake(output, *more):
            done = farm_programs.run("bake", wide, "-o", output, "--albedo", wide, *words, *more)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

        bake(whole)
        for index in range(3):
            bake(self.output, "--shard", f"{index}/2")
        bake(self.output, "--merge", 2)
        self.assertEqual(self.output.read_bytes(), whole.read_bytes())

    def test_a_band_knows_a_map_that_has_changed(self):
        source = self.maps / "changing_normal.png"
        shutil.copy(self.maps / "map256_normal.png", source)
        words = ("-o", self.output, "--shard")
        self.assertEqual(farm_programs.run("bake", source, *words, "0/2").returncode, 0)
        times = source.stat()
        # Only the modification time has changed, so the hash is the same.
        os.utime(source, ns=(times.st_atime_ns, times.st_mtime_ns + 10**9))
        self.assertEqual(farm_programs.run("bake", source, *words, "1/2").returncode, 0)
        shutil.copy(self.maps / "map250_normal.png", source)
        done = farm_programs.run("bake", source, *words, "2/2")
        self.assertEqual(done.returncode, 4)
        self.assertIn("belongs to another map", done.stderr)
        done = farm_programs.run("bake", source, "-o", self.output, "--merge", 2)
        self.assertEqual(done.returncode, 4)
        for index in (0, 1):
            self.assertIn(f"--shard {index}/2 makes it", done.stderr)

    def test_shares_that_are_there_are_not_baked_again(self):
        self.succeed("--shard", "0/2")
        before = self.share(0, 2).stat()
        self.assertIn("unchanged", self.succeed("--shard", "0/2").stdout)
        self.assertEqual(self.share(0, 2).stat().st_mtime_ns, before.st_mtime_ns)
        self.assertIn("written", self.succeed("--shard", "0/2", "--force").stdout)
        self.assertIn("written", self.succeed("--shard", "0/2", "--lobes", 3).stdout)  # this is a share of another bake

    def test_what_is_missing_or_damaged_is_named_and_made_again(self):
        self.succeed(output=self.folder / "whole.ndf.exr")
        done = self.bake("--shard", "1/3")  # share 1 runs before share 0, which makes the coarse levels
        self.assertEqual(done.returncode, 4)
        self.assertIn("shared.ndf.exr.shard-0-of-3: does not exist", done.stderr)
        self.assertIn("--shard 0/3 makes it", done.stderr)
        for index in (0, 1, 3):
            self.succeed("--shard", f"{index}/3")
        self.share(1, 3).write_bytes(self.share(1, 3).read_bytes()[:-9])
        done = self.bake("--merge", 3)
        self.assertEqual(done.returncode, 4)
        self.assertIn("--shard 1/3 makes it", done.stderr)
        self.assertIn("shared.ndf.exr.shard-2-of-3: does not exist", done.stderr)
        self.assertFalse(self.output.exists())
        for index in (1, 2):
            self.succeed("--shard", f"{index}/3")
        damaged = bytearray(self.share(3, 3).read_bytes())
        damaged[len(damaged) // 2] ^= 1
        self.share(3, 3).write_bytes(damaged)
        done = self.bake("--merge", 3)
        self.assertEqual(done.returncode, 4)
        self.assertRegex(done.stderr, r"shared\.ndf\.exr\.shard-3-of-3: rows \d+ to \d+ of level \d+ are damaged")
        self.succeed("--shard", "3/3", "--force")
        self.succeed("--merge", 3)
        self.assertEqual(self.output.read_bytes(), (self.folder / "whole.ndf.exr").read_bytes())
        # The merge has finished and has removed the shares.
        self.assertIn("unchanged", self.succeed("--merge", 3).stdout)

    def test_shares_of_another_bake_are_refused(self):
        for index in range(3):
            self.succeed("--shard", f"{index}/2")
        for words, size in ((("--lobes", 3), 256), ((), 250)):
            done = self.bake(*words, "--merge", 2, size=size)
            self.assertEqual(done.returncode, 4, done.stdout + done.stderr)
            self.assertIn("belongs to another map, other settings, or another version", done.stderr)

    def test_a_share_is_whole_or_not_there(self):
        self.succeed("--shard", "0/2")
        hostile = self.share(0, 2).read_bytes()
        for change in (lambda b: b[:20], lambda b: b[:-8] + b"\xff" * 8, lambda b: b"x" + b[1:], lambda b: b[:-200],
                       lambda b: b[:-8] + (1).to_bytes(8, "little"), lambda b: b""):
            self.share(0, 2).write_bytes(change(hostile))
            done = self.bake("--shard", "1/2")
            self.assertEqual(done.returncode, 4, done.stderr)
            self.assertFalse(self.share(1, 2).exists())
        former = bytes(range(1, 65)) + b"key\n\n" + bytes(8) + b"multum shard 3\n"
        self.share(0, 2).write_bytes(former)
        for words in (("--shard", "1/2"), ("--merge", 2)):
            done = self.bake(*words)
            self.assertEqual(done.returncode, 4, done.stderr)
            self.assertRegex(done.stderr, "shard-0-of-2: .*another version of multum.*--shard 0/2 makes it")
        self.assertFalse([path for path in self.folder.iterdir() if "tmp" in path.name])

    def test_refusals(self):
        for words, expected in ((("--shard", "1/1"), "expected a share I/N of one map"),
                                (("--shard", "3/2"), "expected a share I/N of one map"),
                                (("--shard", "1-2/2"), "expected a share I/N of one map"),
                                (("--shard", "0/64"), "--shard has 64 bands, expected fewer"),
                                (("--shard", "0/2", "--lobes", 1), "plain average"),
                                (("--shard", "1/2", "--refine"), "--refine"),
                                (("--merge", 2, "--refine"), "--refine"),
                                (("--shard", "1/2", "--ndf", "sh"), "expected vMF lobes"),
                                (("--shard", "1/2", "--merge", 2), "are mutually exclusive"),
                                (("--merge", 2, "--target-error", "0.1"), "are mutually exclusive")):
            with self.subTest(words=words):
                done = self.bake(*words)
                self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                self.assertIn(expected, done.stderr)
                self.assertFalse(list(self.folder.iterdir()))

    def plan(self, *words, size=256):
        return farm_programs.run("plan", self.maps / f"map{size}_normal.png", *words)

    def test_times_of_shares_are_planned(self):
        done = self.plan("--shards", 3, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        plan = json.loads(done.stdout)
        self.assertEqual((plan["width"], plan["height"], plan["shares"], len(plan["band_seconds"])), (256, 256, 3, 3))
        for seconds in (plan["coarse_seconds"], plan["merge_seconds"], *plan["band_seconds"]):
            self.assertTrue(0.0 < seconds < plan["processor_seconds"], plan)
        fewer = json.loads(self.plan("--shards", 3, "--json", "--lobes", 2, "--no-measure").stdout)
        self.assertLess(fewer["merge_seconds"], plan["merge_seconds"])
        self.assertLess(fewer["band_seconds"][1], plan["band_seconds"][1])
        text = self.plan("--shards", 3).stdout
        for words in ("--shard 0/3", "--shard 3/3", "--merge 3", "one process"):
            self.assertIn(words, text)

    def test_as_many_shares_are_planned_as_are_worth_it(self):
        whole = json.loads(self.plan("--share-seconds", 0, "--json").stdout)
        self.assertEqual((whole["shares"], "band_seconds" in whole), (0, False))
        half = 0.6 * whole["processor_seconds"]
        self.assertEqual(json.loads(self.plan("--share-seconds", half, "--json").stdout)["shares"], 2)
        # The plan never has more shares than the map can be divided into. It has no shares for a bake that cannot be
        # divided.
        many = json.loads(self.plan("--share-seconds", 0.001, "--json").stdout)["shares"]
        self.assertEqual(self.plan("--shards", many).returncode, 0)
        self.assertEqual(self.plan("--shards", many + 1).returncode, 2)
        for words in (("--refine",), ("--ndf", "sh"), ("--lobes", 1), ("--target-error", "0.1")):
            plan = json.loads(self.plan("--share-seconds", half, "--json", *words).stdout)
            self.assertEqual(plan["shares"], 0, words)
            self.assertEqual(self.plan("--shards", 2, *words).returncode, 2, words)

    def test_a_share_that_is_killed_leaves_nothing_in_the_way(self):
        shutil.copy(self.maps / "map256_normal.png", self.folder / "a.png")
        self.succeed("--shard", "0/2")
        words = ["bake", self.maps / "map256_normal.png", "-o", self.output, "--shard", "1/2"]
        child = subprocess.Popen([farm_programs.multum(), *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        child.kill()
        child.wait()
        self.assertFalse(self.share(1, 2).exists())
        for index in (1, 2):
            self.succeed("--shard", f"{index}/2")
        self.succeed("--merge", 2)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["a.png", self.output.name])


if __name__ == "__main__":
    farm_programs.main()
