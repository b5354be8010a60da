#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares README.md and the pages of docs/ with the figures that they quote, and checks that tools/lab/readme_figures
--check finds every figure that is changed by hand. Draws no picture."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/lab"))
sys.dont_write_bytecode = True
import readme_text  # noqa: E402

NUMBER = re.compile(r"(?<![\w.#/])\d+(?:\.\d+)?(?![\w/])")
PROSE = "docs/explanation/accuracy.md"


def check(root):
    done = subprocess.run([sys.executable, ROOT / "tools/lab/readme_figures", "--check", "--root", root],
                          capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


class ReadmeTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.root = pathlib.Path(holder.name)
        self.image = readme_text.read_figures(ROOT)["picture"]["image"]
        pages = [str(page.relative_to(ROOT)) for page in (ROOT / "docs").rglob("*.md")]
        for name in ("README.md", readme_text.FIGURES, self.image, *pages):
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, self.root / name)
        self.text = (ROOT / "README.md").read_text()

    def expect_refusal(self, *words):
        code, output = check(self.root)
        self.assertEqual(code, 1, output)
        for word in words:
            self.assertIn(word, output)

    def test_all_pages_quote_the_figures(self):
        self.assertEqual(check(ROOT), (0, ""))
        self.assertEqual(check(self.root), (0, ""))

    def test_every_changed_number_inside_the_marks_is_seen(self):
        blocks = {"figures": readme_text.read_figures(ROOT)}
        spots = [(page, text, mark.start(2) + number.start(), number.group())
                 for page, text in readme_text.marked_pages(ROOT) for mark in readme_text.MARK.finditer(text)
                 if mark.group(1) not in readme_text.FOREIGN for number in NUMBER.finditer(mark.group(2))]
        self.assertGreater(len(spots), 100)
        for page, text, start, number in spots:
            changed = text[:start] + str(int(number[0] == "1") + 1) + number[1:] + text[start + len(number):]
            with self.subTest(page=page, number=number, at=start):
                self.assertNotEqual(changed, readme_text.filled(ROOT, page, changed, blocks)[0])

    def test_the_command_line_names_page_and_line(self):
        for page in ("README.md", PROSE):
            with self.subTest(page=page):
                text = (ROOT / page).read_text()
                (self.root / page).write_text(text.replace("-->\n| ", "-->\n| very ", 1))
                self.expect_refusal(f"{page}:", "expected")
                (self.root / page).write_text(text)

    def test_a_measured_figure_outside_the_marks_is_seen(self):
        for page, words in (("README.md", "takes 2.5 ms"), ("README.md", "has 24 % error"), (PROSE, "43 MiB of memory"),
                            (PROSE, "3 times as long")):
            with self.subTest(page=page, words=words):
                text = (ROOT / page).read_text()
                (self.root / page).write_text(f"{text}\nIt {words}.\n")
                self.expect_refusal(f"{page}: ", "outside the marks")
                (self.root / page).write_text(text)

    def test_a_lost_and_an_unknown_mark_are_seen(self):
        for page, text in readme_text.marked_pages(ROOT):
            (self.root / page).write_text(re.sub(r"<!-- figures: costs -->.*?<!-- /figures: costs -->", "", text,
                                                 flags=re.DOTALL))
        self.expect_refusal("no page has the mark 'costs'")
        (self.root / "README.md").write_text(self.text.replace("figures: costs", "figures: surprise"))
        self.expect_refusal("surprise")

    def test_fill_restores_every_page(self):
        for page, text in readme_text.marked_pages(ROOT):
            emptied = readme_text.MARK.sub(
                lambda mark: mark.group() if mark.group(1) in readme_text.FOREIGN else
                f"<!-- figures: {mark.group(1)} --><!-- /figures: {mark.group(1)} -->", text)
            (self.root / page).write_text(emptied)
        readme_text.fill(self.root)
        for page, text in readme_text.marked_pages(ROOT):
            self.assertEqual((self.root / page).read_text(), text, page)

    def test_another_picture_is_seen(self):
        (self.root / self.image).write_bytes(b"")
        self.expect_refusal(self.image)

    def test_another_measurement_is_seen(self):
        for page, row in (("GPU.md", r"^(\| 4 lobes +\| 1 +\| [\d.]+ +\| )[\d.]+"),
                          ("EXPORT.md", r"^(\| \*\*`?multum export`?\*\* \| )\d+"),
                          ("GLTF_MODELS.md", r"^(\| lobes, 4 \| )[\d.]+"),
                          ("LOBE_TEXTURES.md", r"^(\| 4 \| BC5 \| )[\d.]+")):
            with self.subTest(page=page):
                copy = self.root / "docs/evidence" / page
                text = copy.read_text()
                changed = re.sub(row, r"\g<1>9.99", text, count=1, flags=re.MULTILINE)
                self.assertNotEqual(changed, text)
                copy.write_text(changed)
                self.expect_refusal("README.md:", "expected")
                copy.write_text(text)

    def test_links_lead_somewhere(self):
        explanation = sorted((ROOT / "docs/explanation").glob("*.md"))
        for page in ("README.md", *(str(path.relative_to(ROOT)) for path in explanation)):
            links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", (ROOT / page).read_text())
            self.assertTrue(links)
            for link in links:
                with self.subTest(page=page, link=link):
                    self.assertTrue("://" in link or (ROOT / os.path.dirname(page) / link).exists())


if __name__ == "__main__":
    sys.exit(unittest.main())
