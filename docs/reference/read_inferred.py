#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads filter matrices and inferred textures, as inferred_textures.md describes them; textures need OpenImageIO.

Usage: read_inferred.py MATRIX.fmx prints the header of a filter matrix.
"""
import json
import sys

import numpy as np


def crc64_xz(data):
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0xC96C5795D7870F42 if value & 1 else 0)
        table.append(value)
    value = 2**64 - 1
    for byte in data:
        value = value >> 8 ^ table[(value ^ byte) & 255]
    return value ^ 2**64 - 1


def read_filter_matrix(path):
    """Reads the header, and pixels, coverage, row_begin, columns and weights as arrays."""
    with open(path, "rb") as file:
        assert file.readline() == b"multum filter matrix 1\n", "no filter matrix, or of another version"
        header = json.loads(file.readline())
        data = file.read()
    rows, entries = header["rows"], header["entries"]
    parts = [(rows, "<u4"), (rows, "<f4"), (rows + 1, "<u4"), (entries, "<u4"), (entries, "<f4")]
    assert len(data) == 4 * sum(length for length, _ in parts), "cut short"
    assert f"{crc64_xz(data):016x}" == header["checksum"], "damaged"
    lists, begin = [], 0
    for length, kind in parts:
        lists.append(np.frombuffer(data[begin : begin + 4 * length], dtype=kind))
        begin += 4 * length
    return header, *lists


def picture_of(matrix, texels):
    """Computes coverage times the product of matrix and texture, [y, x, channel]. Add the pictures of all objects."""
    header, pixels, coverage, row_begin, columns, weights = matrix
    row_of_entry = np.repeat(np.arange(len(pixels)), np.diff(row_begin))
    sums = np.zeros((len(pixels), texels.shape[1]))
    np.add.at(sums, row_of_entry, weights[:, None] * texels[columns])
    picture = np.zeros((header["height"] * header["width"], texels.shape[1]))
    picture[pixels] = coverage[:, None] * sums
    return picture.reshape(header["height"], header["width"], -1)


def read_texels(path):
    """Reads the texels of all levels as [number, channel]."""
    import OpenImageIO as oiio

    file, levels = oiio.ImageInput.open(path), []
    while file.seek_subimage(0, len(levels)):
        levels.append(np.asarray(file.read_image(0, len(levels), 0, 3, oiio.FLOAT)).reshape(-1, 3))
    return np.concatenate(levels)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    print(json.dumps(read_filter_matrix(sys.argv[1])[0], indent=1))
