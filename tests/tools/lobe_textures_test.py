#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that pages which copy the table of docs/evidence/LOBE_TEXTURES.md have the same table, and that a change to
either copy is found."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = ROOT / "tools/lab/lobe_textures_document.py"
DOCUMENT = "docs/evidence/LOBE_TEXTURES.md"
PAGES = ("docs/how-to/choose_lobes.md", "host/bakes/settings_search/templates/tradeoff.html")


class LobeTexturesTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.root = pathlib.Path(holder.name)
        for name in (DOCUMENT, *PAGES):
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.root / name)

    def run_tool(self, command):
        return subprocess.run([sys.executable, TOOL, command, "--root", self.root], capture_output=True, text=True,
                              check=False)

    def edit(self, name, change):
        path = self.root / name
        path.write_text(change(path.read_text()))

    def test_the_pages_are_as_they_should_be(self):
        done = self.run_tool("check")
        self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)

    def test_a_changed_figure_is_found_and_put_right(self):
        for name in PAGES:
            self.edit(name, lambda text: text.replace("BC5", "BC6", 20))
            done = self.run_tool("check")
            self.assertEqual(done.returncode, 1)
            self.assertIn(name, done.stdout)
        # A new measurement must appear in both places.
        self.edit(DOCUMENT, lambda text: text.replace("| 4 | BC5 |", "| 4 | BC5, anew |"))
        self.assertEqual(self.run_tool("share").returncode, 0)
        self.assertEqual(self.run_tool("check").returncode, 0)
        for name in PAGES:
            self.assertIn("BC5, anew", (self.root / name).read_text())

    def test_a_page_without_its_place_and_a_document_without_a_table(self):
        self.edit(PAGES[0], lambda text: text.replace("figures: lobe_textures", "figures: others"))
        self.assertIn("found 0 blocks", self.run_tool("check").stderr)
        self.edit(DOCUMENT, lambda text: text.replace("|", ""))
        self.assertIn("lines of a table", self.run_tool("check").stderr)


if __name__ == "__main__":
    unittest.main()
