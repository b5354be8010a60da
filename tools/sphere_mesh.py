#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a sphere of radius 1 as an OBJ file. It is a blown-up cube, so that no place pinches the map. Each side of
the cube shows the map twice along each axis.

  tools/sphere_mesh.py OUT.obj
"""
import argparse
import math
import pathlib

STEPS, REPEATS = 32, 2
# across and up of each side, whose cross product points outwards
SIDES = (((1, 0, 0), (0, 1, 0)), ((0, 0, -1), (0, 1, 0)), ((-1, 0, 0), (0, 1, 0)), ((0, 0, 1), (0, 1, 0)),
         ((1, 0, 0), (0, 0, -1)), ((1, 0, 0), (0, 0, 1)))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def sphere_lines():
    columns = STEPS + 1  # the vertices of edges exist once per side, with different texture coordinates
    for across, up in SIDES:
        out = cross(across, up)
        for i in range(columns):
            for j in range(columns):
                s, t = (math.tan(math.pi / 4 * (2 * k / STEPS - 1)) for k in (i, j))
                place = [o + s * a + t * u for o, a, u in zip(out, across, up)]
                size = math.hypot(*place)
                x, y, z = (one / size for one in place)
                yield f"v {x:.6f} {y:.6f} {z:.6f}"
                yield f"vt {REPEATS * i / STEPS:.6f} {REPEATS * j / STEPS:.6f}"
                yield f"vn {x:.6f} {y:.6f} {z:.6f}"
    for side in range(len(SIDES)):
        for i in range(STEPS):
            for j in range(STEPS):
                first = side * columns * columns + i * columns + j + 1  # indices in OBJ files begin with 1
                corners = (first, first + columns, first + columns + 1, first + 1)
                yield "f " + " ".join(f"{k}/{k}/{k}" for k in corners)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=pathlib.Path)
    parser.parse_args().output.write_text("\n".join(sphere_lines()) + "\n")


if __name__ == "__main__":
    main()
