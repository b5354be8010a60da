#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads baked files, NAME.ndf.exr, with OpenImageIO and numpy, as file_format.md describes them.

Usage: read_baked.py FILE LEVEL prints the mean of each array of the level, and compares the checksum of the pixels.
"""
import hashlib
import sys

import numpy as np
import OpenImageIO as oiio


def finest_z(x, y, encoding):
    """Computes z of the normals of level 0, rounded up so that no normal is shorter than 1."""
    x, y = x.astype(np.float64), y.astype(np.float64)
    if encoding == "snorm16":
        i, j = np.rint(x * 32767), np.rint(y * 32767)
        return np.ceil(np.sqrt(np.maximum(32767**2 - i * i - j * j, 0))) / 32767
    grid = np.float16 if encoding == "half" else np.float32
    root = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    z = root.astype(grid)
    return np.where(z < root, np.nextafter(z, grid(2)), z)


def finest_square(x, y, encoding):
    """Computes x^2 + y^2 for Gaussians, rounded down so that no texel has a variance."""
    x, y = x.astype(np.float64), y.astype(np.float64)
    if encoding == "snorm16":
        i, j = np.rint(x * 32767), np.rint(y * 32767)
        return np.minimum((i * i + j * j) // 32767, 32767) / 32767
    grid = np.float16 if encoding == "half" else np.float32
    square = x * x + y * y
    q = square.astype(grid)
    return np.where(q > square, np.nextafter(q, grid(-1)), q)


def materials(attributes, version):
    """Returns the number of weights, and whether the file contains roughness. Either raises the version by one."""
    found = attributes["multum:formatVersion"]
    assert found in (version, version + 1), "another version"
    if found == version:
        return 0, False
    return attributes["multum:weightCount"], attributes["multum:roughness"] != 0


def read_finest(file, count, weights, rough, attributes):
    """Reads level 0 as lobes, colours and weights, in the form of the other levels."""
    colours = 3 if attributes["multum:hasColours"] != 0 else 0
    data = np.asarray(file.read_image(0, 0, 0, colours + 3 + rough + weights, oiio.FLOAT))
    lobe, x, y = np.moveaxis(data[..., colours : colours + 3], -1, 0)
    third = finest_square if attributes["multum:representation"] == "gmm" else finest_z
    z = data[..., colours + 3] if rough else third(x, y, attributes["multum:encoding"])
    given = (lobe == np.arange(count)[:, None, None])[..., None]  # [lobe, y, x, 1]
    lobes = given * np.stack([x, y, z, np.ones_like(x)], -1)
    return lobes, given * data[..., :colours], given * data[..., data.shape[-1] - weights :]


def read_lobes(path, level):
    """Reads a level of the map: amplitudes [lobe, y, x]; mean vectors [lobe, y, x, 3], for Gaussians (m_x, m_y, v);
    colours [lobe, y, x, 3 or 0]; weights [lobe, y, x, weight count]."""
    file = oiio.ImageInput.open(path)
    attributes = file.spec()
    gaussians = attributes["multum:representation"] == "gmm"
    assert gaussians or attributes["multum:representation"] == "movmf"
    weights, rough = materials(attributes, 1 if gaussians else 3)
    first_level, count = attributes["multum:firstLevel"], attributes["multum:lobeCount"]
    colours = 3 if attributes["multum:hasColours"] != 0 else 0
    assert level >= first_level, "the file leaves this level to the normal map"
    if level == 0:
        lobes, colour, weight = read_finest(file, count, weights, rough, attributes)
    else:
        first_part, level_there = (1, level - 1) if first_level == 0 else (0, level - first_level)
        read = lambda part, channels: np.asarray(file.read_image(part, level_there, 0, channels, oiio.FLOAT))
        all_of = lambda part, channels: np.stack([read(part + j, channels)[..., :channels] for j in range(count)])
        lobes = all_of(first_part, 4)
        none = lobes[..., :0]
        colour = all_of(first_part + count, 3) if colours else none
        weight = all_of(first_part + (2 if colours else 1) * count, weights) if weights else none
    amplitude = lobes[..., 3]
    divisor = np.maximum(amplitude, 1e-20)[..., None]
    mean = lobes[..., :3] / divisor
    if gaussians:
        mean[..., 2] = np.maximum(mean[..., 2] - mean[..., 0] ** 2 - mean[..., 1] ** 2, 0) / 2
    else:
        mean /= np.maximum(np.linalg.norm(mean, axis=-1, keepdims=True), 1.0)  # rounding may exceed 1: clamp
    return amplitude, mean, colour / divisor, weight / divisor


def content_hash(path):
    file, digests, part = oiio.ImageInput.open(path), "", 0
    while file.seek_subimage(part, 0):
        level, channels = 0, file.spec().nchannels
        while file.seek_subimage(part, level):
            values = np.ascontiguousarray(file.read_image(part, level, 0, channels, oiio.FLOAT), dtype="<f4")
            digests += hashlib.sha256(values.tobytes()).hexdigest()
            level += 1
        part += 1
    return hashlib.sha256(digests.encode()).hexdigest()


def read_moments(path, level):
    """Reads a level of the map: the six channels of slopes [y, x, 6], mean normals [y, x, 3], colours [y, x, 3 or 0]
    and weights [y, x, weight count]."""
    file = oiio.ImageInput.open(path)
    attributes = file.spec()
    assert attributes["multum:representation"] == "moments"
    weights, _ = materials(attributes, 1)
    level_there = level - attributes["multum:firstLevel"]
    assert level_there >= 0, "the file leaves this level to the normal map"
    read = lambda part, channels: np.asarray(file.read_image(part, level_there, 0, channels, oiio.FLOAT))
    slopes, normals = read(0, 6), read(1, 3)
    colour = read(2, 3) if attributes["multum:hasColours"] != 0 else normals[..., :0]
    return slopes, normals, colour, read(3 if colour.size else 2, weights) if weights else normals[..., :0]


def read_harmonics(path, level):
    """Reads a level of the map: coefficients [y, x, L (L + 2)], colours [y, x, 3 or 0] and weights [y, x, weight
    count]."""
    file = oiio.ImageInput.open(path)
    attributes = file.spec()
    assert attributes["multum:representation"] == "sh"
    weights, _ = materials(attributes, 1)
    level_there = level - attributes["multum:firstLevel"]
    assert level_there >= 0, "the file leaves this level to the normal map"
    read = lambda part, channels: np.asarray(file.read_image(part, level_there, 0, channels, oiio.FLOAT))
    order = attributes["multum:shOrder"]
    count = order * (order + 2)
    parts = [read(i, min(4, count - 4 * i)) for i in range((count + 3) // 4)]
    coefficients = np.concatenate(parts, axis=2)
    colour = read(len(parts), 3) if attributes["multum:hasColours"] != 0 else coefficients[..., :0]
    return coefficients, colour, read(len(parts) + (colour.size > 0), weights) if weights else coefficients[..., :0]


def main():
    path, level = sys.argv[1], int(sys.argv[2])
    file = oiio.ImageInput.open(path)
    if file is None:
        sys.exit(f"cannot read {path}: {oiio.geterror()}")
    attributes = file.spec()
    readers = {"movmf": read_lobes, "gmm": read_lobes, "moments": read_moments, "sh": read_harmonics}
    for values in readers[attributes["multum:representation"]](path, level):
        print(values.shape, "mean", values.mean() if values.size else None)
    is_whole = content_hash(path) == attributes["multum:contentHash"]
    print("checksum agrees" if is_whole else "checksum differs: the file is damaged")
    return 0 if is_whole else 1


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main())
