#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the Python package: arrays that are not copied, the same texels as the program, errors, cancelling, shading,
the reader that does not need the library, and the client of the service.

Environment: MULTUM, the program; MULTUM_EXAMPLES, the folder of examples; PYTHONPATH, the folder with the package.
"""
import doctest
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

import numpy as np

import multum
from multum import _api

MULTUM = os.environ["MULTUM"]


def wavy_normals(size, dtype=np.float32):
    """Returns the unit normals of a wavy surface that tiles. Integers are scaled to their range."""
    t, s = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    a = 0.4 * np.sin(2 * np.pi * (5 * s + t) / size) + 0.2 * np.cos(22 * np.pi * s / size)
    b = 0.3 * np.cos(2 * np.pi * (3 * t - s) / size)
    normals = np.stack([-a, -b, np.ones_like(a)], -1) / np.sqrt(1 + a * a + b * b)[..., None]
    if np.issubdtype(dtype, np.integer):
        return np.rint((normals + 1) / 2 * np.iinfo(dtype).max).astype(dtype)
    return normals.astype(dtype)


def program(*words):
    return subprocess.run([MULTUM, *map(str, words)], capture_output=True, text=True, check=False)


def write_test_map(folder):
    """Writes map_normal.png with 64 x 64 texels."""
    made = program("testmap", "--size", 64, "--write-green", "up", "-o", folder / "map")
    if made.returncode != 0:
        raise RuntimeError(made.stderr)


class FolderTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="multum-python-test-"))
        self.addCleanup(shutil.rmtree, self.folder)


class BakeTest(FolderTest):
    def test_documented_examples(self):
        for module in (multum, _api):
            failed, tried = doctest.testmod(module)
            self.assertEqual(failed, 0)
            self.assertGreater(tried, 0)

    def test_program_makes_the_same_texels(self):
        source = self.folder / "map_normal.png"
        write_test_map(self.folder)
        self.assertEqual(program("bake", source, "-o", self.folder / "a.ndf.exr", "--lobes", 3).returncode, 0)
        baked = multum.bake(source, self.folder / "b.ndf.exr", lobes=3)
        other = multum.load(self.folder / "a.ndf.exr")
        self.assertEqual(baked.content_hash, other.content_hash)
        self.assertEqual(baked.settings(), other.settings())
        self.assertEqual(baked.error(), other.error())
        self.assertGreater(len(baked.error()), 3)
        np.testing.assert_array_equal(baked.lobes(2), other.lobes(2))
        self.assertIn("stages", baked.report())
        self.assertEqual(other.report(), {})

    def test_every_type_of_array(self):
        for dtype in (np.uint8, np.uint16, np.float16, np.float32, np.float64):
            with self.subTest(dtype=dtype):
                baked = multum.bake(wavy_normals(32, dtype))
                self.assertEqual((baked.width, baked.height, baked.level_count), (32, 32, 6))
                mean = baked.lobes(5)[:, 0, 0].sum(axis=0)
                expected = wavy_normals(32).astype(np.float64).mean(axis=(0, 1))
                np.testing.assert_allclose(mean[:3], expected, atol=0.02)

    def test_views_of_arrays_need_no_copy_of_rows(self):
        whole = wavy_normals(32)
        flipped = np.ascontiguousarray(whole[::-1])
        self.assertEqual(multum.bake(flipped[::-1]).content_hash, multum.bake(whole).content_hash)
        wide = np.zeros((32, 40, 3), np.float32)
        wide[:, 4:36] = whole
        self.assertEqual(multum.bake(wide[:, 4:36]).content_hash, multum.bake(whole).content_hash)
        planes = np.ascontiguousarray(np.moveaxis(whole, -1, 0))  # an array with the channels first is copied
        self.assertEqual(multum.bake(np.moveaxis(planes, 0, -1)).content_hash, multum.bake(whole).content_hash)

    def test_albedo_and_roughness_from_arrays(self):
        albedo = np.zeros((16, 16, 3), np.float32)
        albedo[:, :8] = [1.0, 0.5, 0.25]
        rough = np.full((16, 16), 0.5, np.float32)
        baked = multum.bake(wavy_normals(16), albedo=albedo, roughness=rough, lobes=2)
        self.assertTrue(baked.has_colours)
        np.testing.assert_allclose(baked.colours(4)[:, 0, 0].sum(axis=0), [0.5, 0.25, 0.125], atol=2e-3)
        self.assertIn("roughness", str(baked.report()))

    def test_nothing_remains_of_a_bake_in_memory(self):
        temporary = self.folder / "tmp"
        temporary.mkdir()
        code = "import multum, sys\nsys.path.insert(0, %r)\nfrom python_test import wavy_normals\n" \
               "baked = multum.bake(wavy_normals(16)); baked.save(%r); print(baked.content_hash)" % (
                   os.path.dirname(os.path.abspath(__file__)), str(self.folder / "kept.ndf.exr"))
        run = subprocess.run([sys.executable, "-c", code], env=dict(os.environ, TMPDIR=str(temporary)),
                             capture_output=True, text=True, check=True)
        self.assertEqual(multum.load(self.folder / "kept.ndf.exr").content_hash, run.stdout.strip())
        self.assertEqual(list(temporary.iterdir()), [])
        self.assertEqual(program("verify", self.folder / "kept.ndf.exr").returncode, 0)

    def test_export_and_measure(self):
        normals = wavy_normals(32)
        report = multum.export(normals, self.folder / "material", roughness=np.full((32, 32), 0.4, np.float32))
        self.assertGreater(len(report["files"]), 3)
        for file in report["files"]:
            self.assertTrue((self.folder / "material" / os.path.basename(str(file))).exists(), file)
        report = multum.export(normals, self.folder / "rock.dds", for_="unreal", no_measure=True)
        self.assertEqual(sorted(os.path.basename(str(file)) for file in report["files"]),
                         ["T_rock_N.dds", "T_rock_ORM.dds"])
        baked = multum.bake(normals, self.folder / "a.ndf.exr")
        self.assertEqual(multum.measure(self.folder / "a.ndf.exr", normals), baked.error())

    def test_gltf(self):
        sys.path.insert(0, os.path.join(os.environ["MULTUM_EXAMPLES"], "../../../../tests/cli/gltf"))
        from model_writing import Model, bumps
        model = Model()
        model.square()
        model.material(normalTexture={"index": model.texture(model.image(bumps(64, 64)))})
        (self.folder / "a.glb").write_bytes(model.glb())
        report = multum.gltf(self.folder / "a.glb", self.folder / "b.glb", format="rgba8")
        self.assertEqual(len(report["materials"]), 1)
        self.assertEqual((self.folder / "b.glb").read_bytes()[:4], b"glTF")

    def test_warnings_are_warnings_of_python(self):
        normals = wavy_normals(32)
        normals[:, :16] = [0.0, 0.0, 1.0]  # this map does not tile
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            multum.bake(normals)
        self.assertTrue(any("green" in str(one.message) for one in caught), [str(c.message) for c in caught])
        self.assertFalse(any("--" in str(one.message) for one in caught))


class MapTest(FolderTest):
    def test_levels_are_read_only_views_without_copies(self):
        baked = multum.bake(wavy_normals(32), lobes=2)
        level = baked.lobes(1)
        self.assertEqual(level.shape, (2, 16, 16, 4))
        self.assertFalse(level.flags.owndata)
        self.assertFalse(level.flags.writeable)
        self.assertTrue(np.shares_memory(level, baked.lobes(1)))
        del baked  # the view keeps the map alive
        self.assertTrue(np.isfinite(level).all())

    def test_regions_and_stored_types(self):
        baked = multum.bake(wavy_normals(64), lobes=2)
        level = baked.lobes(1)
        np.testing.assert_array_equal(baked.read(1, (3, 5, 7, 9)), level[:, 5:14, 3:10])
        stored = baked.read(1, (3, 5, 7, 9), dtype=np.int16)
        np.testing.assert_array_equal(stored.astype(np.float32) / np.float32(32767), level[:, 5:14, 3:10])
        self.assertEqual(baked.read(1, (0, 0, 4, 4), dtype="float16").dtype, np.float16)

    def test_reader_without_the_library_agrees(self):
        try:
            from multum import reader
        except ImportError:
            self.skipTest("OpenImageIO's Python module is not installed")
        path = self.folder / "a.ndf.exr"
        baked = multum.bake(wavy_normals(32), path, lobes=3)
        for level in range(6):
            amplitude, mean, _, _ = reader.read_lobes(str(path), level)
            lobes = baked.lobes(level)
            np.testing.assert_allclose(amplitude, lobes[..., 3], atol=1e-7)
            expected = lobes[..., :3] / np.maximum(lobes[..., 3:], 1e-20)
            expected = expected / np.maximum(np.linalg.norm(expected, axis=-1, keepdims=True), 1.0)
            np.testing.assert_allclose(mean, expected, atol=1e-6)
        self.assertEqual(reader.content_hash(str(path)), baked.content_hash)

    def test_lookup_and_shading_broadcast(self):
        baked = multum.bake(wavy_normals(32), lobes=2)
        u, v = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 4))
        lobes = baked.lookup(u, v, 1.5)
        self.assertEqual(lobes.values.shape, (4, 5, 2, 4))
        self.assertEqual(lobes.kappa.shape, (4, 5, 2))
        up = np.array([0.0, 0.0, 1.0])
        lights = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
        rgb = baked.shade(0.5, 0.5, 2.0, lights, up, "ggx:0.4")
        self.assertEqual(rgb.shape, (2, 3))
        self.assertTrue((rgb > 0).all())
        light, pdf = lobes.sample(up, np.random.default_rng(1).random((4, 5, 3)), "ggx:0.4")
        self.assertEqual((light.shape, pdf.shape), ((4, 5, 3), (4, 5)))
        np.testing.assert_allclose(lobes.pdf(up, light, "ggx:0.4"), pdf, rtol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(light, axis=-1), 1.0, atol=1e-12)


class PlaneTest(FolderTest):
    """Pictures of the device against lookups and shading in double precision."""

    LIGHT = np.array([0.3, 0.2, 0.9])

    def places_and_views(self, eye, target, fov, size):
        """Returns (u, v), the directions to the camera and the footprints in tiles, (height, width, 2), per pixel."""
        width, height = size
        forward = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        down = np.cross(forward, right)
        pixel = 2 * np.tan(np.radians(fov) / 2) / height

        def hit(x, y):
            ray = (forward + (x[..., None] - width / 2) * pixel * right + (y[..., None] - height / 2) * pixel * down)
            return eye - ray * (eye[2] / ray[..., 2:]), ray

        x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        at, ray = hit(x, y)
        e = 1e-4
        along_x = (hit(x + e, y)[0] - hit(x - e, y)[0]) / (2 * e)
        along_y = (hit(x, y + e)[0] - hit(x, y - e)[0]) / (2 * e)
        return at, -ray / np.linalg.norm(ray, axis=-1, keepdims=True), along_x, along_y

    def expected(self, baked, brdf, eye, target, fov, size, taps):
        at, view, along_x, along_y = self.places_and_views(np.array(eye), np.array(target), fov, size)
        scale = np.array([baked.width, baked.height, 0])
        length_x, length_y = (np.linalg.norm(a * scale, axis=-1) for a in (along_x, along_y))
        longer, shorter = np.maximum(length_x, length_y), np.minimum(length_x, length_y)
        count = np.maximum(np.ceil(np.minimum(longer / shorter, taps) - 1e-3), 1)
        width = np.where(count == 1, longer, np.maximum(shorter, longer / count * 2 ** -0.75))
        step = np.where((length_x > length_y)[..., None], along_x, along_y) / count[..., None]
        light = self.LIGHT / np.linalg.norm(self.LIGHT)
        total = np.zeros(count.shape + (3,))
        for i in range(taps):
            place = at + (i - 0.5 * (count - 1))[..., None] * step
            shaded = baked.shade(place[..., 0], 1 - place[..., 1], np.log2(width), light, view, brdf)
            total += np.where((i < count)[..., None], shaded, 0)
        return total / count[..., None]

    def compare(self, baked, brdf, tolerance=2e-3, taps=3):
        eye, target, fov, size = (0.4, -1.0, 0.9), (0.6, 0.6, 0.0), 50.0, (48, 36)
        drawn = baked.render_plane(brdf, eye=eye, target=target, fov=fov, size=size, taps=taps, light=self.LIGHT)
        self.assertEqual(drawn.shape, (36, 48, 4))
        np.testing.assert_array_equal(drawn[..., 3], 1)
        expected = self.expected(baked, brdf, eye, target, fov, size, taps)
        self.assertGreater(float(expected.std()), 1e-4)
        error = np.abs(drawn[..., :3] - expected).sum() / expected.sum()
        self.assertLess(error, tolerance)

    def test_pictures_match_lookups(self):
        baked = multum.bake(wavy_normals(64), lobes=3)
        for brdf in ("lambert", "blinn-phong:40", "ggx:0.4", "ggx:0.6,0.5", "cook-torrance:0.2", "charlie:0.8",
                     "torrance-sparrow:0.2"):
            with self.subTest(brdf):
                self.compare(baked, brdf)

    def test_colours_roughness_and_borders(self):
        albedo = np.random.default_rng(3).random((64, 64, 3), dtype=np.float32)
        self.compare(multum.bake(wavy_normals(64), albedo=albedo, lobes=2), "ggx:0.5")
        roughness = 0.3 + 0.4 * np.random.default_rng(4).random((64, 64), dtype=np.float32)
        self.compare(multum.bake(wavy_normals(64), roughness=roughness, lobes=2), "ggx:0.5,0.3")
        self.compare(multum.bake(wavy_normals(60)[:44], wrap="clamp", lobes=2), "ggx:0.5")

    def test_sky_is_transparent_and_distant_tiles_are_even(self):
        baked = multum.bake(wavy_normals(64), lobes=2)
        drawn = baked.render_plane("lambert", eye=(0, 0, 0.1), target=(0, 10, 0.09), size=(32, 32))
        self.assertEqual(float(drawn[0, :, 3].max()), 0)
        self.assertEqual(float(drawn[-1, :, 3].min()), 1)
        horizon = drawn[drawn[..., 3] == 1][:32, :3]
        self.assertLess(float(horizon.std() / horizon.mean()), 0.02)

    def test_views_are_checked(self):
        baked = multum.bake(wavy_normals(16), lobes=1)
        for change, message in (({"eye": (0, 0, -1)}, "expected a point above the plane"),
                                ({"fov": 180}, "fov is 180"), ({"size": (0, 4)}, "the size is 0 x 4"),
                                ({"taps": 0}, "taps is 0"), ({"light": (0, 0, 0)}, "expected a unit vector"),
                                ({"target": (0.5, -0.7, 0.7)}, "the same point")):
            with self.subTest(message), self.assertRaisesRegex(multum.SettingError, message):
                baked.render_plane("ggx:0.4", **change)
        moments = multum.bake(wavy_normals(16), ndf="moments")
        with self.assertRaisesRegex(multum.SettingError, "expected lobes"):
            moments.render_plane("ggx:0.4")


class ExamplesTest(FolderTest):
    """Runs the examples of host/api/python/examples at small sizes. MULTUM_EXAMPLES names their folder."""

    def run_example(self, name, *words):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest("matplotlib is not installed")
        run = subprocess.run([sys.executable, "-W", "ignore", os.path.join(os.environ["MULTUM_EXAMPLES"], name),
                              *map(str, words)], capture_output=True, text=True, check=False,
                             env=dict(os.environ, MPLCONFIGDIR=str(self.folder / "matplotlib")))
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stdout

    def test_path_tracer_converges_and_samples_better_than_the_cosine(self):
        out = self.run_example("path_tracer.py", "-o", self.folder / "trace.png", "--size", 32, "--paths", 12)
        means = [float(v) for v in re.findall(r"mean radiance (\d+\.\d+)", out)]
        reference = float(re.search(r"reference (\d+\.\d+)", out).group(1))
        for mean in means:
            self.assertAlmostEqual(mean / reference, 1.0, delta=0.08)
        self.assertGreater(float(re.search(r"needs (\d+\.\d+) times", out).group(1)), 1.5)
        self.assertGreater((self.folder / "trace.png").stat().st_size, 1000)

    def test_folder_study(self):
        maps = self.folder / "maps"
        maps.mkdir()
        for name in ("a", "b"):
            program("testmap", "--size", 32, "--write-green", "up", "-o", maps / name)
            (maps / f"{name}_albedo.png").unlink()
        out = self.run_example("folder_study.py", maps, "-o", self.folder / "study", "--lobes", 2)
        self.assertIn("2 maps are baked", out)
        for name in ("costs.png", "lobes.png", "a_normal.ndf.exr", "b_normal.ndf.exr"):
            self.assertGreater((self.folder / "study" / name).stat().st_size, 1000, name)
        errors = [float(v) for v in re.findall(r"error (\d+\.\d+) %", out)]
        self.assertLess(errors[3], errors[0])


class ErrorTest(FolderTest):
    def test_exceptions_carry_file_found_and_expected(self):
        with self.assertRaises(multum.SettingError) as caught:
            multum.bake(wavy_normals(8), lobes=9)
        self.assertEqual(str(caught.exception), "lobes is 9, expected an integer from 1 to 8")
        self.assertEqual((caught.exception.found, caught.exception.expected), ("9", "an integer from 1 to 8"))
        self.assertIsInstance(caught.exception, ValueError)
        with self.assertRaises(multum.InputError) as caught:
            multum.bake("/nowhere/a.png")
        self.assertEqual(caught.exception.file, "/nowhere/a.png")
        with self.assertRaises(multum.SettingError):
            multum.bake(wavy_normals(8), lobse=3)
        with self.assertRaises(multum.SettingError) as caught:
            multum.bake(np.zeros((4, 4, 3, 1)))
        self.assertIn("expected (height, width)", str(caught.exception))
        with self.assertRaises(multum.SettingError):
            multum.bake(np.zeros((4, 4, 3), np.int64))
        with self.assertRaises(multum.InputError):
            multum.load(__file__)
        with self.assertRaises(multum.MachineError):
            multum.bake(wavy_normals(8), device="no such device")

    def test_progress_can_cancel_and_raise(self):
        seen = []

        def stop(stage, share):
            seen.append((stage, share))
            return len(seen) < 3

        output = self.folder / "new" / "a.ndf.exr"
        with self.assertRaises(multum.Cancelled):
            multum.bake(wavy_normals(32), output, progress=stop)
        self.assertEqual(list(self.folder.iterdir()), [])

        def fail(stage, share):
            raise ZeroDivisionError(stage)

        with self.assertRaises(ZeroDivisionError):
            multum.bake(wavy_normals(32), output, progress=fail)
        stages = []
        multum.bake(wavy_normals(32), progress=lambda stage, share: stages.append(share))
        self.assertEqual(stages[-1], 1.0)

    def test_ctrl_c_cancels(self):
        code = ("import multum, sys\nsys.path.insert(0, %r)\nfrom python_test import wavy_normals\n"
                "def tell(stage, share):\n    print(stage, flush=True)\n"
                "try:\n    multum.bake(wavy_normals(2048), progress=tell)\n"
                "except KeyboardInterrupt:\n    print('interrupted')\n" % os.path.dirname(os.path.abspath(__file__)))
        with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as child:
            child.stdout.readline()
            child.send_signal(signal.SIGINT)
            begin = time.monotonic()
            rest = child.stdout.read()
            self.assertEqual(child.wait(), 0)
        self.assertIn("interrupted", rest)
        self.assertLess(time.monotonic() - begin, 60)

    def test_other_threads_run_during_a_bake(self):
        count, done = [0], threading.Event()

        def tick():
            while not done.is_set():
                count[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=tick)
        thread.start()
        try:
            multum.bake(wavy_normals(256))
        finally:  # without it, the thread would keep a failed test running
            done.set()
            thread.join()
        self.assertGreater(count[0], 5)

    def test_types(self):
        if shutil.which("mypy") is None:
            self.skipTest("mypy is not installed")
        user = self.folder / "user.py"
        user.write_text("import multum\nimport numpy as np\n"
                        "baked: multum.BakedMap = multum.bake(np.zeros((4, 4, 3), np.float32), lobes=2)\n"
                        "level: np.ndarray = baked.lobes(1)\nerror: float = baked.error()[0].error\n"
                        "job: multum.Job = multum.Service('http://127.0.0.1:1').submit('bake', 'a', lobes=2)\n")
        package = os.path.dirname(os.path.dirname(multum.__file__))
        run = subprocess.run(["mypy", "--strict-optional", "--ignore-missing-imports", str(user),
                              "--cache-dir", str(self.folder / "cache")],
                             env=dict(os.environ, MYPYPATH=package), capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout)


class ServiceTest(FolderTest):
    def setUp(self):
        super().setUp()
        if program("serve", "--help").returncode != 0:
            self.skipTest("multum was built without the farm")
        self.data, self.root = self.folder / "data", self.folder / "root"
        self.root.mkdir()
        with open(self.folder / "log", "wb") as log:
            self.daemon = subprocess.Popen([MULTUM, "serve", "--data", str(self.data), "--root", str(self.root),
                                            "--listen", "127.0.0.1:0"], stdout=log, stderr=log)
        self.addCleanup(self._stop)
        limit = time.monotonic() + 30
        while not (self.data / "address").exists():
            self.assertIsNone(self.daemon.poll(), (self.folder / "log").read_text())
            self.assertLess(time.monotonic(), limit)
            time.sleep(0.02)
        self.service = multum.Service((self.data / "address").read_text().strip())
        self.source = self.root / "map_normal.png"
        write_test_map(self.root)

    def _stop(self):
        if self.daemon.poll() is None:
            self.daemon.terminate()
            self.daemon.wait()

    def test_jobs_from_submission_to_result(self):
        output = str(self.root / "a.ndf.exr")
        job = self.service.submit("bake", output=output, input=str(self.source), lobes=2)
        events = list(job.events(120))
        job.wait()
        self.assertEqual(job.state, "succeeded")
        self.assertGreater(len(events), 0)
        self.assertEqual(multum.load(output).lobe_count, 2)
        fetched = self.folder / "fetched.ndf.exr"
        job.fetch(fetched)
        self.assertEqual(fetched.read_bytes(), pathlib.Path(output).read_bytes())
        self.assertIn(job.id, [one.id for one in self.service.jobs()])
        self.assertIsInstance(job.log(), str)

        uploaded = self.service.upload(self.source)
        kept = self.service.submit("bake", output="kept.ndf.exr", input=uploaded, lobes=2, needs=[job])
        self.service.wait([kept], 120)
        kept.fetch(self.folder / "kept.ndf.exr")
        self.assertEqual(multum.load(self.folder / "kept.ndf.exr").content_hash, multum.load(output).content_hash)

    def test_refusals_are_exceptions(self):
        with self.assertRaises(multum.ServiceError) as caught:
            self.service.submit("bake", output=str(self.root / "b.ndf.exr"), input=str(self.source), lobes=99)
        self.assertIn("lobes", str(caught.exception))
        bad = self.root / "bad.png"
        bad.write_bytes(b"no picture")
        job = self.service.submit("bake", output=str(self.root / "c.ndf.exr"), input=str(bad))
        with self.assertRaises(multum.ServiceError) as caught:
            job.wait(120)
        self.assertIn("dead", str(caught.exception))
        begin = time.monotonic()
        with self.assertRaises(multum.ServiceError):  # a job that does not exist is not asked for again and again
            multum.Job(self.service, {"id": 999, "type": "bake", "state": "queued"}).wait(30)
        self.assertLess(time.monotonic() - begin, 20)
        self._stop()
        with self.assertRaises(multum.ServiceError) as caught:
            self.service.jobs()
        self.assertIn("cannot be reached", str(caught.exception))


if __name__ == "__main__":
    unittest.main(verbosity=2)
