#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests tools/lab/playback_document.py on a small field of traced frames: its page, its rows and its refusals. Also
tests its functions: the path through the parameters, errors and their positions, values between the points of a curve,
and the colours of videos.

  tests/tools/playback_document_test.py --programs FOLDER
"""
import ctypes.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest
import xml.etree.ElementTree

import numpy as np
from traced_field import write_traced_field

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools/lab"
sys.path[:0] = [str(TOOLS), str(TOOLS / "playback"), str(TOOLS / "papers")]
import curves  # noqa: E402
import fields  # noqa: E402
import hakura2000  # noqa: E402
import parameter_grid  # noqa: E402
import playback_document  # noqa: E402
import playing  # noqa: E402
import study  # noqa: E402
import video_codecs  # noqa: E402

programs = ROOT / "build/release/bin"


class PartsTest(unittest.TestCase):
    def test_neighbours_of_the_path_differ_by_one_step(self):
        path = fields.serpentine([3, 4, 2])
        self.assertEqual((len(path), len(set(path))), (24, 24))
        for one, other in zip(path, path[1:]):
            self.assertEqual(sum(abs(a - b) for a, b in zip(one, other)), 1)
        self.assertEqual(path[:2], [(0, 0, 0), (0, 0, 1)])

    def test_diagonals_meet_every_sample_once(self):
        for counts in ([8, 8], [2, 3], [3, 2, 4], [5]):
            places = playing.diagonals(counts)
            self.assertEqual(sorted(places), sorted(fields.serpentine(counts)))
            step = [(b - a) % count for a, b, count in zip(places[0], places[1], counts)]
            self.assertEqual(step, [1 % count for count in counts])
            for number, place in enumerate(fields.serpentine(counts)):
                self.assertEqual(playing.serpentine_number(place, counts), number)

    def test_values_of_a_screen(self):
        shown = fields.eight_bit(np.array([[[-1.0, 0.0, np.nan], [1.0, 7.0, 0.5 ** 2.2]]], np.float32))
        self.assertEqual(shown.tolist(), [[[0, 0, 0], [255, 255, 128]]])

    def test_error_is_of_all_values(self):
        black = np.zeros((2, 3, 4, 3), np.uint8)
        other = black.copy()
        other[1, 2, 3, 0] = 255  # 8 bits cannot hold the square of this difference
        self.assertAlmostEqual(fields.mse(black, other), 255 ** 2 / black.size, places=3)

    def test_places_add_up(self):
        numbers = np.zeros((1, 6, 6), np.uint8)
        numbers[0, 2:, :3], numbers[0, 2:, 3:] = 1, 2
        edges = fields.silhouettes(numbers)[0]
        self.assertTrue(edges[1].all() and edges[2].all() and edges[:, 2][2:].all() and edges[:, 3][2:].all())
        self.assertFalse(edges[0].any() or edges[3:, :2].any() or edges[3:, 4:].any())
        errors = np.random.default_rng(7).random(numbers.shape).astype(np.float32)
        rows = fields.error_places(errors, numbers, ["a", "b"])
        self.assertEqual(len(rows), 6)
        self.assertAlmostEqual(sum(row["part"] for row in rows), float(errors.mean()), places=6)
        self.assertAlmostEqual(sum(row["pixels"] for row in rows), 1.0)

    def test_values_between_points(self):
        points = [(400, 20.0), (100, 5.0)]
        self.assertAlmostEqual(curves.value_at(points, 200), 10.0)
        self.assertAlmostEqual(curves.value_at(points, 400), 20.0)
        self.assertAlmostEqual(curves.value_at(points, 99), 5.0)  # close to the requested value
        self.assertIsNone(curves.value_at(points, 401))
        self.assertIsNone(curves.value_at(points, 95))

    def test_names_beside_curves_do_not_overlap(self):
        self.assertEqual(curves.apart([30, 10, 12], 10), [30, 10, 20])

    def test_colours_survive_the_conversion(self):
        colours = np.array(np.meshgrid(*[[0, 1, 77, 128, 254, 255]] * 3), np.uint8).reshape(3, 1, 6, 36)
        frames = np.moveaxis(colours, 0, -1)
        self.assertLessEqual(np.abs(video_codecs.rgb(video_codecs.ycbcr(frames).astype(float)).astype(int) -
                                    frames).max(), 1)

    @unittest.skipUnless(os.path.exists("/usr/bin/ffmpeg"), "no ffmpeg here")
    def test_videos_come_back(self):
        y, x = np.mgrid[0:48, 0:64]
        frames = np.stack([np.stack([128 + 100 * np.sin((x + 3 * t) / 9), 128 + 100 * np.cos(y / 7), 2 * x + t], -1)
                           for t in range(9)]).clip(0, 255).astype(np.uint8)
        for codec in video_codecs.CODECS:
            with self.subTest(codec=codec.name):
                sizes, errors = zip(*[(size, fields.mse(decoded, frames)) for size, decoded in
                                      (video_codecs.coded(codec, codec.qualities[at], frames) for at in (0, -2))])
                self.assertGreater(sizes[0], 1.5 * sizes[1])
                self.assertLess(errors[0], 12)  # with swapped colours, the difference would be much larger
                self.assertLess(errors[0], errors[1])

    def test_settings_of_a_job(self):
        job = "a = 1\n[texture]\nwrap = \"clamp\"  # x\npyramid_weight = 0.1  # y\n\n[[layer]]\npyramid_weight = 3\n"
        changed = playback_document.with_texture_settings(job, {"pyramid_weight": 0.5})
        self.assertEqual(changed, job.replace("0.1", "0.5"))
        with self.assertRaisesRegex(SystemExit, "no side_max"):
            playback_document.with_texture_settings(job, {"side_max": 2})

    def test_a_parameter_becomes_two_and_is_left_out_again(self):
        job = "".join(['a = 1\n[texture]\nwrap = "clamp"\n\n',
                       *[f'[[parameter]]\nname = "{name}"\ncount = {count}  # samples\n\n'
                         for name, count in (("view", 2), ("moved", 6))],
                       '[[layer]]\nname = "diffuse"\ndepends_on = ["moved"]  # x\n\n',
                       *[f'[[sample]]\nat = [{v}, {p}]\nname = "{v}_{p}"\n[sample.object_to_world]\n"a" = [[1.0]]\n\n'
                         for v in range(2) for p in range(6)]])
        split = tomllib.loads(parameter_grid.with_split_parameter(job, "moved", [("turn", 3), ("light", 2)]))
        self.assertEqual([(one["name"], one["count"]) for one in split["parameter"]],
                         [("view", 2), ("turn", 3), ("light", 2)])
        self.assertEqual(split["layer"][0]["depends_on"], ["turn", "light"])
        self.assertEqual({one["name"]: one["at"] for one in split["sample"]},
                         {f"{v}_{p}": [v, p // 2, p % 2] for v in range(2) for p in range(6)})
        whole = parameter_grid.with_split_parameter(job, "moved", [("turn", 3), ("light", 2)])
        part = tomllib.loads(parameter_grid.with_leading_parameters(whole, 2))
        self.assertEqual([one["name"] for one in part["parameter"]], ["view", "turn"])
        self.assertEqual(part["layer"][0]["depends_on"], ["turn"])
        self.assertEqual([(one["at"], one["name"]) for one in part["sample"]],
                         [([v, t], f"{v}_{2 * t + 1}") for v in range(2) for t in range(3)])
        self.assertEqual(part["sample"][0]["object_to_world"], {"a": [[1.0]]})
        with self.assertRaisesRegex(SystemExit, "has 6 samples"):
            parameter_grid.with_split_parameter(job, "moved", [("turn", 2), ("light", 2)])
        with self.assertRaisesRegex(SystemExit, "no parameter wind"):
            parameter_grid.with_split_parameter(job, "wind", [("turn", 2), ("light", 2)])


class DemosTest(unittest.TestCase):
    def test_demos_are_pages_that_play(self):
        with tempfile.TemporaryDirectory() as holder:
            folder = pathlib.Path(holder)
            write_traced_field(folder / "data/field_demo1")
            hakura2000.TARGETS = (12, 20)  # 1/384 of a field of 83 kB is not possible
            made = study.Study(hakura2000.TITLE, folder / "page", pathlib.Path(programs).resolve(), folder / "data",
                               64, 2)
            hakura2000.pages_that_play(made, [])
            self.assertEqual(made.parts, [])
            hakura2000.pages_that_play(made, [hakura2000.FieldStudy(made, "field_demo1")])
            made.write_page()
            page = (folder / "page/index.html").read_text()
            self.assertIn("Demo 1: views of the room", page)
            if "built without the decoder for browsers" in page:
                self.skipTest("multum has no decoder for browsers")
            self.assertIn('data="field_demo1_plays.html"', page)
            player = (folder / "page/field_demo1_plays.html").read_text()
            self.assertIn('id="data-field"', player)
            self.assertNotRegex(player, r'src="[^"]|https?://(?!www.w3.org)')


class DocumentTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def run_tool(self, *more, environment=None):
        return subprocess.run([sys.executable, TOOLS / "playback_document.py", self.folder / "field_small", "--bin",
                               programs, "--work", self.folder / "work", "-o", self.folder / "PLAYBACK.md",
                               "--allow-dirty", "--context", "osmesa", "--stated", "6", "12", "20", *more],
                              capture_output=True, text=True, env=environment)

    def test_page_of_a_small_field(self):
        write_traced_field(self.folder / "field_small")
        done = self.run_tool("--parts", "curves", "costs", "--ratios", "6", "20")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        page = (self.folder / "PLAYBACK.md").read_text()
        self.assertIn("Generated by `tools/lab/playback_document.py` (multum ", page)
        self.assertIn("4 samples (2 values of view x 2 values of light) of 96 x 72 pixels. "
                      "Its objects are ground, board.", page)
        for name, *_ in playback_document.PACKINGS:
            errors = re.search(rf"^\| {name} \| (\S+) \| (\S+) \| (\S+) \|$", page, re.MULTILINE)
            self.assertIsNotNone(errors, name)
            self.assertEqual(sorted(map(float, errors.groups())), list(map(float, errors.groups())))
        self.assertRegex(page, r"`multum pack --ratio 12 --threads 2` \| \d+")
        rows = json.loads((self.folder / "work/rows.json").read_text())
        packed = [row for row in rows if row["kind"] == "pack"]
        self.assertEqual(len(packed), 6)
        own = next(row for row in rows if row["kind"] == "field")["own"]
        for row in packed:
            self.assertGreaterEqual(row["ratio"], row["asked"])
            self.assertLess(row["ratio"], 1.1 * row["asked"])
            self.assertLess(0, row["mse_beside_inferred"])
            self.assertLess(row["mse"], 4 * (own + row["mse_beside_inferred"]))
        drawn = xml.etree.ElementTree.parse(self.folder / "images/playback_field_small.svg")
        self.assertEqual(len(drawn.findall(".//{*}circle")), 6)

        # No row is measured again. Rows that the binary cannot measure are left out, and a message says so.
        before = (self.folder / "work/rows.json").read_bytes()
        self.assertEqual(self.run_tool("--measure-nothing").returncode, 0)
        self.assertEqual((self.folder / "work/rows.json").read_bytes(), before)
        self.assertEqual((self.folder / "PLAYBACK.md").read_text(), page)
        rows.append({"field": "field_small", "kind": "coder", "name": "as it is", "commit": "commit 1", "options": "",
                     **{key: packed[0][key] for key in packed[0] if key not in ("field", "kind", "name", "commit")}})
        rows.append({"field": "field_small", "kind": "coder", "name": "open loop", "commit": "commit 1",
                     "options": "--open-loop", "refused": "there is no --open-loop"})
        (self.folder / "work/rows.json").write_text(json.dumps(rows))
        self.assertEqual(self.run_tool("--measure-nothing").returncode, 0)
        page = (self.folder / "PLAYBACK.md").read_text()
        self.assertIn("Left out: open loop (there is no --open-loop).", page)
        measured_at = re.search(r"bytes\. Measured at commits (.+)\.$", page, re.MULTILINE)
        self.assertIsNotNone(measured_at, page)
        # The page also names the commit of the tree, whose name may sort before "1".
        self.assertIn("1", measured_at.group(1).split(", "))

        # Only the named rows are measured again. Their results go to another file of rows.
        for row in rows:
            row["commit"] = "commit 1"
        kept = self.folder / "kept.json"
        kept.write_text(json.dumps(rows))
        done = self.run_tool("--rows", kept, "--parts", "costs", "--again", "costs")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        anew = json.loads(kept.read_text())
        self.assertEqual({row["kind"] for row in anew if row["commit"] != "commit 1"}, {"cost"})
        self.assertEqual([row for row in anew if row["kind"] != "cost"], [row for row in rows if row["kind"] != "cost"])

    @unittest.skipUnless(os.path.exists("/usr/bin/ffmpeg"), "no ffmpeg here")
    def test_what_another_parameter_costs(self):
        write_traced_field(self.folder / "field_small", lights=4)
        split = ("--split", "field_small", "light=swing:2,lamp:2")
        done = self.run_tool("--parts", "dimensions", "--growth", "8", *split)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        page = (self.folder / "PLAYBACK.md").read_text()
        self.assertIn("2 values of view x 2 values of swing x 2 values of lamp", page)
        lines = re.findall(r"^\| (view, .*?) \| (\d+) \| ([\d,]+) \| (\S+) \| (\S+) \| (\S+) \| \S+ "
                           r"\((\d+):1\) \|$", page, re.MULTILINE)
        self.assertEqual([line[:3] for line in lines], [("view, swing", "4", "82,944"),
                                                        ("view, swing, lamp", "8", "165,888")])
        for line in lines:
            own, packed, added, ratio = map(float, line[3:])
            self.assertGreater(packed, added)
            self.assertLess(packed, 3 * (own + added))
            self.assertGreaterEqual(ratio, 8)
        self.assertRegex(page, r"Compared with the field without `lamp`, packing at 8:1 adds \d")

    def test_splits_that_are_none_are_refused(self):
        done = self.run_tool("--split", "field_small", "light=swing")
        self.assertEqual(done.returncode, 2)
        self.assertIn("'light=swing' is not PARAMETER=NAME:COUNT,NAME:COUNT", done.stderr)

    def test_playing_of_a_small_field(self):
        if shutil.which("ffmpeg") is None or ctypes.util.find_library("dav1d") is None:
            self.skipTest("no ffmpeg, or no libdav1d")
        write_traced_field(self.folder / "field_small")
        done = self.run_tool("--parts", "curves", "video", "playing", "--ratios", "12", "--coders", "auto", "--videos",
                             "AV1", environment={**os.environ, "PATH": self.path_without_browsers()})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = {row["name"]: row for row in json.loads((self.folder / "work/rows.json").read_text())
                if row["kind"] == "playing"}
        self.assertEqual(len(rows["seeks"]["rounds"]), 5)
        for one in rows["seeks"]["rounds"]:
            for name in ("multum", "multum, drawn", "AV1, a key frame every 64", "AV1, a key frame every 8"):
                self.assertLess(0, one[name]["p50"])
                self.assertLessEqual(one[name]["p50"], one[name]["p99"])
        self.assertEqual(rows["diagonal, 1 x 1"]["frames"], 4)
        self.assertFalse(any(rows[f"memory, {size}"].get("mse", 0) < 0 for size in playing.MEMORIES))
        self.assertNotIn("browser", rows)
        page = (self.folder / "PLAYBACK.md").read_text()
        for said in ("#### Seeks to random samples from a cold cache", "#### Frames per second",
                     "#### Memory and quality", "`--block 4 --stagger yes`"):
            self.assertIn(said, page)
        self.assertNotIn("#### In the browser", page)

    def path_without_browsers(self):
        """Returns a folder of links to all programs except for the given ones."""
        folder = self.folder / "programs"
        folder.mkdir()
        for place in os.environ["PATH"].split(":"):
            for file in pathlib.Path(place).glob("*") if pathlib.Path(place).is_dir() else []:
                if file.name not in playing.BROWSERS and not (folder / file.name).exists():
                    (folder / file.name).symlink_to(file)
        return str(folder)

    def test_missing_ffmpeg_is_named_before_anything_is_done(self):
        done = self.run_tool(environment={"PATH": str(self.folder)})
        self.assertEqual(done.returncode, 1)
        self.assertIn("apt-get install ffmpeg", done.stderr)
        self.assertFalse((self.folder / "work").exists())


if __name__ == "__main__":
    if "--programs" in sys.argv:
        at = sys.argv.index("--programs")
        programs = pathlib.Path(sys.argv[at + 1])
        del sys.argv[at:at + 2]
    unittest.main()
