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


def scene_of(maps, budget=""):
    """Returns a scene with a painted wall for each map. A map is given by its name, the beginning of its file name, and
    more lines."""
    head = f"""[camera]
resolution = [96, 72]
{budget}
[[material]]
name = "paint"
brdf = "blinn-phong"
exponent = 100
[[light]]
direction = [0.3, 0.8, 0.5]
"""
    return head + "".join(f"""[[map]]
name = "{name}"
normal = "{file}_normal.png"
{more}
[[object]]
name = "front_of_{name}"
map = "{name}"
material = "paint"
width = 2.0
distance = [0.4, 20]
""" for name, file, more in maps)


def main():
    """Calls unittest.main() after removing --programs FOLDER from the command line."""
    global folder
    if "--programs" in sys.argv:
        at = sys.argv.index("--programs")
        folder = pathlib.Path(sys.argv[at + 1]).resolve()
        del sys.argv[at:at + 2]
    unittest.main(module="__main__")
