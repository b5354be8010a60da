#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests what every command promises: --json prints one JSON document to stdout and nothing else, and the command
creates missing output folders.

  tests/cli/results_test.py --programs FOLDER [--traced-folder PROGRAM]
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

programs = pathlib.Path("build/release/bin")
traced_folder = None
MANIFEST = '[defaults]\nlobes = 1\n[[map]]\ninput = "map_normal.png"\noutput = "baked/map.ndf.exr"\ngreen = "up"\n'
EXPORTS = '[[map]]\ninput = "map_normal.png"\noutput = "exported/map.ktx2"\ngreen = "up"\n'
BAKE = ("--lobes", "1", "--green", "up", "--no-measure")
# This glTF file holds a triangle with a normal map.
MODEL = {"asset": {"version": "2.0"}, "images": [{"uri": "map_normal.png"}], "textures": [{"source": 0}],
         "materials": [{"name": "rock", "normalTexture": {"index": 0}}]}


class ResultsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = pathlib.Path(cls.holder.name)
        cls.run_program("multum", "testmap", "-o", "map", "--size", "32")
        cls.run_program("multum", "bake", "map_normal.png", "-o", "map.ndf.exr", *BAKE)
        (cls.folder / "maps.toml").write_text(MANIFEST)
        (cls.folder / "exports.toml").write_text(EXPORTS)
        (cls.folder / "model.gltf").write_text(json.dumps(MODEL))

    @classmethod
    def run_program(cls, *words, code=0):
        done = subprocess.run([programs / words[0], *map(str, words[1:])], capture_output=True, text=True, check=False,
                              cwd=cls.folder)
        if done.returncode != code:
            raise AssertionError(f"{words}: exit code {done.returncode}, expected {code}: {done.stderr}")
        return done

    def document(self, *words, code=0):
        done = self.run_program("multum", *words, "--json", code=code)
        try:
            return json.loads(done.stdout)
        except ValueError:
            self.fail(f"{words}: stdout is not one JSON document:\n{done.stdout[:2000]}")

    def made(self, *names):
        for name in names:
            self.assertTrue((self.folder / name).exists(), name)

    def test_files(self):
        self.assertEqual(self.document("info", "map.ndf.exr")["lobes"], 1)
        self.assertTrue(self.document("verify", "map.ndf.exr")["passed"])
        self.assertEqual(self.document("testmap", "-o", "new/a/t", "--size", "16")["normal"], "new/a/t_normal.png")
        self.made("new/a/t_albedo.png")
        self.run_program("multum", "bake", "map_normal.png", "-o", "plain.ndf.exr", "--compression", "none", *BAKE)
        damaged = bytearray((self.folder / "plain.ndf.exr").read_bytes())
        damaged[-100] ^= 16
        (self.folder / "damaged.ndf.exr").write_bytes(damaged)
        self.assertFalse(self.document("verify", "damaged.ndf.exr", code=5)["passed"])

    def test_machine(self):
        self.assertGreater(len(self.document("devices", "--report", "new/b/devices.json")), 0)
        self.made("new/b/devices.json")
        self.assertIn("cases", self.document("selftest", "--filter", "exp2", "--report", "new/c/cases.json"))
        self.made("new/c/cases.json")
        self.assertIn("bake", self.document("parameters")["commands"])
        self.assertEqual(self.document("man", "-o", "new/d/man1")["output"], "new/d/man1")
        self.made("new/d/man1/multum-bake.1")

    def test_bakes(self):
        words = ("bake", "map_normal.png", "-o", "new/e/map.ndf.exr", "--report", "new/f/report.json", *BAKE)
        self.assertEqual(self.document(*words)["output"], "new/e/map.ndf.exr")
        self.made("new/e/map.ndf.exr", "new/f/report.json")
        self.assertTrue(self.document(*words)["unchanged"])
        shutil.copy(self.folder / "map_normal.png", self.folder / "other.png")
        several = self.document("bake", "map_normal.png", "other.png", "missing.png", "-o", "new/g", *BAKE, code=3)
        self.assertEqual([("failed" in one) for one in several["maps"]], [False, False, True])
        self.made("new/g/other.ndf.exr")
        found = self.document("bake", "--manifest", "maps.toml", "--check", "--junit", "new/h/junit.xml", code=5)
        self.assertEqual([one["state"] for one in found["maps"]], ["missing"])
        self.made("new/h/junit.xml")
        self.assertTrue(self.document("bake", "--manifest", "maps.toml")["passed"])
        self.assertGreater(self.document("plan", "map_normal.png", "--share-seconds", "0")["processor_seconds"], 0)

    def test_pyramids(self):
        for name, words in {"mip": ("map_albedo.png",), "lod": ("map_albedo.png",),
                            "reflectance": ("--light", "0,0,1", "--size", "16")}.items():
            with self.subTest(command=name):
                output = f"new/{name}/a.exr"
                self.assertEqual(self.document(name, *words, "-o", output)["output"], output)
                self.made(output)

    def test_exports(self):
        one = self.document("export", "map_normal.png", "-o", "new/i/rock.ktx2", "--green", "up", "--no-measure")
        self.assertEqual(one["output"], "new/i/rock.ktx2")
        self.made("new/i/rock_normal.ktx2")
        lobes = self.document("export", "map.ndf.exr", "--lobes", "-o", "new/j/map.ktx2")
        self.assertEqual(lobes["output"], "new/j/map.ktx2")
        several = self.document("export", "map_normal.png", "new/a.png", "-o", "new/k", "--green", "up", "--no-measure",
                                code=3)
        self.assertEqual(len(several["maps"]), 2)
        self.assertTrue(self.document("export", "--manifest", "exports.toml")["passed"])
        self.assertEqual(self.document("look", "map.ndf.exr", "-o", "new/l/map.html", "--no-open")["maps"], 1)
        self.made("new/l/map.html")
        self.assertEqual(self.document("shaders", "-o", "new/m/shading")["output"], "new/m/shading")
        self.made("new/m/shading/three/package.json")
        self.assertEqual(self.document("materials", "model.gltf", "-o", "new/n/model")["maps"], 1)
        self.made("new/n/model/maps.toml")
        self.assertEqual(self.document("gltf", "model.gltf", "-o", "new/o/model.glb", "--form", "one-lobe", "--format",
                                       "png")["output"], "new/o/model.glb")
        self.made("new/o/model.glb")

    def test_tradeoff(self):
        self.assertIn("software", self.document("tradeoff", "map_normal.png", "-o", "new/p/costs.html", "--quick",
                                                "--no-pictures", "--green", "up", "--report", "new/q/costs.json"))
        self.made("new/p/costs.html", "new/q/costs.json")

    def test_job_bundles(self):
        done = subprocess.run([programs / "multum", "openjd", "-o", "new/r/bundle", "--json", "bake", "map_normal.png",
                               "-o", "baked/b.ndf.exr"], capture_output=True, text=True, check=False, cwd=self.folder)
        if "no farm" in done.stderr:
            self.skipTest("this build has no farm")
        self.assertEqual(json.loads(done.stdout)["tasks"], 1)
        self.made("new/r/bundle")

    def test_fields(self):
        if traced_folder is None:
            self.skipTest("this build has no fields")
        (self.folder / "renders").mkdir()
        subprocess.run([traced_folder, self.folder / "renders", "2", "2"], check=True)
        self.assertEqual(self.document("animation", "renders", "-o", "new/s/animation.toml")["samples"], 4)
        self.assertIn("textures", self.document("infer", "new/s/animation.toml", "-o", "new/t/field", "--context",
                                                "osmesa", "--no-frames", "--no-comparison"))
        self.assertGreater(self.document("pack", "new/t/field", "-o", "new/u/field.mpt")["bytes"], 0)
        self.assertEqual(self.document("info", "new/u/field.mpt")["representation"], "packed field")
        self.assertTrue(self.document("verify", "new/u/field.mpt")["passed"])
        self.assertGreater(self.document("unpack", "new/u/field.mpt", "-o", "new/v/field")["textures"], 0)
        self.assertEqual(self.document("player", "new/u/field.mpt", "-o", "new/w/field.html")["output"],
                         "new/w/field.html")
        self.made("new/w/field.html")

    def test_pictures_go_to_missing_folders(self):
        if not (programs / "multum-view").is_file():
            self.skipTest("multum-view was not built")
        self.run_program("multum-view", "map.ndf.exr", "-o", "new/x/a.png", "--size", "16x16", "--context", "osmesa",
                         "--report", "new/y/a.json", "--shaders", "new/z/a.json")
        self.made("new/x/a.png", "new/y/a.json", "new/z/a.json")

    def test_a_failed_command_leaves_no_folder(self):
        self.run_program("multum", "bake", "none.png", "-o", "left/a/b.ndf.exr", code=3)
        self.assertFalse((self.folder / "left").exists())
        done = self.run_program("multum", "info", "none.exr", "--json", code=3)
        self.assertEqual(done.stdout, "")


if __name__ == "__main__":
    for name in ("--programs", "--traced-folder"):
        if name in sys.argv:
            at = sys.argv.index(name)
            if name == "--programs":
                programs = pathlib.Path(sys.argv[at + 1]).resolve()
            else:
                traced_folder = sys.argv[at + 1]
            del sys.argv[at:at + 2]
    sys.exit(unittest.main())
