#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that glTF tools keep the extension MULTUM_lobes: glTF-Transform with @multum/gltf-transform
(runtime_gl/web/gltf_transform), the JSON schema in that package, and gltf-validator.

  gltf_transform_test.py MULTUM [unittest's arguments]

Only `multum gltf` makes the models. Needs Node.js, the npm packages of tests/service/web, and Python's jsonschema.
"""
import copy
import hashlib
import json
import math
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest
import warnings

from gltf_readers_test import MODULES
from gltf_test import CLAMP, LINEAR, MIPMAPPED, REPEAT
from model_writing import Glb, Model, bumps, code, glb_of, png

try:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # newer versions of jsonschema have another resolver
        from jsonschema import Draft202012Validator, RefResolver
except ImportError:
    Draft202012Validator = None

MULTUM = ""
SKIPPED = 77
HERE = pathlib.Path(__file__).resolve().parent
PACKAGE = HERE.parents[2] / "runtime_gl/web/gltf_transform"
NAME = "MULTUM_lobes"
INDEX, OBJECT = {"type": "integer", "minimum": 0}, {"type": "object", "properties": {"extensions": {"type": "object"}}}
# The parts of glTF's own schema that the schema of MULTUM_lobes refers to.
GLTF_SCHEMA = {"glTFid.schema.json": INDEX, "glTFProperty.schema.json": OBJECT,
               "textureInfo.schema.json": {**OBJECT, "properties": {"index": INDEX, "texCoord": INDEX},
                                           "required": ["index"]}}
# Other extensions that gltf-validator does not know.
UNKNOWN = ("EXT_meshopt_compression",)
# Every function is tested both by itself and after all others.
FUNCTIONS = ["dedup", "flatten", "join", "weld", "simplify", "resample", "center", "instance", "prune",
             "sparse", "textureCompress", "reorder", "quantize", "partition", "unpartition", "clone", "merge"]


def absence():
    """Returns what is missing, or None."""
    if not shutil.which("node"):
        return "no node (Debian package nodejs)"
    for name in ("@gltf-transform/core", "@gltf-transform/functions", "meshoptimizer", "gltf-validator"):
        if not (MODULES / name).is_dir():
            return f"no npm package {name}: tools/install_dependencies test"
    return None if Draft202012Validator else "no jsonschema (Debian package python3-jsonschema)"


def checkers():
    """Returns functions that check the extension's object of the file and of a material."""
    files = {file.name: json.loads(file.read_text()) for file in (PACKAGE / "schema").iterdir()}
    for name, schema in files.items():
        Draft202012Validator.check_schema(schema)
        assert schema["$id"] == name, name
    store = {**files, **GLTF_SCHEMA}

    def checker(name):
        validator = Draft202012Validator(files[name], resolver=RefResolver(name, files[name], store=store))
        return lambda value: [f"{list(error.absolute_path)}: {error.message}" for error in validator.iter_errors(value)]

    return checker(f"glTF.{NAME}.schema.json"), checker(f"material.{NAME}.schema.json")


def facets(side):
    """Returns a normal map of steep facets, and a map of colours in which the facets that face right are bright."""
    rng = random.Random(5)
    slopes = [[(rng.gauss(0, 0.6), rng.gauss(0, 0.6)) for _ in range(side)] for _ in range(side)]

    def normal(x, y):
        a, b = slopes[y][x]
        length = math.sqrt(a * a + b * b + 1)
        return code(a / length), code(b / length), code(1 / length)

    return (png(side, side, normal),
            png(side, side, lambda x, y: (230, 210, 190) if slopes[y][x][0] > 0 else (40, 30, 30)))


def model():
    """Returns a model of three squares. "paint" has lobes with colours; "plate" has lobes, roughness by a texture and
    transformed coordinates of set 1; "plain" has no lobes."""
    made = Model()
    for number in range(3):
        made.square(number, sets=2, repeats=8.0)
    made.json["nodes"] = [{"mesh": number, "translation": [2.5 * number, 0, 0]} for number in range(3)]
    made.json["scenes"] = [{"nodes": [0, 1, 2]}]
    sampler = made.sampler(magFilter=LINEAR, minFilter=MIPMAPPED, wrapS=REPEAT, wrapT=CLAMP)
    normals, colours = (made.texture(made.image(data), sampler=sampler) for data in facets(64))
    made.material(name="paint", normalTexture={"index": normals},
                  pbrMetallicRoughness={"baseColorTexture": {"index": colours}, "metallicFactor": 0.0,
                                        "roughnessFactor": 0.4})
    normals = made.texture(made.image(bumps(64, 64)), sampler=sampler)
    surface = made.texture(made.image(png(64, 64, lambda x, y: (255, 90 + 40 * (x // 32), 255))), sampler=sampler)
    placed = {"texCoord": 1, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    made.material(name="plate", normalTexture={"index": normals, **placed},
                  pbrMetallicRoughness={"metallicRoughnessTexture": {"index": surface, **placed},
                                        "roughnessFactor": 0.5})
    made.material(name="plain", pbrMetallicRoughness={"roughnessFactor": 0.7})
    made.json["extensionsUsed"] = ["KHR_texture_transform"]
    times = made.accessor("SCALAR", [(0.0,), (1.0,), (2.0,)], min=[0.0], max=[2.0])
    places = made.accessor("VEC3", [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 2.0, 0.0)])
    made.json["animations"] = [{"samplers": [{"input": times, "output": places}],
                                "channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}]}]
    return made.glb()


def hash_of(data):
    return hashlib.sha256(data).hexdigest()


class File:
    """A GLB, or a glTF file with separate files, as another program reads it."""

    def __init__(self, path):
        data = path.read_bytes()
        self.folder, self.glb = path.parent, Glb(data) if path.suffix == ".glb" else None
        self.json = self.glb.json if self.glb else json.loads(data)

    def view(self, number):
        if self.glb:
            return self.glb.view(number)
        view = self.json["bufferViews"][number]
        data = (self.folder / self.json["buffers"][view["buffer"]]["uri"]).read_bytes()
        return data[view.get("byteOffset", 0):][:view["byteLength"]]

    def image(self, texture):
        texture = self.json["textures"][texture]
        source = texture.get("extensions", {}).get("EXT_texture_webp", {}).get("source", texture.get("source"))
        image = self.json["images"][source]
        return self.view(image["bufferView"]) if "bufferView" in image else (self.folder / image["uri"]).read_bytes()

    def lobes(self):
        """Returns all that the extension means for each material, by name, without indices. Bytes are hashed, because
        unittest needs minutes to print how long strings differ."""
        found = {}
        for material in self.json["materials"]:
            own = material.get("extensions", {}).get(NAME)
            if own is None:
                continue
            entry = self.json["extensions"][NAME]["lobes"][own["lobes"]]
            colours, info = entry.get("colours"), own.get("metallicRoughnessTexture")
            texture = self.json["textures"][info["index"]] if info else {}
            found[material["name"]] = {
                "lobes": hash_of(self.view(entry["bufferView"])), "extras": [own.get("extras"), entry.get("extras")],
                "colours": colours and hash_of(self.view(colours["bufferView"])),
                "roughnessFactor": own.get("roughnessFactor", 1.0),
                "image": info and hash_of(self.image(info["index"])),
                "sampler": info and self.json["samplers"][texture["sampler"]],
                "transform": (info or {}).get("extensions"),
                # The coordinates are the coordinates of the normal map.
                "coordinates": info and info.get("texCoord", 0) == material["normalTexture"].get("texCoord", 0)}
        return found


class GltfTransformTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="multum_transform_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        # A project that has installed the packages. Node.js finds the modules of a link where the link leads.
        modules = cls.folder / "node_modules"
        shutil.copytree(PACKAGE, modules / "@multum/gltf-transform")
        for name in ("@gltf-transform", "meshoptimizer"):
            (modules / name).symlink_to(MODULES / name)
        shutil.copy(HERE / "gltf_transforming.mjs", cls.folder)
        (cls.folder / "plain.glb").write_bytes(model())
        run = subprocess.run([MULTUM, "gltf", cls.folder / "plain.glb", "-o", cls.folder / "in.glb", "--lobes",
                              "--format", "png"], capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stderr
        made = Glb((cls.folder / "in.glb").read_bytes())
        # multum writes no extras, but others may add some.
        made.json["materials"][1]["extensions"][NAME]["extras"] = {"note": "material"}
        made.json["extensions"][NAME]["lobes"][0]["extras"] = {"note": "lobes"}
        cls.write(made.json, made.bytes)
        cls.original = File(cls.folder / "in.glb")
        cls.check_file, cls.check_material = map(staticmethod, checkers())

    @classmethod
    def write(cls, document, data, name="in.glb"):
        (cls.folder / name).write_bytes(glb_of(json.dumps(document).encode(), data))

    def transform(self, *plans):
        """Returns the answers of gltf_transforming.mjs."""
        plans = [{**plan, "in": str(self.folder / plan.get("in", "in.glb")), "out": str(self.folder / plan["out"])}
                 for plan in plans]
        (self.folder / "plan.json").write_text(json.dumps(plans))
        run = subprocess.run(["node", "gltf_transforming.mjs", "plan.json"], cwd=self.folder, capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        return json.loads(run.stdout)

    def assert_schema(self, document):
        self.assertEqual(self.check_file(document["extensions"][NAME]), [])
        for material in document["materials"]:
            if NAME in material.get("extensions", {}):
                self.assertEqual(self.check_material(material["extensions"][NAME]), [])

    def assert_valid(self, *names, also=()):
        """gltf-validator does not know the extension. It says so, and it says that objects which only the extension
        uses may be unused. It must not report anything else except for unused vertex attributes and `also`."""
        run = subprocess.run(["node", str(HERE / "gltf_reading.mjs"), *(str(self.folder / name) for name in names)],
                             capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        for name, read in zip(names, json.loads(run.stdout)):
            self.assertEqual((read["errors"], read["warnings"], read["messages"]), (0, 0, []), name)
            document = File(self.folder / name).json
            unknown = {f"UNSUPPORTED_EXTENSION /extensionsUsed/{number}"
                       for number, used in enumerate(document["extensionsUsed"]) if used in (NAME, *UNKNOWN)}
            views = [view["bufferView"] for entry in document["extensions"][NAME]["lobes"]
                     for view in (entry, entry.get("colours")) if view]
            infos = [material.get("extensions", {}).get(NAME, {}).get("metallicRoughnessTexture")
                     for material in document["materials"]]
            unused = {f"UNUSED_OBJECT /bufferViews/{view}" for view in views}
            unused |= {f"UNUSED_OBJECT /textures/{info['index']}" for info in infos if info}
            found = {info for info in read["infos"] if " /meshes/" not in info}
            self.assertEqual(found - unused - set(also), unknown, name)

    def assert_kept(self, name, materials=("paint", "plate"), images=True):
        file = File(self.folder / name)
        self.assertIn(NAME, file.json["extensionsUsed"])
        self.assertNotIn(NAME, file.json.get("extensionsRequired", []))
        self.assert_schema(file.json)
        expected = {key: value for key, value in self.original.lobes().items() if key in materials}
        found = file.lobes()
        if not images:  # images of textures may be compressed, but lobes may not
            for one in (*expected.values(), *found.values()):
                del one["image"]
        self.assertEqual(found, expected, name)
        return file

    def test_multum_writes_what_the_schema_describes(self):
        lobes = self.original.lobes()
        self.assertEqual(set(lobes), {"paint", "plate"})
        self.assertIsNotNone(lobes["paint"]["colours"])
        self.assertEqual(lobes["plate"]["transform"], {"KHR_texture_transform": {"scale": [2, 2]}})
        self.assert_schema(self.original.json)
        self.assert_valid("in.glb")

    def test_every_function_keeps_lobes(self):
        plans = [{"out": f"{name}.glb", "steps": [name]} for name in ("meshopt", *FUNCTIONS) if name != "partition"]
        plans += [{"out": "all.glb", "steps": [*FUNCTIONS, "unpartition", "meshopt", "dedup", "prune"]},
                  {"in": "all.glb", "out": "twice.glb", "steps": FUNCTIONS},
                  {"out": "separate.gltf", "steps": ["partition", "weld"]}, {"out": "none.glb", "steps": []}]
        for plan, answer in zip(plans, self.transform(*plans)):
            self.assertNotIn("error", answer, plan)
            is_compressed = "textureCompress" in plan["steps"] or plan.get("in") == "all.glb"
            self.assert_kept(plan["out"], images=not is_compressed)
            # The lobe textures never reach an encoder: only images of textures do.
            self.assertLessEqual(answer["compressed"], len(self.original.json["images"]), plan)
            if plan["steps"] == ["textureCompress"]:
                self.assertGreater(answer["compressed"], 0)
        self.assert_valid(*(plan["out"] for plan in plans))

    def test_without_the_package_lobes_are_lost(self):
        answer, = self.transform({"out": "out.glb", "steps": [], "plain": True})
        self.assertNotIn("error", answer)
        self.assertEqual(File(self.folder / "out.glb").lobes(), {})

    def test_multum_reads_the_result(self):
        answer, = self.transform({"out": "out.glb", "steps": ["dedup", "weld", "prune"]})
        self.assertNotIn("error", answer)
        run = subprocess.run([MULTUM, "gltf", self.folder / "out.glb", "-o", self.folder / "again.glb", "--lobes",
                              "--format", "png", "--report", self.folder / "report.json"], capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        report = json.loads((self.folder / "report.json").read_text())
        for material in report["materials"][:2]:
            self.assertIn("already has lobes", material["kept"])
        self.assert_kept("again.glb")

    def test_lobes_follow_their_materials(self):
        paint_bytes = len(self.original.view(self.original.json["extensions"][NAME]["lobes"][0]["bufferView"]))
        plans = [{"out": f"{name}.glb", "steps": [name]} for name in ("dropMaterial", "dropNormals", "onlyLobes")]
        for plan, answer in zip(plans, self.transform(*plans)):
            self.assertNotIn("error", answer, plan)
            # Lobes without a normal map cannot be drawn.
            self.assertEqual(any('material "paint" has no normal texture' in text for text in answer["warnings"]),
                             plan["steps"] == ["dropNormals"], answer)
            file = File(self.folder / plan["out"])
            self.assertEqual(len(file.json["extensions"][NAME]["lobes"]), 1)
            if plan["steps"] != ["onlyLobes"]:
                self.assert_kept(plan["out"], materials=("plate",))
                self.assertLess(len(file.glb.bytes), len(self.original.glb.bytes) - paint_bytes)
                continue
            self.assert_schema(file.json)
            found = file.lobes()["paint"]
            self.assertEqual((found["lobes"], found["colours"], found["roughnessFactor"], found["image"]),
                             (self.original.lobes()["paint"]["lobes"], None, 0.25, None))
            self.assert_valid(plan["out"], also=["UNUSED_OBJECT /materials/0"])  # the document has no mesh
        answer, = self.transform({"out": "out.glb", "steps": ["dropLobes"]})
        self.assertIn('material "paint": found MaterialLobes without lobes', answer["error"])

    def test_damage_is_found(self):
        """The reader finds all damage. A schema cannot compare an index with the length of an array, nor read bytes."""
        views, textures = len(self.original.json["bufferViews"]), len(self.original.json["textures"])
        mesh = self.original.json["accessors"][0]["bufferView"]
        damage = [  # value, where it is stored in an object of the extension, words of the reader, seen by the schema
            (None, "lobes", "extensions: found lobes nothing, expected an array", True),
            ({}, "lobes", "extensions: found lobes {}, expected an array", True),
            ([], "lobes", "material 0: found lobes 0, expected the index of one of 0 lobes", True),
            (None, "lobes/0", "lobes 0: found bufferView nothing", True),
            (None, "lobes/0/bufferView", "lobes 0: found bufferView nothing", True),
            (-1, "lobes/0/bufferView", f"bufferView -1, expected the index of one of {views} buffer views", True),
            (views, "lobes/0/bufferView", f"bufferView {views}, expected the index of one of {views}", False),
            (mesh, "lobes/1/bufferView", f"lobes 1: found buffer view {mesh} of other content, expected a KTX2", False),
            (None, "lobes/0/mimeType", "lobes 0: found mimeType nothing, expected image/ktx2", True),
            ("image/png", "lobes/0/mimeType", 'found mimeType "image/png", expected image/ktx2', True),
            (7, "lobes/0/colours", "colours of lobes 0: found bufferView nothing", True),
            (None, "lobes/0/colours/mimeType", "colours of lobes 0: found mimeType nothing", True),
            (mesh, "lobes/0/colours/bufferView", "colours of lobes 0: found buffer view", False),
            (None, "material/lobes", "material 1: found lobes nothing, expected the index of one of 2 lobes", True),
            ("0", "material/lobes", 'material 1: found lobes "0"', True),
            (2, "material/lobes", "material 1: found lobes 2, expected the index of one of 2 lobes", False),
            (1.5, "material/roughnessFactor", "roughnessFactor 1.5, expected a number between 0 and 1", True),
            ("0.5", "material/roughnessFactor", 'found roughnessFactor "0.5"', True),
            (3, "material/metallicRoughnessTexture", "material 1: found metallicRoughnessTexture 3", True),
            (None, "material/metallicRoughnessTexture/index", "found metallicRoughnessTexture", True),
            (textures, "material/metallicRoughnessTexture/index", f"expected the index of one of {textures}", False)]
        plans = []
        for number, (value, place, _, is_seen) in enumerate(damage):
            document = copy.deepcopy(self.original.json)
            *way, last = [int(name) if name.isdigit() else name for name in place.split("/")]
            at = document["extensions"][NAME]
            if way and way[0] == "material":
                at, way = document["materials"][1]["extensions"][NAME], way[1:]
            for name in way:
                at = at[name]
            if value is None and isinstance(at, dict):
                del at[last]
            else:
                at[last] = value
            self.write(document, self.original.glb.bytes, f"damaged{number}.glb")
            plans.append({"in": f"damaged{number}.glb", "out": "out.glb", "steps": []})
            faults = self.check_file(document["extensions"][NAME])
            faults += self.check_material(document["materials"][1]["extensions"][NAME])
            self.assertEqual(bool(faults), is_seen, (place, value, faults))
        for (value, place, words, _), answer in zip(damage, self.transform(*plans)):
            self.assertIn(words, answer.get("error", ""), (place, value))
            self.assertTrue(answer["error"].startswith(NAME + ": "), answer)


if __name__ == "__main__":
    if absence():
        print(f"gltf_transform_test: skipped: {absence()}")
        sys.exit(SKIPPED)
    MULTUM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
