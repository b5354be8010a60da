#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests `multum gltf --lobes`: the extension MULTUM_lobes of materials (docs/reference/gltf.md, "The extension
MULTUM_lobes"), the parts that stay unchanged, and the results of gltf-validator, three.js and @multum/three.

  gltf_lobes_test.py MULTUM [unittest's arguments]
"""
import copy
import json
import math
import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import unittest

from folder_case import FolderCase
from gltf_readers_test import MODULES, ridges
from gltf_test import CLAMP, LINEAR, MIPMAPPED, REPEAT, packed, plain_model
from model_writing import Glb, Model, bumps, code, png

MULTUM = ""
USAGE = 2
HERE = pathlib.Path(__file__).resolve().parent
BC5, RGBA8, RGBA16F, ZSTANDARD = 141, 37, 97, 2
NAME = "MULTUM_lobes"


def key_of(data, key=b"multumLobes"):
    """Returns the format of a KTX2 file, its number of layers, and the JSON of its key."""
    assert data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n"
    form, _, _, _, _, layers, _, _, scheme = struct.unpack("<9I", data[12:48])
    at, length = struct.unpack("<2I", data[56:64])
    text = data[at:at + length]
    begin = text.index(key + b"\0") + len(key) + 1
    size, = struct.unpack("<I", text[begin - len(key) - 5:begin - len(key) - 1])
    return form, layers, scheme, json.loads(text[begin:begin + size - len(key) - 1].rstrip(b"\0"))


class GltfLobesTest(FolderCase):
    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def run_gltf(self, source, output, *arguments, form="rgba8"):
        return subprocess.run([MULTUM, "gltf", self.path(source), "-o", self.path(output),
                               "--form", "one-lobe", "--format", form,
                               "--report", self.path("report.json"), *arguments],
                              capture_output=True, text=True, check=False)

    def convert(self, model, *arguments, output="out.glb", form="rgba8"):
        with open(self.path("in.glb"), "wb") as file:
            file.write(model.glb())
        run = self.run_gltf("in.glb", output, *arguments, form=form)
        self.assertEqual(run.returncode, 0, run.stderr)
        return Glb(self.read(output)), json.loads(self.read("report.json"))

    def lobes_of(self, after, index):
        entry = after.json["extensions"][NAME]["lobes"][index]
        self.assertEqual(entry["mimeType"], "image/ktx2")
        return after.view(entry["bufferView"])

    def test_lobes_lie_beside_the_fitted_textures(self):
        model = plain_model(normal=bumps(32, 16), roughnessFactor=0.5)
        model.json["materials"][0]["occlusionTexture"] = {"index": 1}
        model.json["materials"][0]["normalTexture"]["scale"] = 0.5
        before = copy.deepcopy(model.json)
        plain, _ = self.convert(model, output="plain.glb")
        after, report = self.convert(model, "--lobes")
        self.assertIn(NAME, after.json["extensionsUsed"])
        self.assertNotIn(NAME, after.json["extensionsRequired"])
        extension = after.json["materials"][0]["extensions"][NAME]
        self.assertEqual(extension, {"lobes": 0, "roughnessFactor": 0.5, "metallicRoughnessTexture": {"index": 1}})
        # The roughness image of the material stays unchanged in its place.
        self.assertEqual(after.json["textures"][1], before["textures"][1])
        self.assertEqual(after.image(1), packed(16, 8))
        form, layers, scheme, key = key_of(self.lobes_of(after, 0))
        self.assertEqual((form, layers, scheme), (RGBA8, 4, ZSTANDARD))
        self.assertEqual((key["mapWidth"], key["mapHeight"], key["firstLevel"]), (32, 16, 1))
        self.assertEqual((key["wrapS"], key["wrapT"], len(key["lobes"])), ("periodic", "periodic", 4))
        self.assertEqual(report["textures"][0]["bytes"]["lobes"], len(self.lobes_of(after, 0)))
        self.assertTrue(report["lobes"])
        # Apart from the extension, the material is the same as after a run without --lobes.
        here, there = after.json["materials"][0], plain.json["materials"][0]
        self.assertEqual(set(here) - set(there), {"extensions"})
        for place in (("normalTexture",), ("pbrMetallicRoughness", "metallicRoughnessTexture"), ("occlusionTexture",)):
            one, other = here, there
            for name in place:
                one, other = one[name], other[name]
            self.assertEqual(after.image(one["index"]), plain.image(other["index"]), place)
            self.assertNotIn("scale", one)
        self.assertNotIn("roughnessFactor", here["pbrMetallicRoughness"])

    def test_texels_of_lobes_are_those_of_the_format_or_as_asked_for(self):
        points = {}
        for form, arguments, expected in (("rgba8", (), (RGBA8, 4)), ("png", ("--lobe-texels", "bc"), (BC5, 8)),
                                          ("rgba8", ("--lobe-texels", "bc"), (BC5, 8)),
                                          ("png", ("--lobe-texels", "rgba16f"), (RGBA16F, 4))):
            after, report = self.convert(plain_model(normal=bumps(64, 64)), "--lobes", *arguments, form=form)
            found, layers, _, _ = key_of(self.lobes_of(after, 0))
            self.assertEqual((found, layers), expected, arguments)
            storage = report["textures"][0]["storage"]["lobes"]
            points[storage["format"]] = storage["points"]
        # Storing the lobes adds this error to a picture.
        self.assertLess(points["rgba8"], 0.5 * points["bc"])
        self.assertLess(points["rgba16f"], 0.1 * points["bc"])
        # Without an option, block compression is chosen unless its error is visible.
        for steepness, expected, texels in ((0.1, "bc", BC5), (0.6, "rgba8", RGBA8)):
            after, report = self.convert(plain_model(normal=bumps(64, 64, steepness)), "--lobes", form="png")
            storage = report["textures"][0]["storage"]["lobes"]
            self.assertEqual((storage["format"], key_of(self.lobes_of(after, 0))[0]), (expected, texels), steepness)
            self.assertLess(storage["points"], 0.3)
            self.assertEqual(storage.get("bc_points", 0.0) >= 0.3, expected == "rgba8", storage)
        self.write_model(plain_model())
        run = self.run_gltf("in.glb", "none.glb", "--lobe-texels", "bc")
        self.assertEqual(run.returncode, USAGE)
        self.assertIn("--lobes", run.stderr)

    def write_model(self, model):
        with open(self.path("in.glb"), "wb") as file:
            file.write(model.glb())

    def test_roughness_by_a_factor_and_shared_lobes(self):
        model = Model()
        model.square()
        sampler = model.sampler(magFilter=LINEAR, minFilter=MIPMAPPED, wrapS=REPEAT, wrapT=CLAMP)
        image = model.image(bumps(16, 16))
        one, other = (model.texture(image, sampler=sampler) for _ in range(2))
        transform = {"KHR_texture_transform": {"scale": [4, 4]}}
        model.material(normalTexture={"index": one, "extensions": transform},
                       pbrMetallicRoughness={"roughnessFactor": 0.3})
        model.material(normalTexture={"index": other}, pbrMetallicRoughness={"roughnessFactor": 0.3})
        model.material(normalTexture={"index": other}, pbrMetallicRoughness={"roughnessFactor": 0.7})
        model.material(name="smooth", pbrMetallicRoughness={"roughnessFactor": 0.7})
        after, report = self.convert(model, "--lobes")
        materials = after.json["materials"]
        extensions = [material.get("extensions", {}).get(NAME) for material in materials]
        self.assertEqual(extensions, [{"lobes": 0, "roughnessFactor": 0.3}, {"lobes": 0, "roughnessFactor": 0.3},
                                      {"lobes": 1, "roughnessFactor": 0.7}, None])
        self.assertEqual(len(report["textures"]), 2)
        self.assertEqual(key_of(self.lobes_of(after, 1))[3]["wrapT"], "clamp")
        self.assertEqual(self.lobes_of(after, 0), self.lobes_of(after, 1))  # the same map without roughness

    def coloured(self, *colours):
        """Converts steep facets with one material for each of `colours`. With "with", facets that face right are
        bright; with "against", facets are bright at random; with "small", the colours have another size. Returns the
        file, its first lobes and the report."""
        side, rng = 64, random.Random(5)
        slopes = [[(rng.gauss(0, 0.6), rng.gauss(0, 0.6)) for _ in range(side)] for _ in range(side)]
        chance = [[rng.random() < 0.5 for _ in range(side)] for _ in range(side)]

        def normal_of(x, y):
            a, b = slopes[y][x]
            length = math.sqrt(a * a + b * b + 1)
            return code(a / length), code(b / length), code(1 / length)

        def shade(is_bright):
            return (230, 210, 190) if is_bright else (40, 30, 30)

        images = {"with": png(side, side, lambda x, y: shade(slopes[y][x][0] > 0)),
                  "against": png(side, side, lambda x, y: shade(chance[y][x])),
                  "small": png(side // 2, side // 2, lambda x, y: shade(slopes[2 * y][2 * x][0] > 0))}
        model = Model()
        model.square(repeats=8.0)
        sampler = model.sampler(magFilter=LINEAR, minFilter=MIPMAPPED, wrapS=REPEAT, wrapT=REPEAT)
        normal = model.texture(model.image(png(side, side, normal_of)), sampler=sampler)
        for name in colours:
            texture = model.texture(model.image(images[name]), sampler=sampler)
            model.material(normalTexture={"index": normal},
                           pbrMetallicRoughness={"baseColorTexture": {"index": texture}, "metallicFactor": 0.0,
                                                 "roughnessFactor": 0.4})
        self.write_model(model)
        run = subprocess.run([MULTUM, "gltf", self.path("in.glb"), "-o", self.path("out.glb"), "--lobes", "--format",
                              "png", "--report", self.path("report.json")], capture_output=True, text=True,
                             check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertNotIn("has colours, which", run.stderr)
        after, report = Glb(self.read("out.glb")), json.loads(self.read("report.json"))
        return after, after.json["extensions"][NAME]["lobes"][0], report

    def test_lobes_have_colours_where_these_go_with_normals(self):
        after, lobes, report = self.coloured("with")
        self.assertEqual(lobes["colours"]["mimeType"], "image/ktx2")
        data = after.view(lobes["colours"]["bufferView"])
        form, layers, scheme, key = key_of(data, b"multumLobeColours")
        self.assertEqual((form, layers, scheme), (BC5, 2, ZSTANDARD))
        self.assertEqual((key["version"], key["mapWidth"], key["mapHeight"], key["firstLevel"], key["lobes"]),
                         (1, 64, 64, 2, 4))
        self.assertEqual((key["wrapS"], key["wrapT"]), ("periodic", "periodic"))
        self.assertTrue(0.1 < key["range"] <= 1.0, key)
        self.assertEqual(report["textures"][0]["bytes"]["lobe_colours"], len(data))
        form, = report["forms"]
        self.assertTrue(form["lobe_colours"])
        own, mean = (form["errors"][name][-1] for name in ("lobe_colours_4", "mean_colour_4"))
        self.assertLess(own, 0.9 * mean)
        # A second run on a file that already has lobes loses nothing.
        self.assertEqual(self.run_gltf("out.glb", "again.glb", "--lobes").returncode, 0)
        again = Glb(self.read("again.glb"))
        self.assertEqual(again.view(again.json["extensions"][NAME]["lobes"][0]["colours"]["bufferView"]), data)

    @unittest.skipUnless(shutil.which("node") and (MODULES / "three").is_dir(),
                         "no npm packages: tools/install_dependencies test")
    def test_colours_of_lobes_are_drawn(self):
        """Programs that do not support the lobes have a higher error."""
        self.coloured("with")
        known = self.read("out.glb")
        self.assertEqual(known.count(b'"colours"'), 1)
        with open(self.path("unknown.glb"), "wb") as file:
            file.write(known.replace(b'"colours"', b'"unknown"'))
        models = [{"file": "in.glb"}, {"file": "out.glb", "lobes": True}, {"file": "unknown.glb", "lobes": True}]
        view = {"angle": 20, "target": [0, 0, 0], "width": 64, "height": 64, "samples": 12, "frames": 1, "edges": 0,
                "light": [1, 0.6, 1.5], "intensity": 3, "room": 0.3, "crop": [0, 0, 64, 64], "zoom": 4,
                "name": "colours", "eye": [1.5, 1, 5]}
        drawn = self.drawn({"models": models, "views": [view]})
        plain, own, mean = drawn["views"]["colours"]["models"]
        print(json.dumps([plain, own, mean]))
        self.assertEqual([plain["lobed"], own["lobed"], mean["lobed"]], [0, 1, 1])
        self.assertLess(own["error"], 0.7 * mean["error"])
        self.assertLess(own["error"], plain["error"])

    def test_lobes_have_no_colours_where_these_do_not(self):
        for colours in (("against",), ("small",), ("with", "against")):
            _, lobes, report = self.coloured(*colours)
            self.assertNotIn("colours", lobes, colours)
            self.assertNotIn("lobe_colours", report["textures"][0]["bytes"], colours)

    def test_models_that_have_lobes_stay(self):
        self.convert(plain_model(), "--lobes", output="first.glb")
        run = self.run_gltf("first.glb", "second.glb", "--lobes")
        self.assertEqual(run.returncode, 0, run.stderr)
        first, second = Glb(self.read("first.glb")), Glb(self.read("second.glb"))
        for name, value in first.json.items():
            if name not in ("buffers", "bufferViews"):
                self.assertEqual(second.json[name], value, name)
        self.assertEqual(self.lobes_of(first, 0), self.lobes_of(second, 0))
        self.assertIn("already has lobes", json.loads(self.read("report.json"))["materials"][0]["kept"])

    def test_extensions_of_others_stay(self):
        model = plain_model()
        model.json["extensions"] = {"X_other": {"lobes": [7]}}
        model.json["extensionsUsed"] = ["X_other"]
        model.json["materials"][0]["extensions"] = {"X_other": {"a": 1}}
        after, _ = self.convert(model, "--lobes")
        self.assertEqual(after.json["extensions"]["X_other"], {"lobes": [7]})
        self.assertEqual(after.json["materials"][0]["extensions"]["X_other"], {"a": 1})
        self.assertEqual(len(after.json["extensions"][NAME]["lobes"]), 1)

    def test_anisotropy_is_refused_beside_lobes(self):
        with open(self.path("in.glb"), "wb") as file:
            file.write(plain_model().glb())
        run = self.run_gltf("in.glb", "out.glb", "--lobes", "--anisotropy")
        self.assertEqual(run.returncode, USAGE, run.stderr)
        self.assertIn("--anisotropy", run.stderr)
        self.assertEqual(os.listdir(self.folder), ["in.glb"])

    @unittest.skipUnless(shutil.which("node") and (MODULES / "three").is_dir(),
                         "no npm packages: tools/install_dependencies test")
    def test_others_read_and_draw_it(self):
        model = Model()
        model.square(repeats=4.0)
        sampler = model.sampler(magFilter=LINEAR, minFilter=MIPMAPPED, wrapS=REPEAT, wrapT=REPEAT)
        normal = model.texture(model.image(ridges(128, 128)), sampler=sampler)
        surface = model.texture(model.image(png(64, 64, lambda x, y: (255, 90 + 40 * (x // 32), 255))),
                                sampler=sampler)
        model.material(normalTexture={"index": normal},
                       pbrMetallicRoughness={"baseColorFactor": [0.9, 0.7, 0.4, 1.0],
                                             "metallicRoughnessTexture": {"index": surface}})
        self.convert(model, "--lobes", form="png")
        run = subprocess.run(["node", str(HERE / "gltf_reading.mjs"), self.path("out.glb")], capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        read, = json.loads(run.stdout)
        self.assertEqual((read["errors"], read["warnings"]), (0, 0), read)
        self.draw()

    def drawn(self, plan):
        """Returns the output of model_pictures.mjs for the pictures of a plan."""
        with open(self.path("plan.json"), "w", encoding="utf-8") as file:
            json.dump(plan, file)
        subprocess.run([MULTUM, "shaders", "-o", self.path("shaders"), "--quiet"], check=True)
        out = os.environ.get("MULTUM_SCREENSHOTS", self.folder)
        os.makedirs(out, exist_ok=True)
        run = subprocess.run(["node", str(HERE.parents[1] / "three" / "model_pictures.mjs"),
                              self.path("shaders/three"), self.path("plan.json"), out],
                             capture_output=True, text=True, check=False)
        if run.returncode == 77:
            self.skipTest(run.stdout)
        self.assertEqual(run.returncode, 0, run.stderr)
        found = json.loads(run.stdout)
        self.assertEqual(found["complaints"], [])
        return found

    def draw(self):
        """From far away, several lobes have a lower error than one lobe, and plain mips have the highest error. The
        reference takes many samples per pixel."""
        run = self.run_gltf("in.glb", "mips.glb", "--lobes")
        self.assertEqual(run.returncode, 0, run.stderr)
        view = {"angle": 20, "target": [0, 0, 0], "width": 64, "height": 64, "samples": 12, "frames": 1, "edges": 0,
                "light": [1, 0.6, 1.5], "intensity": 3, "room": 0, "crop": [0, 0, 64, 64], "zoom": 4}
        eye = [0.3, 0.2, 1]
        plan = {"models": [{"file": "in.glb"}, {"file": "mips.glb"}, {"file": "mips.glb", "lobes": True}],
                "views": [{**view, "name": name, "eye": [at * far for at in eye]}
                          for name, far in (("near", 0.14), ("far", 5.2))]}
        drawn = self.drawn(plan)
        print(json.dumps(drawn["views"]))
        near, far = (drawn["views"][name]["models"] for name in ("near", "far"))
        self.assertEqual([one["lobed"] for one in far], [0, 0, 1])
        for one in near[1:]:
            self.assertAlmostEqual(one["energy"], near[0]["energy"], delta=0.1)
        plain, fitted, lobes = (one["error"] for one in far)
        self.assertLess(fitted, 0.6 * plain)
        self.assertLess(lobes, 0.8 * fitted)


if __name__ == "__main__":
    MULTUM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
