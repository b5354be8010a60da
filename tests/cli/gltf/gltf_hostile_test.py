#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests damaged and malicious models. Each model is refused with a message that names the problem, and no file is left
behind.

  gltf_hostile_test.py MULTUM [unittest's arguments]
"""
import json
import os
import random
import subprocess
import sys
import tempfile
import unittest

from gltf_test import INPUT_REFUSED, USAGE, ENVIRONMENT, packed, plain_model
from model_writing import bumps, glb_of

MULTUM = ""
BROKEN_FILES = 60  # the number of runs of the last test, each in its own process


class HostileTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="multum_gltf_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        os.mkdir(os.path.join(self.folder, "model"))

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_gltf(self, source, *arguments, output="model/out.glb"):
        # No file may keep a process busy for two minutes of processor time.
        return subprocess.run(["prlimit", "--cpu=120", MULTUM, "gltf", self.path(source), "-o", self.path(output),
                               "--form", "one-lobe", "--format", "rgba8",
                               *arguments], capture_output=True, text=True, check=False)

    def assert_refused(self, data, *words, name="model/in.glb", code=INPUT_REFUSED):
        with open(self.path(name), "wb") as file:
            file.write(data)
        run = self.run_gltf(name)
        self.assertEqual(run.returncode, code, run.stderr)
        for word in ("model", *words):
            self.assertIn(word, run.stderr)
        self.assertEqual(os.listdir(self.path("model")), [os.path.basename(name)])
        os.remove(self.path(name))

    def changed(self, change):
        """Returns the GLB of a valid model after `change(json)`."""
        model = plain_model()
        model.glb()
        change(model.json)
        return glb_of(json.dumps(model.json).encode(), model.bytes)

    def test_frames(self):
        model = plain_model()
        good = model.glb()
        text = json.dumps(model.json).encode()
        self.assert_refused(b"", "does not begin with glTF")
        self.assert_refused(b"glTF\x02", "it has 5 bytes, expected a header of 12")
        self.assert_refused(good[:len(good) // 2], str(len(good)), str(len(good) // 2))
        self.assert_refused(good + b"\0", str(len(good)), str(len(good) + 1))
        self.assert_refused(good[:4] + b"\x01" + good[5:], "version 1")
        self.assert_refused(glb_of(text, model.bytes, json_length=2**31), "chunk 0 of 2147483648 bytes")
        self.assert_refused(glb_of(text, model.bytes, data_length=2**32 - 1), "chunk 1 of 4294967295 bytes")
        self.assert_refused(glb_of(text, model.bytes, json_length=8), "chunk 1 of")
        self.assert_refused(good.replace(b"JSON", b"BIN\0", 1), "first chunk")
        self.assert_refused(good[:12], "20" if len(good) == 20 else str(len(good)))

    def test_json(self):
        deep = b'{"asset":{"version":"2.0"},"extras":' + b"[" * 100_000 + b"]" * 100_000 + b"}"
        many = b'{"asset":{"version":"2.0"},"extras":[' + b"0," * 8_000_001 + b"0]}"
        self.assert_refused(glb_of(deep, b""), "deeper than the limit of 64")
        self.assert_refused(glb_of(many, b""), "more than 8000000 values")
        self.assert_refused(glb_of(b" " * (2**26 + 4), b""), "67108864")
        self.assert_refused(glb_of(b'{"asset":{"version":"2.0"}', b""), "cannot be parsed")
        self.assert_refused(glb_of(b'{"asset":{"version":"2.0"},"extras":"\xff"}', b""), "cannot be parsed")
        self.assert_refused(glb_of(b"[]", b""), "not an object")
        self.assert_refused(glb_of(b'{"asset":{"version":"1.0"}}', b""), "version '1.0'")
        self.assert_refused(glb_of(b'{"asset":7}', b""), "version ''")
        self.assert_refused(b"{", "cannot be parsed", name="model/in.gltf")

    def test_references(self):
        def setting(*keys, to):
            def change(model):
                for key in keys[:-1]:
                    model = model[key]
                model[keys[-1]] = to
            return change

        view = setting("bufferViews", 0, "byteLength", to=2**40)
        cases = ((view, "buffer view 0 refers to bytes 0 to 1099511627776"),
                 (setting("bufferViews", 0, "byteOffset", to=2**64 - 8), "buffer view 0"),
                 (setting("bufferViews", 0, "byteOffset", to=-4), "buffer view 0"),
                 (setting("bufferViews", 0, "buffer", to=1), "buffer is 1"),
                 (setting("buffers", 0, "byteLength", to=10**9), "buffer 0 declares 1000000000 bytes"),
                 (setting("buffers", 0, "byteLength", to="x"), "buffer 0 has no byteLength"),
                 (setting("images", 0, to={}), "image 0"),
                 (setting("images", 0, "bufferView", to=99), "bufferView is 99"),
                 (setting("images", to={}), "images is not an array"),
                 (setting("textures", 0, to=3), "textures is not an array of objects"),
                 (setting("textures", 0, "source", to=7), "source is 7"),
                 (setting("textures", 0, "sampler", to=7), "sampler is 7"),
                 (setting("samplers", 0, "wrapS", to=1), "'bricks'", "wrapS is 1"),
                 (setting("materials", 0, "normalTexture", to=[]), "'bricks'", "normalTexture is not an object"),
                 (setting("materials", 0, "normalTexture", "index", to=5), "index is 5"),
                 (setting("materials", 0, "normalTexture", "index", to=0.5), "index is 0.5"),
                 (setting("materials", 0, "normalTexture", "texCoord", to="a"), "texCoord"),
                 (setting("materials", 0, "normalTexture", "scale", to=1e300), "'bricks'", "scale is 1e+300"),
                 (setting("materials", 0, "pbrMetallicRoughness", "roughnessFactor", to=1.5), "roughnessFactor is 1.5"),
                 (setting("materials", 0, "pbrMetallicRoughness", to="x"), "pbrMetallicRoughness is not an object"),
                 (setting("materials", 0, "extensions", to=1), "extensions is not an object"))
        for change, *words in cases:
            with self.subTest(words=words):
                self.assert_refused(self.changed(change), *words)

    def test_uris(self):
        with open(self.path("secret.png"), "wb") as file:
            file.write(bumps(4, 4))
        for uri in ("../secret.png", "%2e%2e/secret.png", "a/../../secret.png", self.path("secret.png"),
                    "file://" + self.path("secret.png"), "http://127.0.0.1:9/x.png", "none.png", "data:,abc",
                    "data:image/png;base64,@@@@", "..%00/../secret.png", "."):
            with self.subTest(uri=uri):
                self.assert_refused(self.changed(lambda j, uri=uri: j["images"].__setitem__(0, {"uri": uri})))
                self.assert_refused(plain_model().gltf(uri), name="model/in.gltf")

    def test_images(self):
        whole = bumps(16, 16)
        for data, word in ((whole[:len(whole) // 2], "image 0"), (whole[:20], "image 0"),
                           (whole[:16] + b"\x7f\xff\xff\xff" + whole[20:], "image 0")):
            self.assert_refused(plain_model(normal=data).glb(), word)
        self.assert_refused(plain_model(surface=packed(8, 8)[:60]).glb(), "image 1")

    def test_names(self):
        with open(self.path("in.glb"), "wb") as file:
            file.write(plain_model().glb())
        for output, code, word in (("model/out.gltf", USAGE, ".glb"), ("in.glb", USAGE, "twice"),
                                   ("/proc/none/out.glb", ENVIRONMENT, "folder"), ("model", USAGE, ".glb")):
            run = self.run_gltf("in.glb", output=output)
            self.assertEqual(run.returncode, code, run.stderr)
            self.assertIn(word, run.stderr)
        self.assertEqual(self.run_gltf("none.glb").returncode, INPUT_REFUSED)
        self.assertEqual(self.run_gltf("model").returncode, INPUT_REFUSED)
        self.assertEqual(self.run_gltf("in.glb", "--report", "/proc/none/r.json").returncode, ENVIRONMENT)
        self.assertEqual(sorted(os.listdir(self.folder)), ["in.glb", "model"])
        self.assertEqual(os.listdir(self.path("model")), [])

    def test_no_encoder(self):
        with open(self.path("in.glb"), "wb") as file:
            file.write(plain_model().glb())
        command = [MULTUM, "gltf", self.path("in.glb"), "-o", self.path("out.glb")]
        run = subprocess.run([*command, "--encoder", self.folder], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, ENVIRONMENT)
        for word in ("ktx2-encoder", "npm install", "rgba8", "Node.js"):
            self.assertIn(word, run.stderr)
        without_node = {**os.environ, "PATH": self.folder}
        run = subprocess.run([*command, "--format", "uastc"], capture_output=True, text=True, check=False,
                             env=without_node)
        self.assertEqual(run.returncode, ENVIRONMENT)
        self.assertIn("Node.js", run.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), ["in.glb", "model"])
        run = subprocess.run(command, capture_output=True, text=True, check=False, env=without_node)
        self.assertEqual(run.returncode, 0, run.stderr)
        for word in ("new textures are stored as RGBA8", "Node.js", "npm install"):
            self.assertIn(word, run.stderr)

    def test_broken_at_random(self):
        seed = 7
        rng = random.Random(seed)
        model = plain_model()
        good = model.glb()
        text = json.dumps(model.json).encode()
        for number in range(BROKEN_FILES):
            data = bytearray(good)
            if number % 3 == 0:  # changes numbers; the JSON stays valid
                numbers = [i for i, c in enumerate(text) if chr(c).isdigit()]
                changed = bytearray(text)
                for _ in range(2):
                    changed[rng.choice(numbers)] = ord(rng.choice("0123456789"))
                data = glb_of(bytes(changed), model.bytes)
            elif number % 3 == 1:  # changes any byte of the frame and the JSON
                for _ in range(3):
                    data[rng.randrange(20 + len(text))] = rng.randrange(256)
            else:  # changes the images
                for _ in range(10):
                    data[rng.randrange(len(good) - len(model.bytes), len(good))] = rng.randrange(256)
            with open(self.path("model/in.glb"), "wb") as file:
                file.write(data)
            run = self.run_gltf("model/in.glb")
            self.assertIn(run.returncode, (0, INPUT_REFUSED), f"seed {seed}, file {number}: {run.stderr}")
            left = {"in.glb"} | ({"out.glb"} if run.returncode == 0 else set())
            self.assertEqual(set(os.listdir(self.path("model"))), left, f"seed {seed}, file {number}")
            if run.returncode == 0:
                os.remove(self.path("model/out.glb"))


if __name__ == "__main__":
    MULTUM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
