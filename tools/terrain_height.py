#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the Jacksboro fault terrain as a 16-bit grey PNG, a height field that `multum bake` reads.

The heights, int16 metres on a grid of 3 arc seconds, come with Debian's python-matplotlib-data as an .npz file, a ZIP
of .npy arrays. The standard library is enough to read that file and to write PNG. Prints the matching --height-scale,
which is the height in texels that a value difference of 1 represents, times the chosen exaggeration.

  tools/terrain_height.py OUT.png [--exaggeration 4] [--every 1] [--input jacksboro_fault_dem.npz]
"""
import argparse
import ast
import math
import pathlib
import struct
import sys
import zipfile
import zlib

DEFAULT_INPUT = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"
METRES_PER_DEGREE = 111320.0  # for latitude; for longitude, the number is multiplied by the cosine of the latitude


def read_npy(data):
    """Reads an .npy file (https://numpy.org/neps/nep-0001-npy-format.html) as (shape, flat tuple of numbers)."""
    if data[:6] != b"\x93NUMPY":
        raise ValueError("no .npy header")
    length_format, start = ("<H", 10) if data[6] == 1 else ("<I", 12)
    (header_length,) = struct.unpack_from(length_format, data, 8)
    header = ast.literal_eval(data[start:start + header_length].decode("latin1"))
    if header["fortran_order"]:
        raise ValueError("columns first; expected rows first")
    order, letter = header["descr"][0], {"i2": "h", "i4": "i", "i8": "q", "f4": "f", "f8": "d"}[header["descr"][1:]]
    count = math.prod(header["shape"])
    return header["shape"], struct.unpack_from(f"{'>' if order == '>' else '<'}{count}{letter}", data,
                                               start + header_length)


def read_terrain(path):
    """Returns rows of heights in metres, northernmost first, and the grid's spacing in metres, which is the mean of
    both axes."""
    with zipfile.ZipFile(path) as archive:
        arrays = {name.removesuffix(".npy"): read_npy(archive.read(name)) for name in archive.namelist()}
    (height, width), values = arrays["elevation"]
    one = {name: arrays[name][1][0] for name in ("ymin", "ymax", "dx", "dy")}
    latitude = math.radians((one["ymin"] + one["ymax"]) / 2)
    spacing = METRES_PER_DEGREE * (abs(one["dy"]) + abs(one["dx"]) * math.cos(latitude)) / 2
    return [values[y * width:(y + 1) * width] for y in range(height)], spacing


def encode_png16(rows):
    """Writes rows of 0..65535 as a grey PNG. Filter 2 (difference to the row above) halves the size of smooth
    heights."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    lines, above = [], bytes(2 * len(rows[0]))
    for row in rows:
        line = struct.pack(f">{len(row)}H", *row)
        lines.append(b"\x02" + bytes((a - b) & 255 for a, b in zip(line, above)))
        above = line
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 16, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"".join(lines), 9)) +
            chunk(b"IEND", b""))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output")
    parser.add_argument("--input", default=DEFAULT_INPUT)
    parser.add_argument("--exaggeration", type=float, default=4.0)
    parser.add_argument("--every", type=int, default=1, metavar="N",
                        help="take every Nth height along both axes (default: 1)")
    arguments = parser.parse_args()
    try:
        rows, spacing = read_terrain(arguments.input)
        rows, spacing = [row[::arguments.every] for row in rows[::arguments.every]], spacing * arguments.every
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        sys.exit(f"{arguments.input}: {error}; expected the terrain of Debian's python-matplotlib-data")
    low, high = min(map(min, rows)), max(map(max, rows))
    steps = 65535 // (high - low)  # a whole number of steps per metre, so that no height is rounded
    pathlib.Path(arguments.output).write_bytes(encode_png16([[(h - low) * steps for h in row] for row in rows]))
    print(f"{65535 / steps / spacing * arguments.exaggeration:.2f}")


if __name__ == "__main__":
    main()
