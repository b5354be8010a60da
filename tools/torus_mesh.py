#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a torus as an OBJ file. It is a closed surface whose texture coordinates wrap, for pictures that show every
angle.

  tools/torus_mesh.py OUT.obj

The map repeats four times around the ring and twice around the tube. Each repeat is about as long as it is wide.
"""
import argparse
import math
import pathlib

RING_RADIUS, TUBE_RADIUS = 1.0, 0.42
RING_STEPS, TUBE_STEPS = 96, 48
RING_REPEATS, TUBE_REPEATS = 4, 2


def torus_lines():
    columns = TUBE_STEPS + 1  # the vertices of the seam exist twice, with different texture coordinates
    for i in range(RING_STEPS + 1):
        for j in range(columns):
            ring, tube = 2 * math.pi * i / RING_STEPS, 2 * math.pi * j / TUBE_STEPS
            out = RING_RADIUS + TUBE_RADIUS * math.cos(tube)
            yield f"v {out * math.cos(ring):.6f} {out * math.sin(ring):.6f} {TUBE_RADIUS * math.sin(tube):.6f}"
            yield f"vt {RING_REPEATS * i / RING_STEPS:.6f} {TUBE_REPEATS * j / TUBE_STEPS:.6f}"
            yield (f"vn {math.cos(tube) * math.cos(ring):.6f} {math.cos(tube) * math.sin(ring):.6f} "
                   f"{math.sin(tube):.6f}")
    for i in range(RING_STEPS):
        for j in range(TUBE_STEPS):
            first = i * columns + j + 1  # indices in OBJ files begin with 1
            corners = (first, first + columns, first + columns + 1, first + 1)
            yield "f " + " ".join(f"{k}/{k}/{k}" for k in corners)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=pathlib.Path)
    parser.parse_args().output.write_text("\n".join(torus_lines()) + "\n")


if __name__ == "__main__":
    main()
