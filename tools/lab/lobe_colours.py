#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints how much one colour per lobe (Han et al. 2007, section 7.3) lowers the error of pictures, compared with lobes
that all have the texel's mean colour.

    tools/lab/lobe_colours.py BIN_FOLDER NORMAL COLOUR [NORMAL COLOUR...]

BIN_FOLDER contains multum and multum-view. NORMAL is a normal map with green up, and COLOUR is the base colour of the
same size. The map covers an oblique plane, seen from near and far under one light, with 4 evaluations per pixel. Errors
are relative L1 in %.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

READING = ("--bumpformat", "normal", "--green", "up")
VIEWS = (("near", "0,0,0.6,0,1,0.2,45"), ("far", "0,0,2.5,0,1,2.1,45"))
SCENE = ("--size", "200x150", "--light", "1,1,0.6,3", "--diffuse", "1", "--brdf", "ggx:0.5", "--evaluations", "4",
         "--reference-noise", "0.01", "--compare", "reference")


def run(*arguments):
    done = subprocess.run([str(one) for one in arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{arguments[0]} failed: {done.stderr or done.stdout}")


def error_of(view, file, source, colour, camera, folder, more=()):
    report = folder / "report.json"
    run(view, file, "--source", source, *READING, "--albedo", colour, "--camera", camera, *SCENE, *more, "-o",
        folder / "picture.png", "--report", report)
    pictures = json.loads(report.read_text(encoding="utf-8"))["pictures"]
    return 100 * next(one["relative_l1"] for one in pictures if one["name"] == "multum")


def main():
    if sys.argv[1:2] in (["-h"], ["--help"]):
        print(__doc__)
        return
    if len(sys.argv) < 4 or len(sys.argv) % 2 != 0:
        sys.exit(__doc__)
    programs = pathlib.Path(sys.argv[1])
    print("| map | view | mean colour | colour of each lobe |\n|---|---|---|---|")
    for source, colour in zip(sys.argv[2::2], sys.argv[3::2]):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            grey, coloured, mips = folder / "grey.ndf.exr", folder / "coloured.ndf.exr", folder / "colours.exr"
            run(programs / "multum", "bake", source, "-o", grey, *READING, "--no-measure")
            run(programs / "multum", "bake", source, "--albedo", colour, "-o", coloured, *READING, "--no-measure")
            run(programs / "multum", "mip", colour, "-o", mips)
            for which, camera in VIEWS:
                mean = error_of(programs / "multum-view", grey, source, colour, camera, folder, ("--colour-map", mips))
                each = error_of(programs / "multum-view", coloured, source, colour, camera, folder)
                print(f"| {pathlib.Path(source).stem} | {which} | {mean:.1f} | {each:.1f} |", flush=True)


if __name__ == "__main__":
    main()
