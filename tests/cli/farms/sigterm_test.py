#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the results of every command after SIGTERM (docs/how-to/clusters.md, "Results after SIGTERM"): exit code 130
well within the grace period of a farm, no partial output, and the same result from the repeated command as from an
undisturbed run. By default, only half of the commands are stopped; MULTUM_SWEEPS=all takes all of them.

  tests/cli/farms/sigterm_test.py --programs FOLDER --traced-folder PROGRAM
"""
import dataclasses
import hashlib
import os
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

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "gltf"))
import gltf_test  # noqa: E402

GRACE_SECONDS = 30  # the grace period of a farm; the program must stop within a quarter of it
SIZE = 128


@dataclasses.dataclass
class Row:
    """Describes a command. `{out}` in its words is replaced by its result folder."""
    name: str
    words: tuple
    keeps: tuple = ()   # prefixes of paths below `out` (hidden files included) that may exist after the stop
    before: tuple = ()  # commands that make its inputs in `out`
    timed: tuple = ("report.json", "report.html")  # results that differ between runs because they contain times
    until: str = ""     # the stage that must have begun before the stop
    share: float = 0.3  # the share of its run time after which it is stopped
    sweep: bool = False  # run only with MULTUM_SWEEPS=all


MAP = ("{maps}/map_normal.png",)
LARGE = ("{maps}/large_normal.png",)
ONE = ("-o", "{out}/map.ndf.exr", "--no-measure")
PARTIAL = (".multum-partial-",)
ROWS = (
    # The run includes the measuring stage.
    Row("bake", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--resume"), PARTIAL),
    Row("bake gmm", ("bake", *MAP, *ONE, "--ndf", "gmm", "--resume"), PARTIAL, sweep=True),
    Row("bake refine", ("bake", *MAP, *ONE, "--refine", "--resume"), PARTIAL, sweep=True),
    Row("bake target", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--target-error", "0.5", "--ndf", "vmf", "--brdf",
                        "lambert", "--resume"), (*PARTIAL, "map.ndf.exr"), share=0.1),  # mostly draws pictures
    Row("bake budget", ("bake", *MAP, "-o", "{out}/map.ndf.exr", "--budget-ms", "1e6"), until="choose settings",
        sweep=True),
    Row("bake several", ("bake", *MAP, "{maps}/second_normal.png", "-o", "{out}", "--no-measure", "--resume"),
        (*PARTIAL, "map_normal.ndf.exr")),
    Row("bake manifest", ("bake", "--manifest", "{out}/maps.toml", "--resume"),
        (*PARTIAL, "map.ndf.exr", "maps.toml")),
    Row("bake scene", ("bake", "{maps}/scene.toml", "-o", "{out}", "--resume"),
        (*PARTIAL, "plan.json", "wall.ndf.exr")),
    Row("bake scene shard", ("bake", "{maps}/scene.toml", "-o", "{out}", "--shard", "1-2/2", "--resume"),
        (*PARTIAL, "wall.ndf.exr", "shards"), timed=("shards",), sweep=True),
    Row("bake shard", ("bake", *MAP, *ONE, "--shard", "0/2")),
    Row("bake merge", ("bake", *LARGE, *ONE, "--compression", "zip:8", "--merge", "2"), ("map.ndf.exr.shard-",),
        tuple(("bake", *LARGE, *ONE, "--compression", "zip:8", "--shard", f"{i}/2") for i in range(3))),
    Row("bake moments", ("bake", *LARGE, *ONE, "--ndf", "moments"), sweep=True),
    Row("bake harmonics", ("bake", *LARGE, *ONE, "--ndf", "sh"), sweep=True),
    Row("bake one lobe", ("bake", *LARGE, *ONE, "--lobes", "1"), sweep=True),
    Row("bake onto", ("bake", "{maps}/edited_normal.png", "-o", "{out}/map.ndf.exr", "--onto", "{maps}/baked.ndf.exr",
                      "--region", "0,0,128,128"), sweep=True),
    Row("infer", ("infer", "{maps}/animation.toml", "-o", "{out}", "--context", "osmesa", "--absolute-geometry",
                  "--no-comparison"), ("textures", "matrices", "frames", "inferred.json")),
    Row("infer shard", ("infer", "{maps}/animation.toml", "-o", "{out}", "--context", "osmesa", "--shard", "1-2/2"),
        ("textures", "matrices", "shards"), timed=("shards",), sweep=True),
    Row("pack", ("pack", "{maps}/inferred", "-o", "{out}/field.mpt", "--ratio", "8", "--resume"), PARTIAL),
    Row("mip", ("mip", "{maps}/large_albedo.png", "-o", "{out}/colours.exr"), sweep=True),
    Row("reflectance", ("reflectance", "--light", "0,0,1", "--light", "1,0,1", "--size", "2048", "-o",
                        "{out}/map.exr"), sweep=True),
    Row("tradeoff", ("tradeoff", *MAP, "-o", "{out}/costs.html", "--no-pictures"), sweep=True),
    Row("tradeoff budget", ("tradeoff", *MAP, "-o", "{out}/costs.html", "--no-pictures", "--quick", "--budget-ms",
                            "50"), until="time bakes", sweep=True),
    # Stops while multum-view draws.
    Row("tradeoff drawing", ("tradeoff", *MAP, "-o", "{out}/costs.html", "--context", "osmesa"), until="draw"),
    Row("gltf", ("gltf", "{maps}/model.glb", "-o", "{out}/model.glb", "--format", "rgba8"), sweep=True),
    # Stages are reported once per second. On a fast machine, the export of the small model would end before the first
    # report.
    Row("gltf lobes", ("gltf", "{maps}/large.glb", "-o", "{out}/model.glb", "--format", "rgba8", "--lobes"),
        until="lobes"),
    Row("export", ("export", *MAP, "-o", "{out}/engine"), sweep=True),
    Row("export resume", ("export", *MAP, "-o", "{out}/engine", "--resume"), ("engine/.multum-partial-export/",)),
    Row("export several", ("export", *MAP, "{maps}/second_normal.png", "-o", "{out}"),
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
        for name, size, seed in (("map", SIZE, 1), ("second", SIZE, 2), ("edited", SIZE, 3), ("large", 4 * SIZE, 1)):
            cls.prepare("testmap", cls.maps / name, "--size", size, "--seed", seed)
        (cls.maps / "scene.toml").write_text(farm_programs.scene_of([("wall", "map", ""), ("floor", "second", "")]))
        cls.prepare("bake", cls.maps / "map_normal.png", "-o", cls.maps / "baked.ndf.exr", "--no-measure")
        model = gltf_test.plain_model(gltf_test.bumps(2 * SIZE, 2 * SIZE), gltf_test.packed(2 * SIZE, 2 * SIZE))
        (cls.maps / "model.glb").write_bytes(model.glb())
        large = gltf_test.plain_model(gltf_test.bumps(8 * SIZE, 8 * SIZE), gltf_test.packed(8 * SIZE, 8 * SIZE))
        (cls.maps / "large.glb").write_bytes(large.glb())
        (cls.maps / "renders").mkdir()
        subprocess.run([TRACED_FOLDER, cls.maps / "renders", "2", "2"], check=True)
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
        """Makes a folder with the inputs of the commands."""
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
        """Returns the command's exit code after SIGTERM, and the seconds from the signal to the exit. The signal comes
        twice, as from `timeout`, which signals a process and its group."""
        words = [farm_programs.multum(), *self.words_of(row.words, out), "--openjd"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
            begun = not row.until
            for line in child.stdout:
                begun = begun or line.startswith("openjd_status: " + row.until)
                if begun and line.startswith("openjd_progress"):
                    break
            time.sleep(pause)
            child.send_signal(signal.SIGTERM)
            time.sleep(0.01)  # otherwise both signals count as one
            child.send_signal(signal.SIGTERM)
            sent = time.monotonic()
            said = child.communicate(timeout=GRACE_SECONDS)[1]
            return child.returncode, time.monotonic() - sent, said

    def test_every_command(self):
        for row in ROWS:
            if row.sweep and os.environ.get("MULTUM_SWEEPS") != "all":
                continue
            with self.subTest(row.name):
                whole, pauses = {}, (0.0,) if row.until else (0.2, 0.05, 0.0)
                if row.keeps:  # other commands begin again as in the first run
                    whole_out = self.out_of(row, "whole")
                    begin = time.monotonic()
                    self.prepare(*self.words_of(row.words, whole_out))
                    seconds = time.monotonic() - begin
                    pauses = (row.share * seconds, row.share / 3 * seconds, 0.0)
                    whole = results(whole_out, row.timed)
                    self.assertTrue(whole or row.timed)
                for pause in pauses:
                    out = self.out_of(row, "out")
                    there = set(results(out))
                    code, waited, said = self.stopped(row, out, pause)
                    self.assertIn(code, (0, 130), said)
                    self.assertLess(waited, GRACE_SECONDS / 4)
                    if code == 130:  # otherwise the run had ended before the signal
                        break
                self.assertEqual(code, 130, "the command ended before the signal")
                self.assertIn("cancelled", said)
                left = results(out)
                for name in set(left) - there:
                    self.assertTrue(row.keeps and name.startswith(row.keeps), f"{name} was left")
                    self.assertNotIn(".multum-tmp-", name)
                    if name in whole:
                        self.assertEqual(left[name], whole[name], f"{name} is half-written")
                if row.keeps:
                    self.prepare(*self.words_of(row.words, out))
                    self.assertEqual(results(out, row.timed), whole)


if __name__ == "__main__":
    farm_programs.main()
