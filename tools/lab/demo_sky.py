#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the environment of the demo's pictures, a bright day with a large sun, as a latitude-longitude picture in
Radiance's format. Uses only the standard library.

  tools/lab/demo_sky.py OUT.hdr
"""
import argparse
import math
import pathlib
import random

WIDTH, HEIGHT = 256, 128
SEED = 5
SUN, SUN_COSINE, SUN_RADIANCE = (0.394, 0.473, 0.788), math.cos(math.radians(4)), (170, 160, 145)


def mixed(a, b, t):
    return [x + t * (y - x) for x, y in zip(a, b)]


def smooth_step(low, high, x):
    t = min(1.0, max(0.0, (x - low) / (high - low)))
    return t * t * (3 - 2 * t)


class Noise:
    """Smooth noise of two numbers, in 0..1."""

    def __init__(self, seed):
        draw = random.Random(seed)
        self.table = [[draw.random() for _ in range(64)] for _ in range(64)]

    def at(self, x, y):
        i, k = math.floor(x), math.floor(y)
        u, v = smooth_step(0, 1, x - i), smooth_step(0, 1, y - k)
        corner = lambda a, b: self.table[(i + a) % 64][(k + b) % 64]
        return ((1 - u) * ((1 - v) * corner(0, 0) + v * corner(0, 1)) +
                u * ((1 - v) * corner(1, 0) + v * corner(1, 1)))


def radiance(x, up, z, noise):
    """Returns the radiance from a unit direction: clouds above, haze at the horizon, warm ground below."""
    if up < 0:
        return mixed([0.62, 0.6, 0.56], [0.2, 0.165, 0.13], smooth_step(0, 0.12, -up))
    clear = mixed([0.95, 0.97, 1.0], [0.16, 0.36, 0.86], up ** 0.45)
    reach = 1 / (up + 0.18)
    thick = sum(0.5 ** octave * noise.at(1.3 * 2 ** octave * x * reach + 9 * octave, 1.3 * 2 ** octave * z * reach)
                for octave in range(5))
    cloud = smooth_step(0.95, 1.35, thick) * smooth_step(0.02, 0.2, up)
    return mixed(clear, mixed([1.9, 1.88, 1.85], [0.85, 0.88, 0.93], smooth_step(1.1, 1.6, thick)), 0.85 * cloud)


def encoded(light):
    """Returns the four bytes of RGBE (Ward 1991)."""
    mantissa, exponent = math.frexp(max(light))
    scale = mantissa * 256 / max(light)
    return bytes([*(min(255, int(one * scale)) for one in light), exponent + 128])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=pathlib.Path)
    output = parser.parse_args().output
    noise = Noise(SEED)
    rows = bytearray(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {HEIGHT} +X {WIDTH}\n".encode())
    for row in range(HEIGHT):
        theta = math.pi * (row + 0.5) / HEIGHT
        for column in range(WIDTH):
            phi = 2 * math.pi * (column + 0.5) / WIDTH - math.pi
            across = math.sin(theta)
            place = (across * math.sin(phi), math.cos(theta), -across * math.cos(phi))
            is_sun = sum(one * sun for one, sun in zip(place, SUN)) > SUN_COSINE
            rows += encoded(SUN_RADIANCE if is_sun else radiance(*place, noise))
    output.write_bytes(bytes(rows))


if __name__ == "__main__":
    main()
