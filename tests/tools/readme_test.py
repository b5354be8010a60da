#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""README.md says what docs/evidence/readme_figures.json says, links to what there is, and tools/lab/readme_figures
--check sees
every figure that is changed by hand. Nothing is drawn."""
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

PAGES = ("README.md", readme_text.FIGURES, "docs/evidence/GPU.md", "docs/evidence/BENCHMARKS.md",
         "docs/evidence/ACCURACY.md")
NUMBER = re.compile(r"(?<![\w.#/])\d+(?:\.\d+)?(?![\w/])")


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
        for name in (*PAGES, self.image):
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, self.root / name)
        self.text = (ROOT / "README.md").read_text()

    def expect_refusal(self, *words):
        code, output = check(self.root)
        self.assertEqual(code, 1, output)
        for word in words:
            self.assertIn(word, output)

    def test_the_readme_is_what_the_figures_say(self):
        self.assertEqual(check(ROOT), (0, ""))
        self.assertEqual(check(self.root), (0, ""))

    def test_every_changed_number_inside_the_marks_is_seen(self):
        spots = [(mark.start(2) + number.start(), number.group()) for mark in readme_text.MARK.finditer(self.text)
                 for number in NUMBER.finditer(mark.group(2))]
        self.assertGreater(len(spots), 40)
        for start, number in spots:
            changed = str(int(number[0] == "1") + 1) + number[1:]
            (self.root / "README.md").write_text(self.text[:start] + changed + self.text[start + len(number):])
            with self.subTest(number=number, at=start):
                self.assertTrue(readme_text.problems(self.root))

    def test_the_command_line_names_the_line(self):
        (self.root / "README.md").write_text(self.text.replace(" %", "0 %", 1))
        self.expect_refusal("README.md:", "expected")

    def test_a_measured_figure_outside_the_marks_is_seen(self):
        for words in ("takes 2.5 ms", "is 24 % off", "43 MiB of memory", "3 times as long"):
            with self.subTest(words=words):
                (self.root / "README.md").write_text(f"{self.text}\nIt {words}.\n")
                self.expect_refusal("outside the marks")

    def test_a_lost_and_an_unknown_mark_are_seen(self):
        (self.root / "README.md").write_text(readme_text.MARK.sub("", self.text, count=1))
        self.expect_refusal("found no mark")
        (self.root / "README.md").write_text(self.text.replace("figures: made", "figures: surprise"))
        self.expect_refusal("surprise")

    def test_another_picture_is_seen(self):
        (self.root / self.image).write_bytes(b"")
        self.expect_refusal(self.image)

    def test_another_measurement_of_a_gpu_is_seen(self):
        page = self.root / "docs/evidence/GPU.md"
        four_lobes = re.compile(r"^(\| 4 lobes +\| 1 +\| [\d.]+ +\| )[\d.]+", re.MULTILINE)
        page.write_text(four_lobes.sub(r"\g<1>9.99", page.read_text()))
        self.expect_refusal("9.99")

    def test_links_lead_somewhere(self):
        links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", self.text)
        self.assertGreater(len(links), 10)
        for link in links:
            with self.subTest(link=link):
                self.assertTrue("://" in link or (ROOT / link).exists())


if __name__ == "__main__":
    sys.exit(unittest.main())
