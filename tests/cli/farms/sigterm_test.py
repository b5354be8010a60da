#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What SIGTERM leaves of every command (docs/FARMS.md, the table of that name): exit code 130 well within a farm's
period of grace, nothing half-written, and the same command again makes what an undisturbed run made.

  tests/cli/farms/sigterm_test.py --programs FOLDER --traced-folder PROGRAM
"""
import dataclasses
import hashlib
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import farm_programs

at = sys.argv.index("--traced-folder")
TRACED_FOLDER = sys.argv[at + 1]
del sys.argv[at:at + 2]

GRACE_SECONDS = 30  # of a farm; a quarter of it must do
SIZE = 256


@dataclasses.dataclass
class Row:
    """A command. `out` in its words stands for the folder of its results."""
    name: str
    words: tuple
    keeps: tuple = ()   # beginnings of names, hidden ones too, that may be there when it was stopped
    before: tuple = ()  # commands that make what it works on in `out`
    timed: tuple = ("report.json", "report.html")  # results that have times in them, and differ from run to run


MAP = ("{maps}/map_normal.png",)
ROWS = (
    Row("bake", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--resume"), (".multum-partial-",)),
    Row("bake gmm", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--ndf", "gmm", "--resume"), (".multum-partial-",)),
    Row("bake refine", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--refine", "--resume"), (".multum-partial-",)),
    Row("bake target", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--target-error", "0.5", "--resume"),
        (".multum-partial-",)),
    Row("bake several", ("bake", "{maps}/map_normal.png", "{maps}/second_normal.png", "-o", "{out}", "--resume"),
        (".multum-partial-", "map_normal.ndf.exr")),
    Row("bake manifest", ("bake", "--manifest", "{out}/maps.toml", "--resume"),
        (".multum-partial-", "map.ndf.exr", "maps.toml")),
    Row("bake scene", ("bake", "{maps}/scene.toml", "-o", "{out}", "--resume"),
        (".multum-partial-", "plan.json", "wall.ndf.exr")),
    Row("bake scene shard", ("bake", "{maps}/scene.toml", "-o", "{out}", "--shard", "1-2/2", "--resume"),
        (".multum-partial-", "wall.ndf.exr", "shards"), timed=("shards",)),
    Row("bake shard", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--shard", "0/2")),
    Row("bake merge", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--merge", "2"), ("map.ndf.exr.shard-",),
        tuple(("bake", *MAP, "-o", "{out}/map.ndf.exr", "--shard", f"{i}/2") for i in range(3))),
    Row("bake moments", ("bake", "{maps}/large_normal.png", "-o", "{out}/map.ndf.exr", "--ndf", "moments")),
    Row("bake harmonics", ("bake", "{maps}/large_normal.png", "-o", "{out}/map.ndf.exr", "--ndf", "sh")),
    Row("bake one lobe", ("bake", "{maps}/large_normal.png", "-o", "{out}/map.ndf.exr", "--lobes", "1")),
    Row("bake onto", ("bake", "{maps}/edited_normal.png", "-o", "{out}/map.ndf.exr", "--onto", "{maps}/baked.ndf.exr",
                      "--region", "0,0,256,256")),
    Row("infer", ("infer", "{maps}/animation.toml", "-o", "{out}", "--context", "osmesa", "--absolute-geometry"),
        ("textures", "matrices", "frames", "comparison", "inferred.json")),
    Row("infer shard", ("infer", "{maps}/animation.toml", "-o", "{out}", "--context", "osmesa", "--shard", "1-2/2"),
        ("textures", "matrices", "shards"), timed=("shards",)),
    Row("pack", ("pack", "{maps}/inferred", "-o", "{out}/field.mpt", "--ratio", "8", "--resume"),
        (".multum-partial-",)),
    Row("mip", ("mip", "{maps}/large_albedo.png", "-o", "{out}/colours.exr")),
    Row("reflectance", ("reflectance", "--light", "0,0,1", "--light", "1,0,1", "--size", "2048", "-o",
                        "{out}/map.exr")),
    Row("export", ("export", *MAP, "-o", "{out}/engine")),
    Row("export several", ("export", "{maps}/map_normal.png", "{maps}/second_normal.png", "-o", "{out}"),
        ("map_normal", "second_normal")),
)


def results(folder, timed=()):
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*"))
            if path.is_file() and not set(timed) & set(path.relative_to(folder).parts)}


class SigtermTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.maps = pathlib.Path(cls.holder.name) / "maps"
        cls.maps.mkdir()
        for name, size, seed in (("map", SIZE, 1), ("second", SIZE, 2), ("edited", SIZE, 3), ("large", 2 * SIZE, 1)):
            cls.prepare("testmap", cls.maps / name, "--size", size, "--seed", seed)
        (cls.maps / "scene.toml").write_text(farm_programs.scene_of([("wall", "map", ""), ("floor", "second", "")]))
        cls.prepare("bake", cls.maps / "map_normal.png", "-o", cls.maps / "baked.ndf.exr")
        (cls.maps / "renders").mkdir()
        subprocess.run([TRACED_FOLDER, cls.maps / "renders", "2", "4"], check=True)
        cls.prepare("animation", cls.maps / "renders", "-o", cls.maps / "animation.toml")
        cls.prepare("infer", cls.maps / "animation.toml", "-o", cls.maps / "inferred", "--context", "osmesa",
                    "--no-frames", "--no-comparison")

    @classmethod
    def prepare(cls, *words):
        done = farm_programs.run(*words)
        if done.returncode != 0:
            raise AssertionError(done.stderr)

    def words_of(self, words, out):
        return [word.format(maps=self.maps, out=out) for word in words]

    def out_of(self, row, name):
        """A folder as the command finds it."""
        out = pathlib.Path(self.holder.name) / name
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir()
        if row.name == "bake manifest":
            (out / "maps.toml").write_text("".join(
                f'[[map]]\ninput = "{self.maps}/{name}_normal.png"\noutput = "{name}.ndf.exr"\n'
                for name in ("map", "second")))
        for words in row.before:
            self.prepare(*self.words_of(words, out))
        return out

    def stopped(self, row, out, pause):
        """Exit code of the command when it hears SIGTERM, and how long it took from there."""
        words = [farm_programs.multum(), *self.words_of(row.words, out), "--openjd"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
            for line in child.stdout:
                if line.startswith("openjd_progress"):
                    break
            time.sleep(pause)
            child.send_signal(signal.SIGTERM)
            sent = time.monotonic()
            said = child.communicate(timeout=GRACE_SECONDS)[1]
            return child.returncode, time.monotonic() - sent, said

    def test_every_command(self):
        for row in ROWS:
            with self.subTest(row.name):
                whole_out = self.out_of(row, "whole")
                begin = time.monotonic()
                self.prepare(*self.words_of(row.words, whole_out))
                seconds = time.monotonic() - begin
                whole = results(whole_out, row.timed)
                self.assertTrue(whole or row.timed)
                for share in (0.3, 0.1, 0.0):
                    out = self.out_of(row, "out")
                    there = set(results(out))
                    code, waited, said = self.stopped(row, out, share * seconds)
                    self.assertIn(code, (0, 130), said)
                    self.assertLess(waited, GRACE_SECONDS / 4)
                    if code == 130:  # otherwise all was done when the signal came
                        break
                self.assertEqual(code, 130, "it had ended before it could be stopped")
                self.assertIn("cancelled", said)
                left = results(out)
                for name in set(left) - there:
                    top = pathlib.Path(name).parts[0]
                    self.assertTrue(row.keeps and top.startswith(row.keeps), f"{name} was left")
                    self.assertNotIn(".multum-tmp-", name)
                    if name in whole:
                        self.assertEqual(left[name], whole[name], f"{name} is half-written")
                if row.keeps:  # others begin anew, as the first time
                    self.prepare(*self.words_of(row.words, out))
                    self.assertEqual(results(out, row.timed), whole)


if __name__ == "__main__":
    farm_programs.main()
