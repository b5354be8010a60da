# SPDX-License-Identifier: Apache-2.0
"""Draws distributions of normals: of the normals of a texel, and of its lobes or planar Gaussians.

The density is shown over the disk of (n_x, n_y), seen from above. At the rim, normals are parallel to the surface.
"""
import numpy as np
import OpenImageIO as oiio
from study import read_picture

SMOOTHING = 300.0  # kappa of the kernel that turns single normals into a visible density


def read_normals(path):
    """Reads an unsigned normal map with green up, as `multum testmap` writes it: [height, width, 3], unit vectors."""
    n = read_picture(path)[:, :, :3].astype(np.float64) * 2 - 1
    return n / np.linalg.norm(n, axis=2, keepdims=True)


def read_lobes(path, level):
    """Returns (a r, a) of a coarse level's lobes [lobe, height, width, 4] (docs/reference/file_format.md). `level` is
    at least 1."""
    source = oiio.ImageInput.open(str(path))
    count = source.spec()["multum:lobeCount"]
    lobes = [np.asarray(source.read_image(1 + j, level - 1, 0, 4, oiio.FLOAT)) for j in range(count)]
    source.close()
    return np.stack(lobes).astype(np.float64)


def disk(size):
    """Returns unit vectors [size, size, 3] over the disk, and which pixels are inside."""
    axis = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    inside = x * x + y * y < 1
    return np.dstack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))]), inside


def vmf(kappa, cosine):
    """Returns kappa / (4 pi sinh kappa) exp(kappa t), in a form that does not overflow."""
    return kappa / (2 * np.pi * -np.expm1(-2 * kappa)) * np.exp(kappa * (cosine - 1))


def kappa_of(mean_cosine):
    """Returns the inverse of A, by Banerjee's formula and Newton steps."""
    r = np.clip(mean_cosine, 1e-6, 1 - 1e-7)
    kappa = r * (3 - r * r) / (1 - r * r)
    for _ in range(4):
        a = 1 / np.tanh(kappa) - 1 / kappa
        kappa = np.maximum(kappa - (a - r) / np.maximum(1 - a * a - 2 * a / kappa, 1e-12), 1e-6)
    return kappa


def density_of_normals(normals, directions):
    """Returns the density of [count, 3] normals, each smoothed by a vMF of SMOOTHING."""
    flat = directions.reshape(-1, 3)
    total = np.zeros(len(flat))
    for block in np.array_split(normals, max(1, len(normals) // 64)):
        total += vmf(SMOOTHING, flat @ block.T).sum(axis=1)
    return (total / len(normals)).reshape(directions.shape[:2])


def density_of_lobes(lobes, directions):
    """Returns the density of a texel's lobes [lobe, 4], convolved with the same kernel. A convolution multiplies mean
    cosines (docs/contributing/ALGORITHMS.md)."""
    total = np.zeros(directions.shape[:2])
    smoothing_cosine = 1 / np.tanh(SMOOTHING) - 1 / SMOOTHING
    for lobe in lobes:
        amplitude, length = lobe[3], np.linalg.norm(lobe[:3])
        if amplitude > 1e-6 and length > 0:
            kappa = kappa_of(min(length / amplitude, 1.0) * smoothing_cosine)
            total += amplitude * vmf(kappa, directions @ (lobe[:3] / length))
    return total


def picture(density, inside, peak):
    """Draws a density in grey. A quarter of the peak is half as bright as the peak."""
    grey = np.where(inside, np.sqrt(np.clip(density / peak, 0, 1)), 0.0)
    rgb = np.dstack([grey, grey, grey])
    rgb[~inside] = (0.02, 0.03, 0.06)
    return rgb


def density_error(density, reference, directions, inside):
    """Returns the relative L1 error, integrated over solid angle: d omega = dx dy / n_z."""
    weight = np.where(inside, 1 / np.maximum(directions[:, :, 2], 0.05), 0)
    return float((np.abs(density - reference) * weight).sum() / (reference * weight).sum())
