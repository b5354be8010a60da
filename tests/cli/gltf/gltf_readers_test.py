#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the models of `multum gltf` in other programs. gltf-validator and ktx-parse read them, and three.js draws them
in Chromium, from far and near, next to the original model.

  gltf_readers_test.py MULTUM [unittest's arguments]

If MULTUM_SCREENSHOTS names a folder, the pictures are stored there. If MULTUM_SHARED_DATA is set, real models are also
converted. One of them is a Khronos sample model.
"""
import json
import math
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time
import unittest

from folder_case import FolderCase
from gltf_test import LINEAR, MIPMAPPED, REPEAT
from model_writing import Glb, Model, code, png

MULTUM = ""
HERE = pathlib.Path(__file__).resolve().parent
MODULES = HERE.parents[1] / "service/web/node_modules"
SHARED = os.environ.get("MULTUM_SHARED_DATA", "")
UASTC_MODEL, ZSTANDARD = 166, 2


def browser():
    for folder in ("/usr/bin", "/usr/local/bin"):
        for name in ("chromium-headless-shell", "chromium"):
            if os.path.exists(os.path.join(folder, name)):
                return os.path.join(folder, name)
    return None


def ridges(width, height):
    """Returns smooth bumps of several sizes, which are steep enough to split a highlight."""
    def slope(x, y):
        turn = 2 * math.pi
        return (0.35 * math.sin(turn * x / 8) + 0.25 * math.sin(turn * (3 * x + y) / 32),
                0.3 * math.sin(turn * y / 8 + 1) + 0.2 * math.sin(turn * (x - 2 * y) / 64))

    def texel(x, y):
        a, b = slope(x, y)
        length = math.sqrt(a * a + b * b + 1)
        return code(a / length), code(b / length), code(1 / length)

    return png(width, height, texel)


def metal_plate(side=256):
    model = Model()
    model.square(repeats=4.0)
    sampler = model.sampler(magFilter=LINEAR, minFilter=MIPMAPPED, wrapS=REPEAT, wrapT=REPEAT)
    normal = model.texture(model.image(ridges(side, side)), sampler=sampler)
    surface = model.texture(model.image(png(64, 64, lambda x, y: (255, 90 + 40 * (x // 32), 255))), sampler=sampler)
    model.material(normalTexture={"index": normal},
                   pbrMetallicRoughness={"baseColorFactor": [0.9, 0.7, 0.4, 1.0],
                                         "metallicRoughnessTexture": {"index": surface}})
    return model.glb()


@unittest.skipUnless(shutil.which("node"), "no node (Debian package nodejs)")
@unittest.skipUnless((MODULES / "ktx2-encoder").is_dir() and (MODULES / "gltf-validator").is_dir() and
                     (MODULES / "three").is_dir(), "no npm packages: tools/install_dependencies test")
class ReadersTest(FolderCase):
    def convert(self, source, output, *arguments):
        run = subprocess.run([MULTUM, "gltf", source, "-o", self.path(output), "--form", "one-lobe",
                              "--encoder", str(MODULES),
                              "--report", self.path("report.json"), *arguments],
                             capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(self.path("report.json"), encoding="utf-8") as file:
            return json.load(file)

    def read_by_others(self, *files):
        run = subprocess.run(["node", str(HERE / "gltf_reading.mjs"), *files], capture_output=True, text=True,
                             check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        return json.loads(run.stdout)

    def assert_valid(self, read):
        """The validator does not support KTX2 and prints two warnings about each such image. It must not report any
        other problem."""
        expected = [f"{code} /images/{number}{place}" for code, place in
                    (("VALUE_NOT_IN_LIST", "/mimeType"), ("IMAGE_UNRECOGNIZED_FORMAT", ""))
                    for number in range(len(read["textures"]))]
        self.assertEqual(read["errors"], 0, read)
        self.assertEqual(sorted(read["messages"]), sorted(expected))

    def draw(self, picture, plan):
        if browser() is None:
            self.skipTest("no chromium-headless-shell: tools/install_dependencies test")
        folder = os.environ.get("MULTUM_SCREENSHOTS", self.folder)
        os.makedirs(folder, exist_ok=True)
        run = subprocess.run(["node", str(HERE / "gltf_drawing.mjs"), browser(), os.path.join(folder, picture),
                              json.dumps(plan)], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        drawn = json.loads(run.stdout)
        self.assertEqual(drawn["complaints"], [])
        return drawn["result"]

    def test_uastc_is_read_and_drawn(self):
        with open(self.path("in.glb"), "wb") as file:
            file.write(metal_plate())
        self.convert(self.path("in.glb"), "uastc.glb", "--format", "uastc")
        self.convert(self.path("in.glb"), "rgba8.glb", "--format", "rgba8")
        self.convert(self.path("in.glb"), "png.glb", "--format", "png")
        names = ("in.glb", "uastc.glb", "rgba8.glb", "png.glb")
        before, uastc, rgba8, with_png = self.read_by_others(*map(self.path, names))
        for read in (before, with_png):
            self.assertEqual((read["errors"], read["warnings"]), (0, 0), read)
        for read in (uastc, rgba8):
            self.assertEqual(len(read["textures"]), 2)
            self.assert_valid(read)
        for texture in uastc["textures"]:
            self.assertEqual(texture["size"], [256, 256])
            self.assertEqual((texture["vkFormat"], texture["model"]), (0, UASTC_MODEL))
            self.assertEqual(texture["supercompression"], ZSTANDARD)
            self.assertEqual((texture["primaries"], texture["transfer"]), (0, 1))  # no primaries, linear transfer
            self.assertEqual(texture["orientation"], "rd")
            self.assertEqual(texture["levels"], [16 * max(1, 64 >> level)**2 for level in range(9)])
        near, far = self.draw("plate.png", {"models": [self.path(name) for name in names[:3]], "distances": [0.15, 5.5],
                                            "angle": 20, "light": [1, 0.6, 1.5], "intensity": 3})
        print("near", near, "far", far)
        # From near, level 0 is drawn. From far, a pixel covers many bumps, and only fitted levels show the right
        # highlights.
        for one in near[1:]:
            self.assertAlmostEqual(one["energy"], near[0]["energy"], delta=0.1)
        for one in far[1:]:
            self.assertLess(one["error"], 0.6 * far[0]["error"])
        self.assertAlmostEqual(far[1]["error"], far[2]["error"], delta=0.05)

    def test_the_same_bytes_for_any_threads(self):
        with open(self.path("in.glb"), "wb") as file:
            file.write(metal_plate(128))
        found = set()
        for threads in ("1", "2"):
            self.convert(self.path("in.glb"), "out.glb", "--threads", threads, "--uastc-effort", "0", "--format",
                         "uastc")
            with open(self.path("out.glb"), "rb") as file:
                found.add(file.read())
        self.assertEqual(len(found), 1)

    def test_sides_become_multiples_of_4(self):
        model = Model()
        model.square()
        model.material(normalTexture={"index": model.texture(model.image(ridges(30, 17)))},
                       pbrMetallicRoughness={"roughnessFactor": 0.3})
        with open(self.path("in.glb"), "wb") as file:
            file.write(model.glb())
        report = self.convert(self.path("in.glb"), "out.glb", "--format", "uastc")
        self.assertIn("enlarged to 32 x 20", report["materials"][0]["notes"][1])
        read, = self.read_by_others(self.path("out.glb"))
        self.assert_valid(read)
        self.assertEqual([texture["size"] for texture in read["textures"]], [[32, 20]] * 2)

    def test_uastc_is_taken_where_it_shows_little(self):
        """Smooth bumps are stored as UASTC. Noise does not suit UASTC, so it is stored with 8 bits per channel and
        with an additional image for other loaders."""
        draw = random.Random(54)
        noise = [bytes((draw.randrange(64, 192), draw.randrange(64, 192), 230)) for _ in range(64 * 64)]
        swell = png(64, 64, lambda x, y:
                    (code(0.1 * math.sin(x / 10)), code(0.1 * math.cos(y / 10)), code(0.99)))
        found = {}
        for name, normal in (("smooth", swell), ("noise", png(64, 64, lambda x, y: noise[y * 64 + x]))):
            model = Model()
            model.square()
            model.material(normalTexture={"index": model.texture(model.image(normal))},
                           pbrMetallicRoughness={"roughnessFactor": 0.9})
            with open(self.path("in.glb"), "wb") as file:
                file.write(model.glb())
            report = self.convert(self.path("in.glb"), name + ".glb")
            storage = found[name] = report["textures"][0]["storage"]["normal"]
            read, = self.read_by_others(self.path(name + ".glb"))
            self.assertEqual(read["errors"], 0, read)
            with open(self.path(name + ".glb"), "rb") as file:
                after = Glb(file.read())
            texture = after.json["textures"][after.json["materials"][0]["normalTexture"]["index"]]
            basis = texture["extensions"]["KHR_texture_basisu"]["source"]
            self.assertNotEqual(texture.get("source"), basis)
            self.assertEqual("source" in texture, "fallback_bytes" in storage)
            if name == "noise":
                # Level 0 is the original image.
                self.assertEqual(after.view(after.json["images"][texture["source"]]["bufferView"]), normal)
        self.assertEqual(found["smooth"]["format"], "uastc")
        self.assertLess(found["smooth"]["points"], 0.3)
        self.assertEqual(found["noise"]["format"], "rgba8")
        self.assertGreater(found["noise"]["uastc_points"], 0.3)
        self.convert(self.path("in.glb"), "asked.glb", "--format", "uastc")
        with open(self.path("report.json"), encoding="utf-8") as file:
            asked = json.load(file)["textures"][0]["storage"]["normal"]
        self.assertEqual(asked["format"], "uastc")
        self.assertGreater(asked["points"], 0.3)

    def test_a_fallback_for_every_texture(self):
        with open(self.path("in.glb"), "wb") as file:
            file.write(metal_plate(64))
        self.convert(self.path("in.glb"), "out.glb", "--format", "rgba8", "--png-fallback")
        with open(self.path("out.glb"), "rb") as file:
            after = Glb(file.read())
        self.assertIn("KHR_texture_basisu", after.json["extensionsUsed"])
        self.assertNotIn("extensionsRequired", after.json)
        for texture in after.json["textures"]:
            image = after.json["images"][texture["source"]]
            self.assertEqual(image["mimeType"], "image/png")
            self.assertTrue(after.view(image["bufferView"]).startswith(b"\x89PNG"))
        read, = self.read_by_others(self.path("out.glb"))
        self.assertEqual(read["errors"], 0, read)

    def test_an_interrupted_encoder_leaves_nothing(self):
        with open(self.path("in.glb"), "wb") as file:
            file.write(metal_plate())
        process = subprocess.Popen([MULTUM, "gltf", self.path("in.glb"), "-o", self.path("out.glb"), "--encoder",
                                    str(MODULES), "--uastc-effort", "3"], stderr=subprocess.PIPE)
        blocks = self.path(".multum-partial-out.glb/uastc_blocks")
        end = time.time() + 120
        while time.time() < end and not os.path.exists(blocks):
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertEqual(os.listdir(self.folder), ["in.glb"])

    @unittest.skipUnless(SHARED, "MULTUM_SHARED_DATA names no folder of real models")
    def test_real_models(self):
        for name, distances in (("pc_NormalTangentTest.glb", [2, 4]),
                                ("dutch_ship/dutch_ship_medium_1k.gltf", [2.5, 5])):
            with self.subTest(model=name):
                source = os.path.join(SHARED, "mesh", name)
                stem = pathlib.Path(name).stem
                report = self.convert(source, stem + ".glb", "--format", "rgba8")
                self.assertTrue(all(material["fitted"] for material in report["materials"]), report["materials"])
                before, after = self.read_by_others(source, self.path(stem + ".glb"))
                self.assertEqual(after["errors"], 0, after)
                new = set(after["messages"]) - set(before["messages"])
                self.assertEqual({message.split()[0] for message in new},
                                 {"VALUE_NOT_IN_LIST", "IMAGE_UNRECOGNIZED_FORMAT"})  # assert_valid() allows these
                self.assertEqual(len(after["textures"]), 2 * len(report["textures"]))
                self.draw(stem + ".png", {"models": [source, self.path(stem + ".glb")], "distances": distances,
                                          "from": [1, 0.4, 0.5] if "ship" in name else [0.3, 0.2, 1],
                                          "light": [1, 1, 1], "intensity": 3})


if __name__ == "__main__":
    MULTUM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
