#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the help texts, manual pages and shell completion of the programs. Programs that were not built are skipped.

  tests/tools/help_test.py --programs FOLDER
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
GROUPS = ["Bake", "Deliver", "Fields", "Service", "Machine"]
WORDS_MAX = 45  # the largest number of words in a help text; most texts have at most 30
programs = ROOT / "build/release/bin"


def run(*words, code=0):
    done = subprocess.run([programs / words[0], *map(str, words[1:])], capture_output=True, text=True, check=False)
    if done.returncode != code:
        raise AssertionError(f"{words}: exit code {done.returncode}: {done.stderr}")
    return done.stdout


def commands_of(*words):
    """Returns the subcommands that a help text lists under each heading."""
    found = {}
    heading = None
    for line in run(*words, "--help").splitlines():
        if match := re.match(r"(\w+):$", line):
            heading = match.group(1)
        elif heading and (match := re.match(r"  ([a-z]+)( |$)", line)):
            found.setdefault(heading, []).append(match.group(1))
    return {name: found[name] for name in found if name in GROUPS or name in ("Commands", "Subcommands")}


def all_commands(*words):
    """Returns every command line, beginning with the name of the program."""
    lines = [words]
    for names in commands_of(*words).values():
        for name in names:
            lines += all_commands(*words, name)
    return lines


class HelpTest(unittest.TestCase):
    def setUp(self):
        for name in ("multum", "multum-view"):
            if not (programs / name).is_file():
                self.skipTest(f"{name} was not built")

    def test_commands_are_grouped(self):
        groups = commands_of("multum")
        self.assertEqual(list(groups), GROUPS)
        self.assertIn("bake", groups["Bake"])
        self.assertEqual(groups["Service"], ["serve", "jobs", "openjd"])
        self.assertEqual(commands_of("multum", "jobs"),
                         {"Subcommands": ["submit", "list", "show", "cancel", "retry", "tail", "wait", "purge"]})

    def test_help_ends_with_the_exit_codes(self):
        page = ROOT / "docs/reference/exit_codes.md"
        codes = re.findall(r"^\| ?`?(\d+)`? ?\|", page.read_text(), re.MULTILINE) if page.exists() else None
        for words in (*all_commands("multum"), ("multum-view",), ("multum-bench",), ("multum-farm-simulation",)):
            if not (programs / words[0]).is_file():
                continue
            with self.subTest(words=words):
                found = re.findall(r"^  (\d+) ", run(*words, "--help").split("\nExit codes:\n")[1], re.MULTILINE)
                self.assertEqual(found, codes or found)
                self.assertIn("130", found)

    def test_help_texts_are_short(self):
        page = run("multum", "man", "--markdown") + run("multum-view", "man", "--markdown")
        for row in re.findall(r"^\|`.*\|$", page, re.MULTILINE):
            text = row.rsplit("|", 2)[1]
            self.assertLessEqual(len(text.split()), WORDS_MAX, text)

    def test_former_names_are_refused_with_the_new_ones(self):
        for verb in ("submit", "list", "show", "cancel", "retry", "tail", "wait", "purge"):
            done = subprocess.run([programs / "multum", verb, "--json"], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn(f"multum jobs {verb}", done.stderr)
        done = subprocess.run([programs / "multum", "rescue", "data"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("multum serve --data FOLDER --rescue", done.stderr)

    def test_every_command_has_a_manual_page(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name) / "new/man1"
            run("multum", "man", "-o", folder)
            pages = {path.stem for path in folder.iterdir()}
            self.assertEqual(pages, {"-".join(words[:2]) for program in ("multum", "multum-view")
                                     for words in all_commands(program)})
            self.assertIn("\\fB\\-\\-lobes\\fR", (folder / "multum-bake.1").read_text())
            self.assertIn("multum jobs list", (folder / "multum-jobs.1").read_text())
            if shutil.which("groff"):
                for path in folder.iterdir():
                    done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-z", path], capture_output=True,
                                          text=True, check=True)
                    self.assertEqual(done.stderr, "", path.name)

    def complete(self, *words):
        """Returns the completions that bash offers after these words; the last word is being typed."""
        array = " ".join(f"'{word}'" for word in words)
        script = (f"source <('{programs}/multum' completion bash); COMP_WORDS=({array}); "
                  f"COMP_CWORD={len(words) - 1}; _{words[0].replace('-', '_')}; printf '%s\\n' \"${{COMPREPLY[@]}}\"")
        done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True, cwd="/")
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_bash_completes_commands_options_and_choices(self):
        self.assertIn("bake", self.complete("multum", "b"))
        self.assertEqual(self.complete("multum", "jobs", "ca"), ["cancel"])
        self.assertEqual(self.complete("multum", "bake", "--lob"), ["--lobes"])
        self.assertEqual(self.complete("multum", "bake", "--ndf", "m"), ["moments"])
        self.assertEqual(self.complete("multum", "jobs", "list", "--state", "=", "q"), ["queued"])
        self.assertEqual(self.complete("multum-view", "anim"), ["animate"])
        self.assertEqual(self.complete("multum-view", "animate", "--to-br"), ["--to-brdf"])

    def test_scripts_of_other_shells_parse(self):
        for shell in ("zsh", "fish"):
            script = run("multum", "completion", shell)
            for words in (*all_commands("multum"), *all_commands("multum-view")):
                self.assertIn(" ".join(words), script)
            if shutil.which(shell):
                subprocess.run([shell, "-n"], input=script, text=True, check=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--programs"]:
        programs = pathlib.Path(sys.argv[2]).resolve()
        del sys.argv[1:3]
    sys.exit(unittest.main())
