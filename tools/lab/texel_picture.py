#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the highlight of one texel, as docs/explanation/how_it_works.md shows it.

    tools/lab/texel_picture.py FILE.ndf.exr -o IMAGE [--level L] [--exponent S]

FILE is a bake with four lobes, and its sides are powers of two. Each panel shows all half vectors from above. The
middle of the disc is the surface's normal, and brightness is the strength of the highlight. From left to right, the
panels show the reference, which averages the highlight over all normals of the texel, then the averaged normal, then
one lobe, which has the mean vector of all normals, and then the stored lobes. docs/contributing/ALGORITHMS.md, "Shading
a filtered lobe", has the formula of the lobes. The texel has the median error of all texels of its level, so it is
neither the best nor the worst.
"""
import argparse
import sys

from debian_python import use_a_python_with

use_a_python_with("numpy", "OpenImageIO")
import numpy as np  # noqa: E402
import OpenImageIO as oiio  # noqa: E402

PANEL, MARGIN, LABEL, FONT, FONT_PIXELS = 240, 8, 26, "DejaVuSans", 18
RADIUS = 0.7  # radius of the disc that a panel shows, measured in x and y of half vectors
NAMES = ("reference", "averaged normal", "one lobe", "four lobes")


def level_of(path, part, level):
    """Returns all channels of one mip level of a part, and the names of these channels."""
    image = oiio.ImageInput.open(path)
    subimage = 0
    while image.seek_subimage(subimage, 0) and image.spec().getattribute("oiio:subimagename") != part:
        subimage += 1
    if not image.seek_subimage(subimage, level):
        sys.exit(f"texel_picture: {path}: found no level {level} of part '{part}', expected a bake of lobes")
    return image.read_image(subimage, level, 0, image.spec().nchannels, oiio.FLOAT), list(image.spec().channelnames)


def scaled(values):
    """Returns values from -1 to 1; snorm16 files store integers up to 32767."""
    return values / 32767 if np.abs(values).max() > 2 else values


def mean_cosine(kappa):
    return 1 / np.tanh(kappa) - 1 / kappa


def kappa_of(cosine):
    """Returns the inverse of mean_cosine, by bisection."""
    low, high = np.full_like(cosine, 1e-3), np.full_like(cosine, 1e6)
    for _ in range(80):
        middle = np.sqrt(low * high)
        below = mean_cosine(middle) < cosine
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return low


def power(cosines, exponent):
    return (exponent + 1) / (2 * np.pi) * np.maximum(cosines, 0) ** exponent


def lobe_highlight(vectors, half, exponent):
    """Returns the highlight of lobes (a r, a). It is a mix of a sharp cosine power and a broad von Mises-Fisher lobe,
    with weights that depend on the width."""
    shown = 0
    for *moment, amplitude in vectors:
        length = np.linalg.norm(moment)
        if amplitude <= 0 or length <= 0:
            continue
        r, cosines = min(length / amplitude, 1 - 1e-7), half @ (np.array(moment) / length)
        widened = r * (exponent + 1) / (exponent + 2)
        kappa = kappa_of(np.array(widened))
        wide = kappa / (2 * np.pi * (1 - np.exp(-2 * kappa))) * np.exp(kappa * (cosines - 1))
        sharp = power(cosines, (2 * widened - 1) / (1 - widened)) if widened > 0.5 else wide
        weight = r * r / (r * r + 1.4 * (1 - r) * (exponent + 2))
        shown = shown + amplitude * (weight * sharp + (1 - weight) * wide)
    return shown


def highlights(normals, lobes, half, exponent):
    """Returns the four panels of a texel, with one value per half vector."""
    reference = power(half @ normals.T, exponent).mean(axis=-1)
    mean = normals.mean(axis=0)
    return (reference, power(half @ (mean / np.linalg.norm(mean)), exponent),
            lobe_highlight([(*mean, 1)], half, exponent), lobe_highlight(lobes, half, exponent))


def half_vectors(side):
    """Returns the half vector of each pixel of a panel, and whether the pixel is inside the disc."""
    y, x = np.mgrid[RADIUS:-RADIUS:side * 1j, -RADIUS:RADIUS:side * 1j]
    inside = x * x + y * y <= RADIUS * RADIUS
    return np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], axis=-1), inside


def texels_of(path, level):
    """Returns the normals and the lobes of every texel of a level."""
    finest, names = level_of(path, "finest", 0)
    x, y = (scaled(finest[..., next(i for i, name in enumerate(names) if f"normal{axis}" in name)]) for axis in "XY")
    normals = np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], axis=-1)
    lobes = []
    for j in range(4):
        values, names = level_of(path, f"lobe.{j}", level - 1)  # the first level of lobes is level 1
        order = [next(i for i, name in enumerate(names) if name.endswith(end)) for end in ("R", "G", "B", "A")]
        lobes.append(scaled(values[..., order]))
    side = 2**level
    for row in range(normals.shape[0] // side):
        for column in range(normals.shape[1] // side):
            block = normals[row * side:(row + 1) * side, column * side:(column + 1) * side].reshape(-1, 3)
            yield block, [lobe[row, column] for lobe in lobes]


def median_texel(path, level, exponent):
    half, inside = half_vectors(24)
    ranked = []
    for number, (normals, lobes) in enumerate(texels_of(path, level)):
        reference, *_, four = highlights(normals, lobes, half, exponent)
        ranked.append((np.abs(four - reference)[inside].sum() / reference[inside].sum(), number))
    chosen = sorted(ranked)[len(ranked) // 2][1]
    return next(texel for number, texel in enumerate(texels_of(path, level)) if number == chosen)


def draw(texel, exponent, path):
    half, inside = half_vectors(PANEL)
    panels = highlights(*texel, half, exponent)
    brightest = panels[0].max()
    width = len(panels) * (PANEL + MARGIN) - MARGIN
    sheet = oiio.ImageBuf(oiio.ImageSpec(width, PANEL + LABEL, 3, oiio.UINT8))
    oiio.ImageBufAlgo.fill(sheet, (1.0, 1.0, 1.0))
    for number, (name, values) in enumerate(zip(NAMES, panels)):
        shade = np.clip(values / brightest, 0, 1) ** (1 / 2.2)
        pixels = np.where(inside, 0.06 + 0.94 * shade, 1.0).astype(np.float32)
        panel = oiio.ImageBuf(oiio.ImageSpec(PANEL, PANEL, 3, oiio.FLOAT))
        panel.set_pixels(oiio.ROI(0, PANEL, 0, PANEL, 0, 1, 0, 3), np.repeat(pixels[..., None], 3, axis=-1))
        left = number * (PANEL + MARGIN)
        oiio.ImageBufAlgo.paste(sheet, left, LABEL, 0, 0, panel)
        if not oiio.ImageBufAlgo.render_text(sheet, left, FONT_PIXELS, name, FONT_PIXELS, FONT, (0.0, 0.0, 0.0)):
            sys.exit(f"texel_picture: found no font {FONT}, expected fonts-dejavu-core to be installed")
    sheet.specmod().attribute("Compression", "jpeg:85")
    if not sheet.write(path):
        sys.exit(f"texel_picture: {path}: cannot write the picture: {sheet.geterror()}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", help="baked file of four lobes")
    parser.add_argument("-o", "--output", required=True, help="picture to write")
    parser.add_argument("--level", type=int, default=4, help="mip level of the texel (default: %(default)s)")
    parser.add_argument("--exponent", type=float, default=100, help="Blinn-Phong exponent (default: %(default)s)")
    given = parser.parse_args()
    draw(median_texel(given.file, given.level, given.exponent), given.exponent, given.output)


if __name__ == "__main__":
    main()
