#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A small path tracer in NumPy that samples the lobes of a baked map.

A bumpy metal floor lies in front of a white wall, under a sky with a sun. The picture is drawn three times:
  reference   level 0 of the map, the normals themselves, at random places of each pixel, with many paths
  lobes       the map filtered to the pixel's footprint; directions come from multum's sample()
  cosine      the same, but directions come from the cosine around the vertical
Prints the error of both against the reference, and how many times more paths the cosine needs for the same noise.

  path_tracer.py [NORMAL_MAP] [-o picture.png] [--size 96] [--paths 32]
"""
import argparse

import numpy as np

import multum

REPEATS = 1.0  # of the map per unit of the floor
BRDF = multum.Brdf("ggx:0.25,0.9")
SUN = np.array([0.35, 0.5, 0.79]) / np.linalg.norm([0.35, 0.5, 0.79])
WALL_Y = 3.0


def wavy_map(size=256):
    """Returns unit normals of crossed waves; float arrays hold vectors."""
    t, s = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    a = 0.5 * np.sin(2 * np.pi * 8 * s / size) + 0.2 * np.sin(2 * np.pi * (19 * s + 7 * t) / size)
    b = 0.5 * np.sin(2 * np.pi * 8 * t / size)
    return (np.stack([-a, -b, np.ones_like(a)], -1) / np.sqrt(1 + a * a + b * b)[..., None]).astype(np.float32)


def sky(directions):
    """Radiance of the sky: a gradient and a soft sun, grey, (n, 1)."""
    up = np.clip(directions[:, 2], 0, 1)
    sun = 8 * np.exp(60 * (directions @ SUN - 1))
    return (0.2 + 0.8 * up + sun)[:, None]


def around(normal, cosine, angle):
    """Returns unit directions at this cosine from a constant unit normal."""
    helper = np.array([1.0, 0, 0]) if abs(normal[0]) < 0.9 else np.array([0, 1.0, 0])
    s = np.cross(normal, helper)
    s /= np.linalg.norm(s)
    t = np.cross(normal, s)
    sine = np.sqrt(1 - cosine**2)
    return (sine * np.cos(angle))[:, None] * s + (sine * np.sin(angle))[:, None] * t + cosine[:, None] * normal


def camera(size, offsets):
    """Rays through the pixels, moved by offsets (n, 2) in pixels, and the width of a pixel in radians."""
    y, x = np.divmod(np.arange(size * size), size)
    place = (np.stack([x, y], -1) + offsets - size / 2) / size
    forward, right = np.array([0, 0.94, -0.34]), np.array([1.0, 0, 0])
    up = np.cross(right, forward)
    rays = forward + 0.9 * place[:, :1] * right - 0.9 * place[:, 1:] * up
    return np.array([0, -2.0, 1.6]), rays / np.linalg.norm(rays, axis=1, keepdims=True), 0.9 / size


def floor_directions(lobes, view, rng, by_lobes):
    """Draws a direction and returns it with the reflected share: BRDF * cosine / density."""
    if by_lobes:
        light, density = lobes.sample(view, rng.random(view.shape), BRDF)
    else:
        light = around(np.array([0, 0, 1.0]), np.sqrt(rng.random(len(view))), 2 * np.pi * rng.random(len(view)))
        density = light[:, 2] / np.pi
    usable = (density > 0) & (light[:, 2] > 1e-4)
    share = lobes.shade(light, view, BRDF) / np.where(usable, density, 1)[:, None]
    return light, np.where(usable[:, None], share, 0)


def trace(baked, size, rng, finest, by_lobes, bounces=4):
    """Traces one path per pixel and returns radiance (size * size, 3)."""
    offsets = rng.random((size * size, 2)) if finest else np.full((size * size, 2), 0.5)
    eye, directions, pixel = camera(size, offsets)
    places = np.broadcast_to(eye, directions.shape).copy()
    throughput, radiance = np.ones((size * size, 3)), np.zeros((size * size, 3))
    alive, travelled = np.arange(size * size), np.zeros(size * size)
    for _ in range(bounces):
        d, o = directions[alive], places[alive]
        to_floor = np.where(d[:, 2] < -1e-6, -o[:, 2] / np.minimum(d[:, 2], -1e-6), np.inf)
        to_wall = np.where(d[:, 1] > 1e-6, (WALL_Y - o[:, 1]) / np.maximum(d[:, 1], 1e-6), np.inf)
        to_wall = np.where(o[:, 2] + to_wall * d[:, 2] < 1.5, to_wall, np.inf)  # the wall is 1.5 high
        distance = np.minimum(to_floor, to_wall)
        lost = ~np.isfinite(distance)
        radiance[alive[lost]] += throughput[alive[lost]] * sky(d[lost])
        hit = ~lost
        alive, d, floor = alive[hit], d[hit], (to_floor < to_wall)[hit]
        places[alive] = o[hit] + distance[hit][:, None] * d
        travelled[alive] += distance[hit]
        on_floor, on_wall = alive[floor], alive[~floor]
        if len(on_floor):
            footprint = pixel * travelled[on_floor] * REPEATS * baked.width / np.sqrt(np.maximum(-d[floor][:, 2], 0.05))
            level = 0.0 if finest else np.log2(np.maximum(footprint, 1))
            lobes = baked.lookup(places[on_floor, 0] * REPEATS, -places[on_floor, 1] * REPEATS, level)
            directions[on_floor], share = floor_directions(lobes, -d[floor], rng, by_lobes or finest)
            throughput[on_floor] *= share
        if len(on_wall):
            n = len(on_wall)
            directions[on_wall] = around(np.array([0, -1.0, 0]), np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n))
            throughput[on_wall] *= 0.7
        places[alive] += 1e-4 * directions[alive]
        alive = alive[throughput[alive].max(axis=1) > 0]
    return radiance


def render(baked, size, paths, finest=False, by_lobes=True, seed=1):
    """Returns the mean picture and the variance of one path, each (size, size, 3)."""
    rng = np.random.default_rng(seed)
    total, squares = np.zeros((size * size, 3)), np.zeros((size * size, 3))
    for _ in range(paths):
        one = trace(baked, size, rng, finest, by_lobes)
        total, squares = total + one, squares + one**2
    mean = total / paths
    return mean.reshape(size, size, 3), (squares / paths - mean**2).reshape(size, size, 3)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("normal_map", nargs="?", help="file of a normal map (default: waves)")
    parser.add_argument("-o", "--output", help="picture to write: reference, lobes, cosine; needs matplotlib")
    parser.add_argument("--size", type=int, default=96, help="pixels per side")
    parser.add_argument("--paths", type=int, default=32, help="paths per pixel; the reference has 16 times as many")
    options = parser.parse_args()
    baked = multum.bake(options.normal_map or wavy_map(), lobes=4)
    reference, _ = render(baked, options.size, 16 * options.paths, finest=True)
    pictures, variances = [reference], {}
    for name in ("lobes", "cosine"):
        picture, variance = render(baked, options.size, options.paths, by_lobes=name == "lobes", seed=2)
        pictures.append(picture)
        variances[name] = variance.mean()
        print(f"{name}: mean radiance {picture.mean():.4f} (reference {reference.mean():.4f}), relative error "
              f"{np.abs(picture - reference).mean() / reference.mean():.3f}, variance of a path {variances[name]:.4f}")
    ratio = variances['cosine'] / variances['lobes']
    print(f"cosine sampling needs {ratio:.1f} times as many paths for the same noise")
    if options.output:
        import matplotlib.image
        row = np.concatenate(pictures, axis=1)
        matplotlib.image.imsave(options.output, np.clip(row / (1 + row), 0, 1) ** (1 / 2.2))


if __name__ == "__main__":
    main()
