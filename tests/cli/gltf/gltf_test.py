#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the rules of docs/reference/gltf.md, one generated model per rule: which materials are fitted together, what
the new textures hold, and what stays unchanged.

  gltf_test.py MULTUM [unittest's arguments]
"""
import copy
import json
import math
import os
import signal
import subprocess
import sys
import time
import unittest

from folder_case import FolderCase
from model_writing import Glb, Model, bumps, code, png

MULTUM = ""
INPUT_REFUSED, ENVIRONMENT, USAGE = 3, 4, 2
REPEAT, CLAMP = 10497, 33071
MIPMAPPED = 9987
LINEAR = 9729


def packed(width, height, texel=None):
    """Returns codes of occlusion, roughness and metalness."""
    return png(width, height, texel or (lambda x, y: (255 - 3 * (x % 64), 60 + 40 * ((x + y) % 2), 255 * (x % 2))))


def plain_model(normal=None, surface=None, **factors):
    """Returns a model of one material with a normal map and a metallic-roughness texture."""
    model = Model()
    model.square()
    sampler = model.sampler(magFilter=LINEAR, minFilter=LINEAR, wrapS=REPEAT, wrapT=REPEAT)
    normal_texture = model.texture(model.image(normal or bumps(16, 8)), sampler=sampler, name="normals")
    surface_texture = model.texture(model.image(surface or packed(16, 8)), sampler=sampler)
    model.material(name="bricks", normalTexture={"index": normal_texture},
                   pbrMetallicRoughness={"metallicRoughnessTexture": {"index": surface_texture}, **factors})
    return model


class GltfTest(FolderCase):
    def write(self, name, data):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "wb") as file:
            file.write(data)

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def run_gltf(self, *arguments, source="in.glb", output="out.glb", form="one-lobe"):
        return subprocess.run([MULTUM, "gltf", self.path(source), "-o", self.path(output), "--form", form,
                               *arguments], capture_output=True, text=True, check=False)

    def convert(self, model, *arguments, source="in.glb", form="one-lobe"):
        """Returns the converted model and the report."""
        if isinstance(model, Model):
            self.write(source, model.glb())
        run = self.run_gltf("--format", "rgba8", "--report", self.path("report.json"), *arguments, source=source,
                            form=form)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.messages = run.stderr
        return Glb(self.read("out.glb")), json.loads(self.read("report.json"))

    def assert_kept(self, model, *words):
        """Expects that no material is fitted and that the JSON is unchanged except for its buffer."""
        before = copy.deepcopy(model.json)
        after, report = self.convert(model)
        for word in words:
            self.assertIn(word, report["materials"][0]["kept"])
        self.assertEqual(report["textures"], [])
        for name, value in before.items():
            if name not in ("buffers", "bufferViews"):
                self.assertEqual(after.json[name], value, name)
        self.assertEqual(list(after.json)[:len(before)], list(before))

    def test_textures_are_replaced_where_they_stand(self):
        model = plain_model()
        model.json["materials"][0]["occlusionTexture"] = {"index": 1, "strength": 0.5}
        before = copy.deepcopy(model.json)
        after, report = self.convert(model)
        self.assertEqual(after.json["materials"], before["materials"])
        for texture, old in zip(after.json["textures"], before["textures"]):
            self.assertEqual(texture["extensions"]["KHR_texture_basisu"]["source"], old["source"])
            self.assertEqual(texture.get("name"), old.get("name"))
            self.assertNotIn("source", texture)
        self.assertEqual(len(after.json["images"]), 2)
        self.assertEqual([i["mimeType"] for i in after.json["images"]], ["image/ktx2"] * 2)
        self.assertEqual(len(after.json["bufferViews"]), len(before["bufferViews"]))
        self.assertEqual(after.json["samplers"], [{**before["samplers"][0], "minFilter": MIPMAPPED}])
        self.assertEqual(after.json["extensionsRequired"], ["KHR_texture_basisu"])
        # The old images are removed from the buffer, and the mesh data is unchanged.
        self.assertNotIn(b"IHDR", after.bytes)
        source = Glb(self.read("in.glb"))
        for accessor in before["accessors"]:
            view = accessor["bufferView"]
            self.assertEqual(after.view(view), source.view(view))
            self.assertEqual(after.json["bufferViews"][view].get("byteOffset", 0) % 4, 0)
        normal, surface = after.levels(0), after.levels(1)
        self.assertEqual([(level.width, level.height) for level in normal],
                         [(16, 8), (8, 4), (4, 2), (2, 1), (1, 1)])
        # Level 0 has the images' values. Later levels are rougher, and their occlusion and metalness are averages.
        self.assertEqual(surface[0].at(4, 2)[:3], (255 - 12, 60, 0))
        self.assertEqual(surface[0].at(5, 2)[:3], (255 - 15, 100, 255))
        for channel in (0, 2):
            self.assertAlmostEqual(surface[4].mean(channel), surface[0].mean(channel), delta=1.0)
        roughness = [level.mean(1) for level in surface]
        self.assertGreater(roughness[1], roughness[0] + 30)
        self.assertGreater(roughness[4], roughness[1])
        self.assertEqual(report["materials"], [{"name": "bricks", "fitted": True, "textures": 0}])
        self.assertEqual(report["textures"][0]["levels"], 5)
        self.assertEqual(report["bytes_after"], len(self.read("out.glb")))
        self.assertEqual(report["bytes_before"], len(self.read("in.glb")))
        self.assertIn("KHR_texture_basisu, does not allow", self.messages)

    def test_level_0_of_normals_stays_as_it_was(self):
        """The vectors include some that are not unit vectors. A second rounding would change their directions."""
        def texel(x, y):
            length = 0.93 + 0.01 * x
            return code(0.3 * length), code(0.1 * (y % 3) * length), code(0.93 * length)

        after, _ = self.convert(plain_model(normal=png(8, 8, texel), surface=packed(8, 8)))
        normal = after.levels(0)
        self.assertEqual([normal[0].at(x, y)[:3] for y in range(8) for x in range(8)],
                         [texel(x, y) for y in range(8) for x in range(8)])
        self.assertAlmostEqual(math.hypot(*(2 * c / 255 - 1 for c in normal[1].at(1, 1)[:3])), 1.0, delta=0.01)

    def test_factors_move_into_the_textures(self):
        model = plain_model(normal=png(4, 4, lambda x, y: (code(0.3), code(0.0), code(math.sqrt(1 - 0.09)))),
                            surface=png(4, 4, lambda x, y: (255, 128, 200)), roughnessFactor=0.5, metallicFactor=0.25)
        model.json["materials"][0]["normalTexture"]["scale"] = 2.0
        after, report = self.convert(model)
        material = after.json["materials"][0]
        self.assertNotIn("scale", material["normalTexture"])
        self.assertNotIn("roughnessFactor", material["pbrMetallicRoughness"])
        self.assertEqual(material["pbrMetallicRoughness"]["metallicFactor"], 0.25)
        red, green, blue, _ = after.levels(0)[0].at(1, 1)
        length = math.hypot(0.6, math.sqrt(1 - 0.09))
        self.assertAlmostEqual(red, code(0.6 / length), delta=1)
        self.assertAlmostEqual(green, code(0.0), delta=1)
        self.assertAlmostEqual(blue, code(math.sqrt(1 - 0.09) / length), delta=1)
        # All normals are equal, so no level is rougher than the surface.
        for level in after.levels(1):
            self.assertEqual(level.at(0, 0)[:3], (255, 64, 200))
        self.assertEqual(len(report["materials"][0]["notes"]), 2)
        self.assertIn("roughnessFactor 0.5", report["materials"][0]["notes"][1])

    def test_roughness_without_a_texture_gets_one(self):
        model = Model()
        model.square(sets=2)
        texture = model.texture(model.image(bumps(8, 8)))
        moved = {"KHR_texture_transform": {"scale": [2.0, 2.0], "rotation": 0.5}}
        model.json["extensionsUsed"] = ["KHR_texture_transform"]
        model.material(normalTexture={"index": texture, "texCoord": 1, "extensions": moved},
                       pbrMetallicRoughness={"roughnessFactor": 0.4, "metallicFactor": 0.75})
        after, _ = self.convert(model)
        surface = after.json["materials"][0]["pbrMetallicRoughness"]
        self.assertEqual(surface, {"metallicFactor": 0.75, "metallicRoughnessTexture":
                                   {"index": 1, "texCoord": 1, "extensions": moved}})
        levels = after.levels(1)
        self.assertEqual(levels[0].at(3, 3)[:3], (255, 102, 255))
        self.assertGreater(levels[3].at(0, 0)[1], 130)
        # A texture without a sampler gets a sampler that repeats, which is the default of glTF.
        self.assertEqual(after.json["samplers"], [{"magFilter": LINEAR, "minFilter": MIPMAPPED}])

    def test_a_dull_surface_needs_no_roughness(self):
        model = Model()
        model.square()
        model.material(normalTexture={"index": model.texture(model.image(bumps(8, 8)))})
        after, report = self.convert(model)
        self.assertNotIn("pbrMetallicRoughness", after.json["materials"][0])
        self.assertEqual(list(report["textures"][0]["bytes"]), ["normal"])

    def test_what_does_not_lie_together_is_kept(self):
        transform = {"extensions": {"KHR_texture_transform": {"offset": [0.5, 0.0]}}}
        for change, word in (({"texCoord": 1}, "coordinates"), (transform, "transform"),
                             ({"extensions": {"KHR_texture_transform": {"texCoord": 1}}}, "coordinates")):
            with self.subTest(change=change):
                model = plain_model()
                model.json["extensionsUsed"] = ["KHR_texture_transform"]
                model.json["materials"][0]["normalTexture"].update(change)
                self.assert_kept(model, word)
        model = plain_model()
        model.json["textures"][1]["sampler"] = model.sampler(wrapS=CLAMP)
        self.assert_kept(model, "wraps")
        # A texture transform is kept if both textures have it. An identity transform counts as no transform.
        for both in (transform, {"extensions": {"KHR_texture_transform": {}}}):
            model = plain_model()
            model.json["materials"][0]["normalTexture"].update(both)
            if both is transform:
                model.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"].update(both)
            after, report = self.convert(model)
            self.assertTrue(report["materials"][0]["fitted"])
            self.assertEqual(after.json["materials"][0]["normalTexture"], {"index": 0, **both})

    def test_materials_of_other_rules_are_kept(self):
        for name in ("KHR_materials_pbrSpecularGlossiness", "KHR_materials_unlit", "KHR_materials_anisotropy"):
            model = plain_model()
            model.json["materials"][0]["extensions"] = {name: {}}
            model.json["extensionsUsed"] = [name]
            self.assert_kept(model, name)
        model = Model()
        model.square()
        model.material(pbrMetallicRoughness={"metallicRoughnessTexture": {
            "index": model.texture(model.image(packed(4, 4)))}})
        self.assert_kept(model, "no normal map")
        model = plain_model()
        model.json["animations"] = [{"channels": [{"sampler": 0, "target": {
            "path": "pointer", "extensions": {"KHR_animation_pointer": {
                "pointer": "/materials/0/pbrMetallicRoughness/roughnessFactor"}}}}],
            "samplers": [{"input": 4, "output": 4}]}]
        model.json["extensionsUsed"] = ["KHR_animation_pointer"]
        self.assert_kept(model, "animation", "roughnessFactor")
        model = plain_model(normal=png(1, 1, lambda x, y: (128, 128, 255)))
        self.assert_kept(model, "single texel")
        model = plain_model(normal=bumps(64, 1), surface=packed(1, 64))
        self.assert_kept(model, "64 x 1", "1 x 64")
        model = plain_model(normal=b"\xabKTX 20\xbb\r\n\x1a\n" + b"\0" * 68)
        self.assert_kept(model, "no PNG, JPEG or WebP")

    def test_one_bad_map_leaves_the_others(self):
        grey = png(16, 16, lambda x, y: (128, 128, 128))
        slopes = bumps(32, 32, 0.3)
        # This map has occlusion in blue, where z should be.
        packed_blue = png(32, 32, lambda x, y: (code(0.3 * math.sin(0.6 * x)), code(0.3 * math.sin(0.6 * y)),
                                                round(150 + 50 * math.sin(0.2 * x) + 55 * math.cos(0.3 * y))))
        for bad, scale, options, word in ((grey, 1.0, (), "grey"), (slopes, 1e300, (), "scale is 1e+300"),
                                          (slopes[:300], 1.0, (), "cut"), (packed_blue, 1.0, (), "--two-channel"),
                                          (packed_blue, 1.0, ("--two-channel",), None)):
            with self.subTest(word=word):
                model = plain_model()
                texture = model.texture(model.image(bad))
                model.material(name="other", normalTexture={"index": texture, "scale": scale})
                after, report = self.convert(model, *options)
                self.assertTrue(report["materials"][0]["fitted"])
                self.assertEqual(report["materials"][1]["fitted"], word is None)
                if word is None:
                    continue
                self.assertIn(word, report["materials"][1]["kept"])
                self.assertIn("'other' is unchanged", self.messages)
                self.assertNotIn("multum-partial", self.messages)
                self.assertNotIn("--green", self.messages)
                self.assertEqual(after.json["materials"][1], model.json["materials"][1])
                self.assertEqual(after.image(texture), bad)
        # A blue channel that stores z as 0 to 1 is found and reported.
        steep = [[math.sin(0.4 * x), math.cos(0.3 * y), 1.0] for y in range(32) for x in range(32)]
        lengths = [math.sqrt(sum(v * v for v in n)) for n in steep]
        self.convert(plain_model(normal=png(32, 32, lambda x, y: (
            code(steep[32 * y + x][0] / lengths[32 * y + x]), code(steep[32 * y + x][1] / lengths[32 * y + x]),
            round(255 / lengths[32 * y + x])))))
        self.assertIn("z from 0 to 1", self.messages)
        # The message must not suggest options of other commands.
        self.convert(plain_model(normal=bumps(32, 32, -0.6)))
        self.assertNotIn("--green", self.messages)

    def test_the_same_combination_is_fitted_once(self):
        model = plain_model()
        first = model.json["materials"][0]
        model.json["materials"] += [copy.deepcopy(first) for _ in range(3)]
        model.json["materials"][2]["pbrMetallicRoughness"]["roughnessFactor"] = 0.5
        # Two textures with the same image and equal samplers count as the same texture.
        model.json["materials"][3]["normalTexture"]["index"] = model.texture(0, sampler=0)
        after, report = self.convert(model)
        self.assertEqual([one["textures"] for one in report["materials"]], [0, 0, 1, 0])
        self.assertEqual(len(after.json["images"]), 4)
        materials = after.json["materials"]
        self.assertEqual(materials[0], materials[1])
        self.assertEqual(materials[0]["normalTexture"], materials[3]["normalTexture"])
        one, other = (m["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] for m in materials[1:3])
        self.assertEqual(one, 1)
        self.assertAlmostEqual(after.levels(other)[0].mean(1), after.levels(one)[0].mean(1) / 2, delta=1)
        # The merged texture shows the same image.
        basis = [t["extensions"]["KHR_texture_basisu"]["source"] for t in after.json["textures"]]
        self.assertEqual(basis[2], basis[0])

    def test_an_image_with_another_use_stays(self):
        model = plain_model()
        material = model.json["materials"][0]
        material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 1}
        material["occlusionTexture"] = {"index": 1, "texCoord": 1}
        model.json["meshes"] = []
        model.square(sets=2)
        before = copy.deepcopy(model.json)
        after, report = self.convert(model)
        self.assertEqual(after.json["textures"][1], before["textures"][1])
        self.assertEqual(after.json["images"][1], before["images"][1])
        source = Glb(self.read("in.glb"))
        self.assertEqual(after.image(1), source.image(1))
        material = after.json["materials"][0]
        self.assertEqual(material["pbrMetallicRoughness"]["baseColorTexture"], {"index": 1})
        self.assertEqual(material["occlusionTexture"], {"index": 1, "texCoord": 1})
        self.assertEqual(material["pbrMetallicRoughness"]["metallicRoughnessTexture"], {"index": 2})
        # Red is not used as occlusion there; the old sampler is unchanged.
        self.assertEqual(after.levels(2)[0].at(5, 2)[:3], (255, 100, 255))
        self.assertEqual(after.json["samplers"][0], before["samplers"][0])
        self.assertEqual(after.json["samplers"][after.json["textures"][2]["sampler"]]["minFilter"], MIPMAPPED)
        self.assertIn("occlusion still uses the original image", report["materials"][0]["notes"][0])

    def test_what_is_not_known_is_not_touched(self):
        model = plain_model()
        before_views = len(model.json["bufferViews"])
        for index in (0, before_views - 2):  # the index of a texture, and the index of a buffer view
            with self.subTest(index=index):
                model = plain_model()
                model.json["extensionsUsed"] = ["ACME_thing"]
                model.json["materials"][0]["extensions"] = {"ACME_thing": {"deep": [{"uses": index}]}}
                before = copy.deepcopy(model.json)
                after, _ = self.convert(model)
                source = Glb(self.read("in.glb"))
                if index == 0:
                    self.assertEqual(after.json["textures"][0], before["textures"][0])
                    self.assertEqual(after.image(0), source.image(0))
                else:
                    self.assertEqual(after.view(index), source.view(index))
                self.assertEqual(after.json["materials"][0]["extensions"], before["materials"][0]["extensions"])

    def test_everything_else_is_what_it_was(self):
        model = plain_model()
        sparse = {"count": 2, "indices": {"bufferView": model.view(b"\x01\0\x03\0"), "componentType": 5123},
                  "values": {"bufferView": model.view(bytes(range(24))), "byteOffset": 0}}
        model.json["accessors"].append({"componentType": 5126, "type": "VEC3", "count": 4, "sparse": sparse})
        model.json["accessors"][0]["extras"] = {"index": 0, "bufferView": 77, "text": "gr\u00fc\u00df", "big": 2**60,
                                                "small": 1e-300, "none": None, "deep": [[[]], {}]}
        shared = model.json["bufferViews"][model.json["images"][0]["bufferView"]]
        # If another buffer view also refers to an image's bytes, the bytes stay.
        model.json["bufferViews"].append({**shared, "name": "the same"})
        model.json["bufferViews"].append({**shared, "byteOffset": shared["byteOffset"] + 20, "byteLength": 30})
        interleaved = model.view(bytes(range(96)), byteStride=24, target=34962)
        model.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}]
        model.json["nodes"].append({"camera": 0, "translation": [0.1, 0.30000000000000004, 3]})
        model.json["animations"] = [{"samplers": [{"input": 4, "output": 5}],
                                     "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]}]
        model.json["buffers"] = [None, {"byteLength": 8, "uri": "data:;base64,AAECAwQFBgc=", "extras": {"mine": 1}}]
        model.json["bufferViews"].append({"buffer": 1, "byteOffset": 4, "byteLength": 4})
        model.json["extensions"] = {"ACME_scene": {"name": "x"}}
        model.json["extensionsUsed"] = ["ACME_scene"]
        model.json["extras"] = {"a": [1.5]}
        before = copy.deepcopy(model.json)
        after, _ = self.convert(model)
        source = Glb(self.read("in.glb"))
        for name, value in before.items():
            if name not in ("bufferViews", "buffers", "images", "textures", "samplers", "extensionsUsed"):
                self.assertEqual(after.json[name], value, name)
        replaced = {image["bufferView"] for image in before["images"]}
        for number, view in enumerate(before["bufferViews"]):
            if number in replaced:
                continue
            self.assertEqual(after.view(number), source.view(number), number)
            moved = {"byteOffset", "buffer"}
            self.assertEqual({k: v for k, v in after.json["bufferViews"][number].items() if k not in moved},
                             {k: v for k, v in view.items() if k not in moved})
        self.assertEqual((after.json["bufferViews"][interleaved]["byteOffset"] -
                          before["bufferViews"][interleaved]["byteOffset"]) % 16, 0)
        self.assertEqual(after.json["buffers"][1]["extras"], {"mine": 1})
        self.assertEqual(after.view(len(before["bufferViews"]) - 1), bytes((4, 5, 6, 7)))

    def test_buffers_that_extensions_fill(self):
        model = plain_model()
        packed_bytes = model.view(bytes(range(1, 50)))
        place = model.json["bufferViews"].pop(packed_bytes)
        fallback = {"byteLength": 96, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}
        model.json["buffers"] = [None, fallback]
        model.json["bufferViews"].append({"buffer": 1, "byteLength": 96, "byteStride": 12, "extensions": {
            "EXT_meshopt_compression": {**place, "byteStride": 12, "mode": "ATTRIBUTES", "count": 8}}})
        model.json["extensionsUsed"] = model.json["extensionsRequired"] = ["EXT_meshopt_compression"]
        before = copy.deepcopy(model.json)
        after, _ = self.convert(model)
        self.assertEqual(after.json["buffers"][1], before["buffers"][1])
        view = after.json["bufferViews"][packed_bytes]
        self.assertEqual((view["buffer"], view["byteLength"]), (1, 96))
        extension = view["extensions"]["EXT_meshopt_compression"]
        self.assertEqual(extension["buffer"], 0)
        self.assertNotEqual(extension["byteOffset"], place["byteOffset"])
        self.assertEqual(after.bytes[extension["byteOffset"]:][:49], bytes(range(1, 50)))

    def test_roughness_of_another_size_is_brought_to_it(self):
        for wrap, expected in ((CLAMP, 40), (REPEAT, 80)):
            model = plain_model(normal=png(8, 8, lambda x, y: (128, 128, 255)),
                                surface=png(4, 4, lambda x, y: (255, 40 if x == 0 else 200, 0)))
            model.json["samplers"][0].update(wrapS=wrap, wrapT=wrap)
            after, report = self.convert(model)
            level = after.levels(1)[0]
            self.assertEqual((level.width, level.height), (8, 8))
            # The point is a quarter of a texel beyond the border, so a lookup there shows either the border texel or
            # the opposite side.
            self.assertAlmostEqual(level.at(0, 3)[1], expected, delta=1)
            self.assertAlmostEqual(level.at(2, 3)[1], 160, delta=1)
            self.assertIn("the same size", report["materials"][0]["notes"][0])

    def test_files_beside_the_model_come_into_it(self):
        model = plain_model()
        pictures = {"a normal.png": bumps(8, 8), "maps/orm.png": packed(8, 8), "colour.png": packed(4, 4)}
        for name, data in pictures.items():
            self.write(name, data)
        model.json["images"] = [{"uri": "a%20normal.png"}, {"uri": "maps/orm.png"}, {"uri": "colour.png"}]
        model.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": model.texture(2)}
        self.write("in.gltf", model.gltf("all.bin"))
        self.write("all.bin", model.bytes)
        after, report = self.convert(None, source="in.gltf")
        self.assertEqual(after.json["images"][2]["mimeType"], "image/png")
        self.assertEqual(after.image(2), pictures["colour.png"])
        self.assertFalse(any("uri" in one for one in after.json["images"] + after.json["buffers"]))
        self.assertEqual(report["bytes_before"], len(self.read("in.gltf")) + len(model.bytes) +
                         sum(map(len, pictures.values())))

    def test_anisotropy_on_demand(self):
        model = plain_model(normal=png(16, 16, lambda x, y: (code(0.6 * (-1) ** x), code(0.0), code(0.8))))
        after, _ = self.convert(model, "--anisotropy")
        extension = after.json["materials"][0]["extensions"]["KHR_materials_anisotropy"]
        self.assertEqual(extension["anisotropyStrength"], 1.0)
        self.assertIn("KHR_materials_anisotropy", after.json["extensionsUsed"])
        self.assertNotIn("KHR_materials_anisotropy", after.json["extensionsRequired"])
        red, green, blue, _ = after.levels(extension["anisotropyTexture"]["index"])[2].at(1, 1)
        self.assertAlmostEqual(abs(2 * red / 255 - 1), 1.0, delta=0.02)  # along x, the direction of the tilts
        self.assertAlmostEqual(2 * green / 255 - 1, 0.0, delta=0.05)
        self.assertGreater(blue, 150)
        for transform in ({"rotation": 1.0}, {"scale": [-1.0, 1.0]}, {"scale": [1.0, -1.0]}):
            with self.subTest(transform):
                model = plain_model()
                turned = {"extensions": {"KHR_texture_transform": transform}}
                model.json["materials"][0]["normalTexture"].update(turned)
                model.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"].update(turned)
                after, report = self.convert(model, "--anisotropy")
                self.assertNotIn("extensions", after.json["materials"][0])
                self.assertIn("anisotropy was left out", report["materials"][0]["notes"][0])

    def test_a_smooth_map_keeps_its_own_textures(self):
        model = plain_model(normal=bumps(64, 64, steepness=0.005), surface=packed(64, 64, lambda x, y: (255, 150, 255)))
        after, report = self.convert(model, form="auto")
        self.assertIn("its original textures", report["materials"][0]["kept"])
        self.assertIn("its own maps stay", report["materials"][0]["form"])
        self.assertEqual(report["textures"], [])
        self.assertEqual(after.json["textures"], model.json["textures"])
        # The original sampler had no mips.
        self.assertEqual([sampler["minFilter"] for sampler in after.json["samplers"]], [MIPMAPPED])

    def test_steep_bumps_get_what_is_nearer(self):
        model = plain_model(normal=bumps(64, 64), surface=packed(64, 64, lambda x, y: (255, 60, 255)))
        after, report = self.convert(model, form="auto")
        self.assertTrue(report["materials"][0]["fitted"])
        form, = report["forms"]
        self.assertEqual(len(form["levels"]), 7)
        self.assertEqual(form["levels"][0], {"fitted_normals": False, "fitted_roughness": 0.0})
        errors = {name: form["errors"][name] for name in ("plain", "one_lobe", "chosen")}
        self.assertEqual({len(one) for one in errors.values()}, {len(form["distances"])})
        for plain, chosen in zip(errors["plain"], errors["chosen"]):
            self.assertLessEqual(chosen, plain + 0.11)
        self.assertLess(sum(errors["chosen"]), 0.95 * sum(errors["plain"]))
        # The textures hold the chosen values, so the roughness of the coarsest level is higher than the roughness of
        # the map.
        surface = after.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"]
        roughness = [level.mean(1) for level in after.levels(surface)]
        self.assertEqual(roughness[0], 60)
        for level, chosen in enumerate(form["levels"]):
            self.assertEqual(roughness[level] > 60, chosen["fitted_roughness"] > 0, level)

    def test_a_model_without_a_mesh_is_judged_on_a_sphere(self):
        model = plain_model(normal=bumps(64, 64))
        del model.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]
        _, report = self.convert(model, form="auto")
        self.assertTrue(report["forms"][0]["on_sphere"])

    def test_png_has_level_0_alone_and_says_so(self):
        self.write("in.glb", plain_model().glb())
        run = self.run_gltf("--format", "png")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("the fitted levels are lost", run.stderr)
        after = Glb(self.read("out.glb"))
        self.assertTrue(after.image(0).startswith(b"\x89PNG"))
        self.assertNotIn("extensionsRequired", after.json)

    def test_an_engine_selects_the_format(self):
        self.write("in.glb", plain_model().glb())
        run = self.run_gltf("--for", "blender", "--report", self.path("report.json"))
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual([i["mimeType"] for i in Glb(self.read("out.glb")).json["images"]], ["image/png"] * 2)
        self.assertEqual(json.loads(self.read("report.json"))["for"], "blender")
        run = self.run_gltf("--for", "blender", "--format", "rgba8")  # an option replaces the engine's format
        self.assertEqual([i["mimeType"] for i in Glb(self.read("out.glb")).json["images"]], ["image/ktx2"] * 2)
        os.mkdir(self.path("none"))
        for engine in ("babylon", "godot", "unity-hdrp"):
            run = self.run_gltf("--for", engine, "--encoder", self.path("none"))
            self.assertEqual(run.returncode, 4)
            self.assertIn("ktx2-encoder", run.stderr)

    def test_the_same_bytes_for_any_threads_and_memory(self):
        self.write("in.glb", plain_model(normal=bumps(128, 64), surface=packed(64, 64)).glb())
        found = set()
        for more in (("--threads", "1"), ("--threads", "3"), ("--memory", "600k")):
            run = self.run_gltf("--format", "rgba8", *more)
            self.assertEqual(run.returncode, 0, run.stderr)
            found.add(self.read("out.glb"))
        self.assertEqual(len(found), 1)

    def test_an_interrupted_run_leaves_nothing(self):
        self.write("in.glb", plain_model(normal=bumps(512, 512), surface=packed(512, 512)).glb())
        self.write("out.glb", b"an older file")
        process = subprocess.Popen([MULTUM, "gltf", self.path("in.glb"), "-o", self.path("out.glb"), "--format",
                                    "rgba8", "--threads", "1"], stderr=subprocess.PIPE)
        hidden = self.path(".multum-partial-out.glb")
        end = time.time() + 60
        while time.time() < end and not (os.path.isdir(hidden) and any("levels" in n for n in os.listdir(hidden))):
            time.sleep(0.002)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertEqual(sorted(os.listdir(self.folder)), ["in.glb", "out.glb"])
        self.assertEqual(self.read("out.glb"), b"an older file")


if __name__ == "__main__":
    MULTUM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
