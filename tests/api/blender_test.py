# SPDX-License-Identifier: Apache-2.0
"""Draws a plane in Blender with the add-on blender_lobes, with averaged normals and with the normal map, and compares
the pictures with many samples per pixel and with multum-view. Usage: blender_test.py PROGRAMS SOURCES BUILD. Skipped
(exit code 77) without Blender 3.4. With MULTUM_PICTURES=FOLDER, the pictures stay in this folder."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import OpenImageIO as oiio

PROGRAMS, SOURCES, BUILD = (pathlib.Path(argument) for argument in sys.argv[1:4])
SCENE = SOURCES / "tests/api/blender_scene.py"
FAR = [0, 0, 6, 0, 9, 0, 35]  # eye, target, field of view; about 50 texels per pixel
ALL = [0, -1, 2.6, 0, 5, 0, 40]  # about 9 texels per pixel at the lower border, and 350 at the upper border
NEAR = [0, 1, 0.12, 0, 1.2, 0, 35]  # less than a texel per pixel
PAGE = (SOURCES / "docs/how-to/blender.md").read_text()
WIDTHS = 8, 16  # of reduced normal maps; a texel covers 32 or 16 texels of the map
LIGHT = [0.1, 0.55, 0.8]


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    return done.stdout


class BlenderTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(os.environ.get("MULTUM_PICTURES", cls.temporary.name)).resolve()
        cls.map, cls.baked = cls.folder / "armour_normal.png", cls.folder / "armour.ndf.exr"
        run(PROGRAMS / "multum", "testmap", cls.folder / "armour", "--size", 256, "--quarter", "armour",
            "--write-green", "up")
        cls.textures = cls.folder / "textures"
        run(PROGRAMS / "multum", "export", cls.map, "-o", cls.textures, "--for", "blender", "--green", "up",
            "--base-roughness", 0.3, "--no-measure")
        run(PROGRAMS / "multum", "bake", cls.map, "-o", cls.baked, "--lobes", 4, "--green", "up", "--force")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def blender(self, **job):
        settings = {"package": str(BUILD / "python"), "folder": str(self.folder), "normals": str(self.map), "size": 48,
                    "light": LIGHT, "irradiance": 3, "f0": 0.9, "roughness": 0.3}
        (self.folder / "job.json").write_text(json.dumps({**settings, **job}))
        scripts = self.folder / "scripts"
        (scripts / "addons").mkdir(parents=True, exist_ok=True)
        environment = dict(os.environ, BLENDER_USER_SCRIPTS=str(scripts), BLENDER_USER_CONFIG=str(scripts))
        output = run("blender", "-b", "-noaudio", "--factory-startup", "--python-exit-code", 3, "--python", SCENE,
                     "--", self.folder / "job.json", env=environment)
        return "\n".join(line for line in output.splitlines() if not line.startswith(("Fra:", "Saved:", " Time:")))

    def picture(self, name):
        file = oiio.ImageInput.open(str(self.folder / f"{name}.exr"))
        return np.asarray(file.read_image(0, 0, 0, 3, oiio.FLOAT))

    def error(self, name, reference):
        """Returns the relative L1 error, and the mean divided by the mean of the reference."""
        picture, wanted = self.picture(name), self.picture(reference)
        error, energy = float(np.abs(picture - wanted).mean() / wanted.mean()), float(picture.mean() / wanted.mean())
        print(f"{name}: relative L1 error {error:.3f} against {reference}, energy {energy:.3f}")
        return error, energy

    def errors(self, row, camera, size, samples):
        """Draws one view, and compares the errors with a row of the table in docs/how-to/blender.md."""
        lobes = {"lobes": str(self.baked), "camera": camera, "samples": 16}
        print(self.blender(size=size, pictures=[
            {"name": "reference", "camera": camera, "samples": samples},
            {"name": "map", "camera": camera, "samples": 16},
            *({"name": f"averages_{width}", "width": width, "camera": camera, "samples": 16} for width in WIDTHS),
            {"name": "lobes", **lobes},
            {"name": "textures", "textures": str(self.textures), "camera": camera, "samples": 16},
            {"name": "saved", **lobes, "blend": str(self.folder / "lobes.blend")}]))
        self.assertLess(self.error("saved", "lobes")[0], 1e-6)
        names = ("lobes", "textures", "map", *(f"averages_{width}" for width in WIDTHS))
        lobes, textures, normals, *averages = (self.error(name, "reference")[0] for name in names)
        numbers = re.search(rf"^\| {row}[^|]*" + r"\| (\d+) % " * 4 + r"\|$", PAGE, re.MULTILINE).groups()
        for measured, number in zip((lobes, textures, normals, min(averages)), map(int, numbers)):
            self.assertAlmostEqual(100 * measured, number, delta=0.05 * number + 0.5)
        return lobes, textures, normals, min(averages)

    def test_far(self):
        lobes, textures, normals, averages = self.errors("far", FAR, 48, 2048)
        self.assertLess(textures, 0.6 * averages)  # measured: 0.72 and 1.34
        # Measured: 0.126, 0.37 and 1.34. If lobes do not widen GGX, the error of lobes is above 0.18.
        self.assertLess(lobes, 0.15)
        self.assertLess(lobes, 0.5 * normals)
        self.assertLess(lobes, 0.2 * averages)
        camera, light = ",".join(map(str, FAR)), ",".join(map(str, LIGHT)) + ",3"
        run(PROGRAMS / "multum-view", self.baked, "-o", self.folder / "view.exr", "--camera", camera, "--light", light,
            "--brdf", "ggx:0.3,0.9", "--diffuse", 0, "--specular", 1, "--size", "48x48")
        self.assertLess(self.error("view", "reference")[0], 0.1)  # measured: 0.061
        self.assertLess(self.error("lobes", "view")[0], 0.18)  # measured: 0.149

    def test_all_distances(self):
        lobes, _, normals, averages = self.errors("near to far", ALL, 96, 1024)
        self.assertLess(lobes, 0.7 * normals)
        self.assertLess(lobes, 0.5 * averages)
        excess = int(re.search(r"\(by (\d+) % in the view\s+from near to far\)", PAGE).group(1))
        self.assertAlmostEqual(100 * (self.error("lobes", "reference")[1] - 1), excess, delta=2)

    def test_near(self):
        self.blender(pictures=[{"name": "near_reference", "camera": NEAR, "samples": 256},
                               {"name": "near_lobes", "camera": NEAR, "samples": 16, "lobes": str(self.baked)}])
        # Measured: 0.085, because level 0 is filtered linearly. With rows upside down, 1.3; with y reversed, 0.66.
        self.assertLess(self.error("near_lobes", "near_reference")[0], 0.2)

    def test_operators(self):
        moments, broken = self.folder / "moments.ndf.exr", self.folder / "broken.ndf.exr"
        run(PROGRAMS / "multum", "bake", self.map, "-o", moments, "--ndf", "moments", "--green", "up", "--force")
        broken.write_bytes(b"no picture")
        output = self.blender(camera=FAR, engines=["unreal", "three"], program=str(PROGRAMS / "multum"),
                              lobes=str(self.baked), textures=str(self.textures / "normal_00.png"),
                              refused=[str(moments), str(broken)])
        for engine, textures in (("unreal", ("T_unreal_N.dds", "T_unreal_ORM.dds")),
                                 ("three", ("three_normal.ktx2", "three_orm.ktx2"))):
            self.assertIn(f"{engine} {{'FINISHED'}}", output)
            for texture in textures:
                self.assertGreater((self.folder / texture).stat().st_size, 1000)
        self.assertIn("textures {'FINISHED'}", output)
        self.assertIn("'normal_08.png'", output)
        self.assertIn("'roughness_08.png'", output)
        self.assertIn("found moments, expected lobes", output)
        self.assertIn(f"cannot read {broken}", output)
        self.assertIn("expected a mesh with a UV map, and a camera in the scene", output)
        # Four images per level, and the normal map. Images of the first import are gone.
        self.assertEqual(re.findall(r"^levels (.*) images", output, re.MULTILINE),
                         ["[2, 3, 4, 5, 6, 7, 8] of 29", "[0, 1, 2, 3, 4, 5, 6, 7, 8] of 37"])

    def test_engines_are_those_of_multum(self):
        """Compares the add-on's engines with those of multum, without Blender's modules."""
        text = (SOURCES / "host/api/python/multum/blender_lobes.py").read_text()
        table = text[text.index("ENGINES = {"):text.index("def normal_map_file")]
        rows = json.loads(run(PROGRAMS / "multum", "parameters", "export", "--json"))["commands"]["export"]
        engines = next(row for row in rows if row["name"] == "for")["choices"]
        self.assertEqual(sorted(re.findall(r'"([\w-]+)": "', table)), sorted(engines))


if __name__ == "__main__":
    if shutil.which("blender") is None:
        print("skipped: blender is not installed: tools/install_dependencies blender")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
