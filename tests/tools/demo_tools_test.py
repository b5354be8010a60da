#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the scripts that a newcomer starts: syntax, help, refusals, the packages that they name, and the demo's
page."""
import html.parser
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools"
SHELL_SCRIPTS = [TOOLS / "demo", TOOLS / "test", TOOLS / "install_dependencies", TOOLS / "packaging/try_packages",
                 ROOT / ".ci/run"]
# Maps each find_package of the CMake files to the package that provides it, or to None if it comes with the compiler or
# CMake.
PACKAGE_OF = {"glm": "libglm-dev", "fmt": "libfmt-dev", "OpenSSL": "libssl-dev",
              "OpenEXR": "libopenexr-dev", "ZLIB": "zlib1g-dev", "PNG": "libpng-dev", "JPEG": "libjpeg-dev",
              "OpenImageIO": "libopenimageio-dev",
              "OpenCL": "ocl-icd-opencl-dev", "tomlplusplus": "libtomlplusplus-dev",
              "nlohmann_json": "nlohmann-json3-dev", "CLI11": "libcli11-dev", "assimp": "libassimp-dev",
              "Python3": "python3", "GTest": "libgtest-dev", "Eigen3": "libeigen3-dev",
              "OpenGL": "libgl-dev", "SQLite3": "libsqlite3-dev", "Boost": "libboost1.81-dev",
              "rapidcheck": "librapidcheck-dev", "pybind11": "pybind11-dev", "Threads": None, "OpenMP": None}
VOID = {"meta", "img", "input", "line", "circle", "rect", "polyline", "i", "br"}


def run(*command, **more):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False, **more)


def packages(system="debian-12"):
    return run(TOOLS / "install_dependencies", "--list", "--system", system).stdout.split()


class ScriptsTest(unittest.TestCase):
    def test_shell_syntax(self):
        for script in SHELL_SCRIPTS:
            with self.subTest(script=script.name):
                self.assertEqual(run("bash", "-n", script).stderr, "")

    @unittest.skipUnless(shutil.which("shellcheck"), "no shellcheck here")
    def test_shellcheck(self):
        self.assertEqual(run("shellcheck", *SHELL_SCRIPTS).stdout, "")

    def test_help(self):
        for name in ("demo", "test", "lab/demo_page.py", "torus_mesh.py", "sphere_mesh.py", "terrain_height.py",
                     "lab/reproduce",
                     "site", "install_dependencies", "format", "fuzz", "wasm_decoder", "debian_mirror",
                     "parameter_documents", "packaging/try_packages", "cross/test_readers", "cross/windows_libraries",
                     "lab/lobe_colours.py", "lab/gallery_document.py", "lab/own_mips_document.py",
                     "lab/demo_sky.py"):
            with self.subTest(script=name):
                done = run(TOOLS / name, "--help")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertIn(f"tools/{name}", done.stdout)

    def test_refusals_name_what_was_found(self):
        for command in (("demo", "--size", "63"), ("demo", "--size", "9000"), ("demo", "--size", "x"),
                        ("demo", "--surprise"), ("demo", "--bin", "/usr/bin", "--build"),
                        ("lab/reproduce", "knuth1973"), ("lab/reproduce", "--size", "63"),
                        ("test", "--preset"), ("install_dependencies", "surprise"),
                        ("install_dependencies", "--system", "debian-11"),
                        ("fresh_machine", "--suite", "bullseye")):
            with self.subTest(command=command):
                done = run(TOOLS / command[0], *command[1:])
                self.assertNotEqual(done.returncode, 0)
                self.assertIn("expected", done.stderr)

    def test_meshes_are_whole_and_face_outwards(self):
        for name in ("torus", "sphere"):
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "mesh.obj"
                self.assertEqual(run(TOOLS / f"{name}_mesh.py", path).returncode, 0)
                lines = [line.split() for line in path.read_text().splitlines()]
                numbers = {kind: [[float(one) for one in words[1:]] for words in lines if words[0] == kind]
                           for kind in ("v", "vn")}
                faces = [[int(c.split("/")[0]) for c in words[1:]] for words in lines if words[0] == "f"]
                self.assertEqual((min(map(min, faces)), max(map(max, faces))), (1, len(numbers["v"])))
                for face in faces:
                    a, b, _, d = ([*numbers["v"][i - 1]] for i in face)
                    (x, y, z), (u, v, w) = ([q - p for p, q in zip(a, one)] for one in (b, d))
                    out = (y * w - z * v, z * u - x * w, x * v - y * u)
                    self.assertGreater(sum(p * q for p, q in zip(out, numbers["vn"][face[0] - 1])), 0)

    def test_the_sky_has_a_sun(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "sky.hdr"
            self.assertEqual(run(TOOLS / "lab/demo_sky.py", path).returncode, 0)
            head, size, texels = path.read_bytes().partition(b"-Y 128 +X 256\n")
        self.assertTrue(head.startswith(b"#?RADIANCE\n"))
        self.assertEqual(len(texels), 4 * 128 * 256)
        brightest = max(range(0, len(texels), 4), key=lambda at: texels[at + 3]) // 4
        row, column = divmod(brightest, 256)
        self.assertTrue(30 < row < 50 and 224 < column < 248, f"the sun is at row {row}, column {column}")


class DependenciesTest(unittest.TestCase):
    def test_every_find_package_is_installed(self):
        listed = packages()
        files = [f for f in ROOT.rglob("CMakeLists.txt") if f.relative_to(ROOT).parts[0] not in ("build", "out")]
        found = {name for f in files for name in re.findall(r"^\s*find_package\((\w+)", f.read_text(), re.MULTILINE)}
        self.assertIn("OpenEXR", found)
        for name in sorted(found):
            with self.subTest(find_package=name):
                self.assertIn(name, PACKAGE_OF)
                if PACKAGE_OF[name]:
                    self.assertIn(PACKAGE_OF[name], listed)

    def test_document_names_the_same_packages(self):
        text = (ROOT / "docs/contributing/DEPENDENCIES.md").read_text()
        rows = re.findall(r"^\| `([^`]+)` \| [a-z]", text, re.MULTILINE)
        self.assertEqual(sorted(rows), sorted(packages()))

    def test_document_names_the_packages_of_other_systems(self):
        text = (ROOT / "docs/contributing/DEPENDENCIES.md").read_text()
        head, rows = re.search(r"^\| Debian 12 (\|.*)\n\|[-|]+\n((?:\|.*\n)+)", text, re.MULTILINE).groups()
        systems = ["debian-13", "ubuntu-24.04"]
        self.assertEqual(head.replace("*", "").strip("| "), "Debian 13 | Ubuntu 24.04, not run")
        cells = [[cell.strip(" `") for cell in row.strip("|").split("|")] for row in rows.splitlines()]
        for column, system in enumerate(systems, 1):
            with self.subTest(system=system):
                renamed = {row[0]: row[column] for row in cells}
                expected = [renamed.get(name, name) for name in packages()]
                self.assertEqual(sorted(name for name in expected if name != "none"), sorted(packages(system)))


class BalancedParser(html.parser.HTMLParser):
    """Collects wrongly nested tags, references, and pictures without alternative text."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong, self.references = [], [], []

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.references += [given[k] for k in ("src", "href") if k in given]
        self.references += [given["value"]] if tag == "option" else []
        if tag == "img" and not given.get("alt"):
            self.wrong.append("img without alt")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag in VOID:
            return
        if not self.open or self.open.pop() != tag:
            self.wrong.append(f"</{tag}>")


class PageTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        (self.folder / "steps.tsv").write_text(
            "bake\twhite\t1500\tmultum bake a<b.png\nview\tplain\t2500\tmultum-view white.ndf.exr\n"
            "material\thammered-far\t2500\tmultum-view hammered.ndf.exr\n")
        errors = [{"level": level, "point": point, "brdf": "lambert", "relative_l1": 0.01 * (level + 1),
                   "confidence_95": 0.0, "samples": 0 if level == 1 and point != "centre" else 8}
                  for level in (0, 1) for point in ("centre", "midway-x", "midway-y", "between-levels")]
        levels = [{"level": l, "width": 2 >> l, "height": 2 >> l, "seconds": 0.25, "launches": 1} for l in (0, 1)]
        self.bake = {"source": "a.png", "device": "d<e>v", "input": {"encoding": "height & <field>"},
                     "stages": [{"name": "fit", "seconds": 0.5}], "levels": levels, "measured_error": errors,
                     "counts": {"lobes": 20, "nonfinite": 0, "kappa_clamped": 1, "dead_lobes": 2}}
        self.view = {"context": "osmesa", "software": "multum-view 0", "pictures": [
            {"name": "reference", "frame_time_ms": 3.0, "samples": 9},
            {"name": "multum", "frame_time_ms": 2.0, "relative_l1": 0.125, "rmse": 0.01},
            {"name": "mip", "frame_time_ms": 1.0, "relative_l1": 0.5, "rmse": 0.02}]}
        for name in ("reference", "multum", "mip", "multum_difference", "mip_difference"):
            (self.folder / f"plain_{name}.png").write_bytes(b"")
            (self.folder / f"hammered-far_{name}.png").write_bytes(b"")
        self.write()

    def write(self):
        (self.folder / "white.bake.json").write_text(json.dumps(self.bake))
        (self.folder / "plain.view.json").write_text(json.dumps(self.view))
        (self.folder / "hammered-far.view.json").write_text(json.dumps({**self.view, "width": 4, "height": 3}))

    def page(self):
        done = run(TOOLS / "lab/demo_page.py", self.folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return (self.folder / "index.html").read_text()

    def test_numbers_are_there_and_text_is_escaped(self):
        page = self.page()
        for expected in ("12.5 %", "50.0 %", "0: 2 x 2", "1: 1 x 1", "d&lt;e&gt;v", "height &amp; &lt;field&gt;"):
            self.assertIn(expected, page)

    def test_page_is_well_formed_and_stands_alone(self):
        parser = BalancedParser()
        parser.feed(self.page())
        self.assertEqual((parser.wrong, parser.open), ([], []))
        self.assertGreater(len(parser.references), 10)
        for reference in parser.references:
            self.assertTrue((self.folder / reference).is_file(), reference)

    def test_materials_come_first_with_the_best_error_in_bold(self):
        page = self.page()
        self.assertIn("Hammered metal, far away. Error: <b>multum 12.5 %</b>, averages 50.0 %", page)
        self.assertLess(page.index("Hammered metal"), page.index("Test maps"))

    def test_the_page_of_the_materials_is_linked_where_it_is(self):
        self.assertNotIn("look.html", self.page())
        (self.folder / "look.html").write_text("")
        self.assertIn('<a href="look.html">', self.page())

    def test_no_error_measured_and_no_view(self):
        self.bake["measured_error"] = []
        self.write()
        (self.folder / "steps.tsv").write_text("bake\twhite\t1500\tmultum bake a.png\n")
        self.assertIn("1: 1 x 1", self.page())

    def test_what_is_missing_is_named_and_no_page_is_left(self):
        (self.folder / "plain.view.json").unlink()
        done = run(TOOLS / "lab/demo_page.py", self.folder)
        self.assertEqual(done.returncode, 1)
        self.assertIn("plain.view.json", done.stderr)
        self.assertEqual(list(self.folder.glob("index*")), [])


if __name__ == "__main__":
    sys.exit(unittest.main())
