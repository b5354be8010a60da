# SPDX-License-Identifier: Apache-2.0
"""Runs multum for the tests of this folder, from the folder that --programs names."""
import pathlib
import subprocess
import sys
import unittest

folder = pathlib.Path(__file__).resolve().parents[3] / "build/release/bin"


def multum():
    return folder / "multum"


def run(*words):
    return subprocess.run([multum(), *map(str, words)], capture_output=True, text=True, check=False)


def main():
    """As unittest.main(), behind --programs FOLDER."""
    global folder
    if "--programs" in sys.argv:
        at = sys.argv.index("--programs")
        folder = pathlib.Path(sys.argv[at + 1]).resolve()
        del sys.argv[at:at + 2]
    unittest.main(module="__main__")
