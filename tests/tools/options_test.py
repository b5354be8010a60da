#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/reference/commands.md has every option that the help of `multum bake`, `export`, `gltf`, `look`, `pack`, of
`multum-view`
and of its subcommands prints, with its default, and no other. A program that was not built is passed over.

  tests/tools/options_test.py --programs FOLDER
"""
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/reference/commands.md"
VIEW_COMMANDS = ("scene", "animate", "sample", "play", "pyramid", "lod", "model", "probe", "thumbnails")
COMMANDS = {"multum bake": ("multum", "bake"), "multum export": ("multum", "export"),
            "multum gltf": ("multum", "gltf"), "multum look": ("multum", "look"), "multum pack": ("multum", "pack"),
            "multum-view": ("multum-view",),
            **{f"multum-view {command}": ("multum-view", command) for command in VIEW_COMMANDS}}
programs = ROOT / "build/release/bin"


def printed_options(text):
    """Of --help: {"--lobes": "4"}, with "" where no default is printed; and {"-o": "--output"}."""
    options, short = {}, {}
    for line in text.splitlines():
        found = re.match(r"  (?:(-\w),)?(--[\w-]+)(.*)$", line)
        if found is None:
            continue
        letter, name, rest = found.groups()
        words = re.split(r"\s{2,}", rest, maxsplit=1)[0]  # the type and the default; then comes the description
        default = re.search(r"=([^\s=)\]]+)$", words)
        options[name] = default.group(1) if default else ""
        if letter:
            short[letter] = name
    return options, short


def documented_options(page, command):
    """Of the tables of the section on COMMAND: {"--lobes": "1 to 8, default `4`"}, and the short names; those that
    stand twice are in the list."""
    section = re.search(rf"^## `{command}`\n(.*?)(?=^## |\Z)", page, re.MULTILINE | re.DOTALL).group(1)
    options, short, twice = {}, {}, []
    for row in re.findall(r"^\| (`-.*) \|$", section, re.MULTILINE):
        cells = row.split(" | ")
        names = re.findall(r"`(-[\w-]+)`", cells[0])
        name = next(n for n in names if n.startswith("--"))
        if name in options:
            twice.append(name)
        options[name] = " ".join(cells[1:])
        short.update({n: name for n in names if not n.startswith("--")})
    return options, short, twice


class OptionsTest(unittest.TestCase):
    def test_page_and_help_agree(self):
        for command, (program, *arguments) in COMMANDS.items():
            with self.subTest(command=command):
                if not (programs / program).is_file():
                    self.skipTest(f"{program} was not built")
                done = subprocess.run([programs / program, *arguments, "--help"], capture_output=True, text=True,
                                      check=True)
                printed, printed_short = printed_options(done.stdout)
                documented, documented_short, twice = documented_options(PAGE.read_text(), command)
                self.assertIn("--help", printed)
                self.assertEqual(twice, [])
                if command.startswith("multum-view "):
                    # Its section has what the program's own section does not have, or has otherwise.
                    self.assertEqual([name for name in documented if name not in printed], [])
                    common, common_short, _ = documented_options(PAGE.read_text(), "multum-view")
                    documented = {name: (common | documented)[name] for name in printed if name in common | documented}
                    documented_short = {short: name for short, name in (common_short | documented_short).items()
                                        if name in printed}
                self.assertEqual(sorted(documented), sorted(printed))
                self.assertEqual(documented_short, printed_short)
                for name, default in printed.items():
                    self.assertIn(f"`{default}`" if default else "", documented[name], name)

    def test_help_ends_with_the_exit_codes(self):
        section = (ROOT / "docs/reference/exit_codes.md").read_text()
        codes = re.findall(r"^\|(\d+)\|", section, re.MULTILINE)
        self.assertIn("130", codes)
        for words in (("multum",), ("multum", "openjd"), ("multum", "infer"), ("multum", "serve"), ("multum-view",),
                      ("multum-bench",), ("multum-farm-simulation",)):
            with self.subTest(words=words):
                if not (programs / words[0]).is_file():
                    self.skipTest(f"{words[0]} was not built")
                done = subprocess.run([programs / words[0], *words[1:], "--help"], capture_output=True, text=True,
                                      check=False)
                if "this build of multum has no" in done.stderr:
                    self.skipTest(done.stderr)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(re.findall(r"^  (\d+) ", done.stdout.split("\nExit codes:\n")[1], re.MULTILINE), codes)

    def test_what_is_read_of_help(self):
        options, short = printed_options("Usage: x --no-option\n"
                                         "  -d,--data-format TEXT:{snorm16,half}=snorm16\n"
                                         "                              stored with --rounding\n"
                                         "  --memory UINT:SIZE [b, kb(=1024b), ...]\n"
                                         "  --lobes INT:INT in [1 - 8]=4  lobes, a=b\n"
                                         "  -q,--quiet                  print no x=y\n")
        self.assertEqual(options, {"--data-format": "snorm16", "--memory": "", "--lobes": "4", "--quiet": ""})
        self.assertEqual(short, {"-d": "--data-format", "-q": "--quiet"})

    def test_what_is_read_of_the_page(self):
        page = "## `x`\n\n| `-o`, `--output` | file | see `--lobes` |\n| `--a` | | b |\n\n## `y`\n\n| `--c` | | d |\n"
        self.assertEqual(documented_options(page, "x"),
                         ({"--output": "file see `--lobes`", "--a": "| b"}, {"-o": "--output"}, []))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--programs"]:
        programs = pathlib.Path(sys.argv[2])
        del sys.argv[1:3]
    sys.exit(unittest.main())
