#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the fields of the Python package and with them those of libmultum: the same textures, packed bytes and frames
as the programs, errors, cancelling, and the player.

  tests/api/fields_test.py --programs FOLDER --traced-folder PROGRAM
Environment: PYTHONPATH, the folder with the package.
"""
import hashlib
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import multum


def argument(name):
    at = sys.argv.index(name)
    value = sys.argv[at + 1]
    del sys.argv[at:at + 2]
    return value


PROGRAMS, TRACED_FOLDER = pathlib.Path(argument("--programs")), argument("--traced-folder")


def run(*words):
    made = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False)
    if made.returncode != 0:
        raise RuntimeError(made.stdout + made.stderr)
    return made.stdout


def sha256(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def picture(path):
    """Returns (height, width, channels) of an EXR file."""
    import OpenImageIO as oiio
    image = oiio.ImageInput.open(str(path))
    pixels = image.read_image(0, 0, 0, image.spec().nchannels, oiio.FLOAT)
    image.close()
    return np.asarray(pixels)


class FieldTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="multum-field-test-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "renders").mkdir()
        run(TRACED_FOLDER, cls.folder / "renders", 2, 2)
        cls.job = cls.folder / "animation.toml"
        run(PROGRAMS / "multum", "animation", cls.folder / "renders", "-o", cls.job)
        cls.stages = []
        cls.report = multum.infer(cls.job, cls.folder / "inferred", context="osmesa", no_comparison=True,
                                  progress=lambda stage, share: cls.stages.append(stage))
        cls.packed = multum.pack(cls.folder / "inferred", cls.folder / "field.mpt", ratio=20)
        cls.field = multum.Field(cls.folder / "field.mpt")

    def test_inference_gives_the_textures_of_the_program(self):
        run(PROGRAMS / "multum", "infer", self.job, "-o", self.folder / "other", "--context", "osmesa", "--no-frames",
            "--no-comparison", "-q")
        textures = sorted(p.relative_to(self.folder / "inferred") for p in (self.folder / "inferred").rglob("*.exr")
                          if "textures" in p.parts)
        self.assertGreater(len(textures), 4)
        for texture in textures:
            np.testing.assert_array_equal(picture(self.folder / "inferred" / texture),
                                          picture(self.folder / "other" / texture))
        self.assertIn("draw frames", self.stages)
        self.assertTrue((self.folder / "inferred" / "report.html").exists())
        self.assertIn("objects", self.report)

    def test_packing_gives_the_bytes_of_the_program(self):
        run(PROGRAMS / "multum", "pack", self.folder / "inferred", "-o", self.folder / "same.mpt", "--ratio", 20, "-q")
        self.assertEqual(sha256(self.folder / "same.mpt"), sha256(self.folder / "field.mpt"))
        self.assertEqual(self.packed["bytes"], (self.folder / "field.mpt").stat().st_size)

    def test_description(self):
        self.assertEqual(self.field.parameters, ["view", "light"])
        self.assertEqual(self.field.sizes, [2, 2])
        self.assertEqual((self.field.width, self.field.height), (96, 72))
        self.assertEqual(len(self.field.layers), len({(l["object"], l["name"]) for l in self.field.layers}))
        self.assertIn("field.mpt", repr(self.field))

    def test_textures_are_those_of_the_unpacked_field(self):
        run(PROGRAMS / "multum", "unpack", self.folder / "field.mpt", "-o", self.folder / "unpacked", "-q")
        unpacked = [picture(p) for p in sorted((self.folder / "unpacked").rglob("*.exr"))]
        found = 0
        for layer in range(len(self.field.layers)):
            for point in ([0, 0], [0, 1], [1, 0], [0.9, 1.4]):
                texture = self.field.texture(layer, point)
                if texture is None:
                    continue
                self.assertEqual(texture.shape[2], 3)
                same = [u for u in unpacked if u.shape == texture.shape]
                difference = min(float(np.abs(u - texture).max()) for u in same)
                self.assertLess(difference, 1e-3)  # files hold 16-bit floats
                found += 1
        self.assertGreater(found, 4)

    def test_frames_are_those_of_the_viewer(self):
        run(PROGRAMS / "multum-view", "sample", self.folder / "field.mpt", "--at", "1,0", "-o",
            self.folder / "sample.exr")
        steps = []
        frames = self.field.frames([[1, 0], [0, 1], [4, 0.4]], progress=lambda stage, share: steps.append(share))
        self.assertEqual(frames.shape, (3, 72, 96, 4))
        expected = picture(self.folder / "sample.exr")
        self.assertLess(float(np.abs(frames[0] - expected).max()), 2e-3)
        self.assertGreater(float(frames[0][..., :3].std()), 0.01)
        np.testing.assert_array_equal(frames[2], frames[0])  # the nearest sample of the clamped point
        self.assertGreater(float(np.abs(frames[1] - frames[0]).max()), 0.01)
        self.assertEqual(steps[-1], 1.0)

    def test_frames_between_samples(self):
        left, middle, right = self.field.frames([[0, 0], [0, 0.5], [0, 1]], linear=True)
        # The light changes and the camera stays, so the covered pixels stay. Gamma-coded values are mixed.
        np.testing.assert_allclose(middle[..., 3], left[..., 3], atol=1e-6)
        low, high = np.minimum(left, right)[..., :3], np.maximum(left, right)[..., :3]
        self.assertTrue(bool(((middle[..., :3] > low - 0.01) & (middle[..., :3] < high + 0.01)).all()))
        self.assertFalse(np.array_equal(middle, left))
        np.testing.assert_array_equal(self.field.frame([0, 1], linear=True), right)

    def test_player(self):
        try:
            self.field.publish(self.folder / "field.html")
        except multum.MachineError as error:  # a build without the decoder for browsers
            self.assertIn("expected", str(error))
            return
        self.assertIn(b"<html", (self.folder / "field.html").read_bytes()[:2000])

    def test_errors_name_what_is_wrong(self):
        with self.assertRaises(multum.SettingError) as points:
            self.field.frames([[0]])
        self.assertIn("view, light", str(points.exception))
        with self.assertRaises(multum.SettingError) as finite:
            self.field.texture(0, [0, float("nan")])
        self.assertIn("'light' is nan, expected a finite number", str(finite.exception))
        with self.assertRaises(multum.SettingError) as layer:
            self.field.texture(99, [0, 0])
        self.assertIn("layer is 99", str(layer.exception))
        with self.assertRaises(multum.InputError):
            multum.Field(self.job)
        with self.assertRaises(multum.InputError):
            multum.pack(self.folder / "nothing", self.folder / "none.mpt")
        with self.assertRaises(multum.SettingError) as alpha:
            multum.pack(self.folder / "inferred", self.folder / "none.mpt", alpha=0.5)
        self.assertIn("alpha is 0.5, expected a number above 1, or 0", str(alpha.exception))
        self.assertNotIn("--alpha", str(alpha.exception))
        self.assertFalse((self.folder / "none.mpt").exists())

    def test_damaged_parts_are_bad_input(self):
        content = bytearray((self.folder / "field.mpt").read_bytes())
        for at in range(len(content) * 3 // 4, len(content) * 3 // 4 + 16):
            content[at] ^= 0x5a
        damaged = self.folder / "damaged.mpt"
        damaged.write_bytes(content)
        field = multum.Field(damaged)
        with self.assertRaises(multum.InputError) as played:
            field.frames([[0, 0], [0, 1], [1, 0], [1, 1]])
        self.assertIn("is damaged: its checksum differs", str(played.exception))
        self.assertEqual(played.exception.file, str(damaged))

    def test_cancelling_leaves_no_file(self):
        with self.assertRaises(multum.Cancelled):
            multum.pack(self.folder / "inferred", self.folder / "stopped.mpt", progress=lambda stage, share: False)
        self.assertEqual([p.name for p in self.folder.glob("*stopped*")], [])
        with self.assertRaises(multum.Cancelled):
            self.field.frames([[0, 0]] * 3, progress=lambda stage, share: False)


if __name__ == "__main__":
    unittest.main()
