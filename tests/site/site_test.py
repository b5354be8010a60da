#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the checks in tools/site and the way in which it rewrites Markdown. Uses small pages and a program that only
prints help.

  tests/site/site_test.py
"""
import contextlib
import io
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tools/documents"))
import command_lines  # noqa: E402
import markdown_pages  # noqa: E402
import page_checks  # noqa: E402
import site_build  # noqa: E402

# The theme's folder on Debian 12 and on Debian 13.
HAS_THEME = any(pathlib.Path(folder).exists() for folder in (
    "/usr/share/mkdocs/themes/material", "/usr/lib/python3/dist-packages/material/templates"))
# Prints the help of multum, multum bake, multum jobs submit, and multum openjd.
PROGRAM = """#!/bin/sh
case "$*" in
  "bake --help" | "bake "*) echo "Usage: multum bake [OPTIONS] [input...]"; echo "  -o,--output TEXT  file"
    echo "  --lobes INT"; echo "                    --not-an-option at the beginning of a line" ;;
  "jobs submit --help") echo "Usage: multum jobs submit [OPTIONS] SUBCOMMAND"; echo "  --server TEXT" ;;
  "jobs --help" | "jobs "*) echo "Usage: multum jobs [OPTIONS] SUBCOMMAND"; echo "  --json" ;;
  "openjd --help" | "openjd "*) echo "Usage: multum openjd [OPTIONS] command..."; echo "  --shards INT" ;;
  "look "*) while [ $# -gt 0 ]; do [ "$1" != -o ] || echo "<p>turning</p>" > "$2"; shift; done ;;
  *) echo "Usage: multum [OPTIONS] SUBCOMMAND"; echo "  -h,--help"; echo "  --version" ;;
esac
"""


class Pages(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.root = pathlib.Path(holder.name)
        self.write("README.md", "# Start\n")
        self.write("bin/multum", PROGRAM)
        (self.root / "bin/multum").chmod(0o755)
        self.write("tools/demo", "#!/bin/sh\n# tools/demo --size N\n")

    def write(self, name, text):
        (self.root / name).parent.mkdir(parents=True, exist_ok=True)
        (self.root / name).write_text(text)

    def faults(self, text, name="docs/how-to/page.md"):
        self.write(name, text)
        return page_checks.check_pages(self.root, self.root / "bin")[0]

    def expect(self, text, *words):
        faults = self.faults(text)
        self.assertEqual(len(faults), 1, faults)
        for word in words:
            self.assertIn(word, faults[0])


class LinksTest(Pages):
    def test_living_links(self):
        self.write("docs/reference/other.md", "# Other\n\n## The `--lobes` option, twice\n\n## A\n\n## A\n")
        self.assertEqual(self.faults(
            "# P\n\n[a](../reference/other.md) [b](../reference/other.md#the---lobes-option-twice) [c](#p)\n"
            "[d](../reference/other.md#a-1) [e](https://example.org/x) [f](../../README.md) <!-- [g](gone.md) -->\n"
            "`[h](gone.md)`\n\n```text\n[i](gone.md)\n```\n"), [])

    def test_dead_links(self):
        self.expect("# P\n\n[a\nb](gone.md)\n", "docs/how-to/page.md:4: ", "docs/how-to/gone.md", "does not exist")
        self.expect("# P\n\n![a](images/gone.png)\n", "page.md:3: ", "images/gone.png")
        self.expect("# P\n\n[a](#gone)\n", "#gone")
        self.expect("# P\n\n[a](../../README.md#gone)\n", "README.md does not have")
        self.expect("# P\n\n[a](../../../outside.md)\n", "does not exist")
        self.expect("# P\n\n[a](/docs/how-to/page.md)\n", "relative")
        self.expect("# P\n\n<img src=\"gone.png\" alt=\"x\">\n", "gone.png")

    def test_anchors_are_those_of_github(self):
        for heading, anchor in (("Numbers of it", "numbers-of-it"), ("`--lobes` [N](x.md)", "--lobes-n"),
                                ("Error, 5 % (L1)", "error-5--l1"), ("a_b *c*", "a_b-c")):
            self.assertEqual(markdown_pages.slug(heading), anchor)


class CommandsTest(Pages):
    def test_commands_that_work(self):
        self.assertEqual(self.faults(
            "# P\n\n`multum bake x.png -o y` `multum COMMAND --help` `multum jobs submit` `tools/demo --size 64`\n\n"
            "```sh\nA=1 sudo build/bin/multum bake rock.png --lobes=4 -ofile \\\n  --output x  # --no option\n"
            "for x in *; do multum --version | tee x --nothing; done\nmultum openjd --shards 8 bake a.png --lobes 4\n"
            "multum bake 'a\n--b' -- --anything\ncat << 'END' > file\nmultum surprise\nEND\n"
            "multum jobs --json --json x submit\nmultum bake x -1,2,3\n```\n\n    multum bake x.png\n"), [])

    def test_faults(self):
        for command, words in (("multum bake x.png --gone 3", "'multum bake' has no option --gone"),
                               ("multum bake x --version", "'multum bake' has no option --version"),
                               ("multum bake x -x", "has no option -x"),
                               ("multum bake x --not-an-option", "--not-an-option"),
                               ("multum surprise x.png", "'multum' has no command 'surprise'"),
                               ("multum jobs surprise", "'multum jobs' has no command 'surprise'"),
                               ("true && multum --gone", "--gone"),
                               ("multum openjd --shards 8 bake a.png --gone", "'multum bake' has no option --gone"),
                               ("tools/gone --x", "tools/gone does not exist"),
                               ("tools/demo --gone", "tools/demo has no option --gone")):
            with self.subTest(command=command):
                self.expect(f"# P\n\n```sh\ntrue\n{command}\n```\n", "page.md:5: ", words)
                self.expect(f"# P\n\nRun `{command.replace('true && ', '')}`.\n", "page.md:3: ", words)
        self.expect("# P\n\n    multum surprise x\n", "page.md:3: ", "surprise")
        self.expect("# P\n\n```sh\nmultum bake 'x\n```\n", "does not end")

    def test_pages_on_earlier_versions_may_name_their_commands(self):
        self.assertEqual(self.faults("# P\n\n`multum surprise x`\n", "docs/contributing/CHANGELOG.md"), [])

    def test_programs_that_are_missing_are_named(self):
        self.write("docs/how-to/page.md", "# P\n\n`multum-view x --gone`\n")
        self.assertEqual(page_checks.check_pages(self.root, self.root / "bin"), ([], ["multum-view"]))

    def test_commands_of_a_line(self):
        words = command_lines.words_of("A=b sudo x -a > file 2>&1 && (y | z 'a b');")
        self.assertEqual(list(command_lines.simple_commands(words))[:1], [["x", "-a", "2"]])
        self.assertEqual(list(command_lines.simple_commands(words))[1:], [["y"], ["z", "a b"]])


class BlocksTest(Pages):
    def test_blocks_that_can_be_parsed(self):
        self.assertEqual(self.faults(
            "# P\n\n```json\n{\"a\": [1]}\n```\n\n- x\n\n  ```toml\n  a = 1\n  [b]\n  ```\n\n```json\n{}\n{}\n```\n\n"
            "```python\nif True:\n    pass\n```\n\n```text\n{\n```\n\n````text\n```\n````\n"), [])

    def test_faults(self):
        self.expect("# P\n\n```json\n{\"a\": ...}\n```\n", "page.md:3: ", "json")
        self.expect("# P\n\n```toml\na = \n```\n", "toml")
        self.expect("# P\n\n```python\nif\n```\n", "python")
        self.expect("# P\n\n```\nx\n```\n", "no language")
        self.expect("# P\n\n```shell\nx\n```\n", "unknown", "```sh")
        self.expect("# P\n\n```sh\nx\n", "does not end")


class WordsTest(Pages):
    def test_words_and_limits(self):
        self.write("docs/tutorials/a.md", "word " * 12_000)
        self.write("docs/how-to/b.md", "word " * 8_000)
        self.write("docs/reference/c.md", "word " * 30_000)
        self.write("docs/reference/data.json", "word " * 9)
        words = page_checks.count_words(self.root)
        self.assertEqual(words["reference"], {"docs/reference/c.md": 30_000})
        self.assertEqual(list(page_checks.word_faults(words)), [])
        self.write("docs/explanation/d.md", "word")
        self.write("docs/reference/d.md", "word")
        faults = list(page_checks.word_faults(page_checks.count_words(self.root)))
        self.assertEqual(len(faults), 2)
        self.assertIn("20001 words, at most 20000", faults[0])
        self.assertIn("docs/reference: 30001", faults[1])


class RewritingTest(Pages):
    def rewritten(self, text):
        return site_build.for_python_markdown(text).strip()

    def test_lists(self):
        self.assertEqual(self.rewritten("So:\n- a\n  b\n  - c\n- d"), "So:\n\n-   a\n    b\n    -   c\n-   d")
        self.assertEqual(self.rewritten("1. a\n\n   ```sh\n   x\n\n     y\n   ```\n2. b"),
                         "1.  a\n\n    ```sh\n    x\n\n      y\n    ```\n\n2.  b")
        self.assertEqual(self.rewritten("- a\n\nText\n\n    code"), "-   a\n\nText\n\n    code")

    def test_tables_and_comments(self):
        table = "| a | b |\n|---|---|\n| `x\\|y` | 1 |"
        self.assertEqual(self.rewritten(f"Text\n{table}"), "Text\n\n" + table.replace("\\|", "|"))
        self.assertEqual(self.rewritten(f"<!-- x -->\n{table}\n<!-- y -->"), table.replace("\\|", "|"))
        self.assertEqual(self.rewritten("```text\n<!-- x -->\n- a\n```"), "```text\n<!-- x -->\n- a\n```")

    def test_headings(self):
        self.assertEqual(self.rewritten("# A `b`\n\n## C\n\n## C"),
                         "# A `b` { #a-b }\n\n## C { #c }\n\n## C { #c-1 }")

    def test_links(self):
        self.write("docs/how-to/page.md", "")
        self.write("LICENSE", "")
        others = set()
        readme = site_build.LinkRewriter(self.root, "README.md", others)
        self.assertEqual(readme.text("[a](docs/how-to/page.md#x) `[b](docs/how-to/page.md)` [c](LICENSE) [d](#e)"),
                         "[a](how-to/page.md#x) `[b](docs/how-to/page.md)` [c](files/LICENSE.txt) [d](#e)")
        page = site_build.LinkRewriter(self.root, "docs/how-to/page.md", others)
        self.assertEqual(page.text("[a](../../README.md) [b](../../LICENSE) [c](https://example.org) [d](gone.md)"),
                         "[a](../index.md) [b](../files/LICENSE.txt) [c](https://example.org) [d](gone.md)")
        self.assertEqual(others, {"LICENSE"})

    def test_navigation_has_every_page_once(self):
        titles = {"index.md": "multum", "how-to/upgrade.md": "Upgrade", "how-to/a.md": "Later", "how-to/b.md": "Also",
                  "evidence/GPU.md": "GPU"}
        self.assertEqual(site_build.navigation(titles), [
            {"Start": "index.md"},
            {"How to": [{"Upgrade": "how-to/upgrade.md"}, {"Also": "how-to/b.md"}, {"Later": "how-to/a.md"}]},
            {"Evidence": [{"GPU": "evidence/GPU.md"}]}])


class CommandLineTest(Pages):
    def site(self, *words):
        done = subprocess.run([ROOT / "tools/site", "--root", self.root, "--bin", self.root / "bin", "--no-install",
                               *words], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout, done.stderr

    def test_check_and_words(self):
        self.assertEqual(self.site("--check"), (0, "", ""))
        self.write("docs/how-to/page.md", "# P\n\n[a](gone.md)\n")
        code, printed, _ = self.site("--check")
        self.assertEqual((code, len(printed.splitlines())), (1, 1))
        code, printed, _ = self.site("--words")
        self.assertEqual(code, 0)
        self.assertRegex(printed, r"3  docs/how-to\n +3  page.md\n")

    def test_a_folder_without_programs_is_refused(self):
        done = subprocess.run([ROOT / "tools/site", "--check", "--bin", self.root], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("has no multum", done.stderr)

    @unittest.skipUnless(HAS_THEME, "no mkdocs-material here")
    def test_a_folder_with_other_files_is_not_overwritten(self):
        self.write("out/precious.txt", "x")
        code, _, said = self.site("-o", self.root / "out")
        self.assertEqual(code, 2)
        self.assertIn("name another folder", said)
        self.assertTrue((self.root / "out/precious.txt").is_file())
        self.write("docs/how-to/page.md", "# P\n\nWords\n")
        for _ in range(2):  # the second build replaces the first
            self.assertEqual(self.site("-o", self.root / "site")[0], 0)
        self.assertIn("Words", (self.root / "site/how-to/page.html").read_text())

    @unittest.skipUnless(HAS_THEME, "no mkdocs-material here")
    def test_the_first_page_shows_materials_if_multum_runs(self):
        self.write("README.md", "# Start\n\nWords\n\n## Next\n\nMore\n")
        self.assertEqual(self.site("-o", self.root / "site", "--no-check")[0::2], (0, ""))
        self.assertEqual((self.root / "site/live.html").read_text(), "<p>turning</p>\n")
        index = (self.root / "site/index.html").read_text()
        self.assertRegex(index, r'(?s)Words.*<iframe[^>]* src="live\.html#shape=sphere.*Next')
        self.write("bin/multum", "#!/bin/sh\necho 'multum: no OpenCL platform' >&2\nexit 4\n")
        code, _, said = self.site("-o", self.root / "site", "--no-check")
        self.assertEqual(code, 0)
        self.assertIn("no live materials: multum testmap failed: multum: no OpenCL platform", said)
        self.assertFalse((self.root / "site/live.html").exists())
        self.assertNotIn("<iframe class", (self.root / "site/index.html").read_text())

    def test_without_mkdocs_the_message_says_what_to_do(self):
        with contextlib.redirect_stderr(io.StringIO()), self.assertRaisesRegex(site_build.BuildFault, "run tools/ins"):
            original, site_build.shutil.which = site_build.shutil.which, lambda *_, **__: None
            try:
                site_build.build(self.root, self.root / "site", self.root)
            finally:
                site_build.shutil.which = original


if __name__ == "__main__":
    sys.exit(unittest.main())
