#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs tutorials_test.py on small pages: it must accept correct pages and name the errors in incorrect pages."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent


class TutorialsTest(unittest.TestCase):
    def check(self, page):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "page.md"
            file.write_text(page, encoding="utf-8")
            run = subprocess.run([sys.executable, HERE / "tutorials_test.py", file, folder], capture_output=True,
                                 text=True, check=False, timeout=60)
        return run.returncode, run.stdout + run.stderr

    def test_output_may_differ_in_numbers_and_columns(self):
        code, output = self.check("```sh\necho 'one  12.5 | -----'\necho 'two'\necho 'three and more'\n```\n\n"
                                  "```text\none 7 | --\n...\nthree ...\n```\n")
        self.assertEqual((code, output), (0, ""))

    def test_a_line_that_is_not_printed_is_named(self):
        code, output = self.check("```sh\necho one\n```\n```text\none\nother\n```\n")
        self.assertEqual(code, 1)
        self.assertIn("the page says:\n  other", output)

    def test_a_command_that_fails_is_named(self):
        code, output = self.check("```sh\ntrue\n```\n```sh\necho before; false\n```\n")
        self.assertEqual(code, 1)
        self.assertIn("failed:\necho before; false", output)

    def test_blocks_share_one_shell_and_one_empty_folder(self):
        code, output = self.check("```sh\n[ -z \"$(ls -A)\" ]\nx=5\nmkdir deep; cd deep\n```\nwords\n"
                                  "```sh\necho \"$x in $(basename \"$PWD\")\"\n```\n```text\n5 in deep\n```\n")
        self.assertEqual((code, output), (0, ""))

    def test_output_far_from_its_command_is_not_compared(self):
        code, _ = self.check("```sh\necho one\n```\nAnother output looks so:\n```text\ntwo\n```\n")
        self.assertEqual(code, 0)

    def test_servers_end_with_the_page(self):
        code, output = self.check("```sh\nsleep 1000 &\nkill %1\nsleep 1000 &\n```\n")
        self.assertEqual((code, output), (0, ""))

    def test_a_program_that_is_missing_skips(self):
        code, output = self.check("<!-- needs: no-such-program -->\n```sh\nfalse\n```\n")
        self.assertEqual((code, output), (77, "skipped: no no-such-program\n"))

    def test_a_page_without_commands_fails(self):
        self.assertEqual(self.check("words\n")[0], 1)


if __name__ == "__main__":
    unittest.main()
