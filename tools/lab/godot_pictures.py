#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Draws a metal floor in Debian's Godot 3, with the mip levels that Godot makes and with those of multum, next to an
average of 64 samples per pixel without mip levels. Prints the relative L1 errors in linear light.

  tools/lab/godot_pictures.py BIN PICTURE.jpg

BIN is the folder of the program multum. Needs the Debian packages godot3, godot3-server, xvfb, xauth and python3-pil.
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw

ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDTH, HEIGHT, SAMPLES = 480, 320, 8  # SAMPLES per side of a pixel
TITLES = {"own": "Godot's mip levels", "fitted": "multum export --for godot", "reference": "64 samples per pixel"}


def run(folder, *words):
    """Runs a program in a temporary folder, because Godot writes its logs into the current folder."""
    done = subprocess.run([str(word) for word in words], cwd=folder, capture_output=True, text=True, timeout=600,
                          check=False)
    if done.returncode != 0:
        sys.exit(f"godot_pictures: {words[0]}: exit code {done.returncode}: {(done.stdout + done.stderr)[-800:]}")


def draw(folder, kind, scale):
    """Returns the linear light of a frame, (height, width, 3)."""
    picture = folder / f"{kind}.png"
    run(folder, "xvfb-run", "-a", "-s", f"-screen 0 {WIDTH * scale + 64}x{HEIGHT * scale + 64}x24", "godot3",
        "--video-driver", "GLES2", "--audio-driver", "Dummy", "-s", ROOT / "tools/lab/engines/godot3_scene.gd", folder,
        picture, WIDTH * scale, HEIGHT * scale, kind)
    codes = np.asarray(Image.open(picture).convert("RGB")) / 255.0
    if codes.shape != (HEIGHT * scale, WIDTH * scale, 3):
        sys.exit(f"godot_pictures: {picture}: found {codes.shape}, expected {HEIGHT * scale} rows of {WIDTH * scale}")
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    return linear.reshape(HEIGHT, scale, WIDTH, scale, 3).mean(axis=(1, 3))


def main():
    if len(sys.argv) != 3 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    program = pathlib.Path(sys.argv[1]).resolve() / "multum"
    with tempfile.TemporaryDirectory(prefix="multum_godot_") as name:
        folder = pathlib.Path(name)
        run(folder, program, "testmap", folder / "rock", "--size", 256, "--write-green", "up")
        run(folder, program, "export", folder / "rock_normal.png", "-o", folder, "--green", "up", "--for", "godot",
            "--format", "png", "--base-roughness", 0.3, "--no-measure")
        run(folder, "godot3-server", "-s", ROOT / "tools/engines/godot3_levels.gd", folder)
        pictures = {"own": draw(folder, "own", 1), "fitted": draw(folder, "fitted", 1),
                    "reference": draw(folder, "none", SAMPLES)}
    reference = pictures["reference"]
    sheet = Image.new("RGB", (3 * WIDTH, HEIGHT + 24), "white")
    for i, (kind, title) in enumerate(TITLES.items()):
        light = pictures[kind]
        codes = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        sheet.paste(Image.fromarray((255 * codes + 0.5).astype(np.uint8)), (i * WIDTH, 24))
        ImageDraw.Draw(sheet).text((i * WIDTH + 8, 6), title, fill="black")
        if kind != "reference":
            error = np.abs(light - reference).sum() / reference.sum()
            print(f"{title}: relative L1 error {100 * error:.1f} %, energy {light.sum() / reference.sum():.3f}")
    sheet.save(sys.argv[2], quality=85)


if __name__ == "__main__":
    main()
