#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Ray-traces a tiled floor and a glossy board in 4 views under 4 lights. The result is a folder that `multum animation`
reads.

  tools/traced_room.py FOLDER

Writes scene.json (cameras), geometry.obj, rad_vVV_pPP.exr (radiance, one pass per layer) and id_vVV_pPP.png (the
number of the object in each pixel). Needs only the standard library and a few seconds.
"""
import argparse
import json
import math
import pathlib
import struct
import zlib

WIDTH, HEIGHT, VIEWS, LIGHTS = 96, 72, 4, 4
SUB_PIXELS = 2  # number of sub-pixels along each side of a pixel
# The objects in alphabetical order, which is the order of the numbers in id_*.png. Each has a name, a corner, and its
# edges along u and v.
QUADS = (("board", (-0.5, 0.4, 0.0), (0.9, 0.2, 0.0), (0.0, 0.0, 0.7)),
         ("floor", (-1.5, -1.0, 0.0), (3.0, 0.0, 0.0), (0.0, 3.0, 0.0)))
BOARD = 0
PASSES = ("diffuse", "glossy")


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def intersect(quad, eye, ray):
    """Returns the distance in ray lengths, u and v. The distance is infinite if the ray misses."""
    _, corner, u_edge, v_edge = quad
    normal = cross(u_edge, v_edge)
    along = dot(normal, ray)
    if abs(along) < 1e-12:
        return math.inf, 0.0, 0.0
    distance = dot(normal, minus(corner, eye)) / along
    local = minus([e + distance * r for e, r in zip(eye, ray)], corner)
    u, v = dot(local, u_edge) / dot(u_edge, u_edge), dot(local, v_edge) / dot(v_edge, v_edge)
    if distance <= 0.0 or not (0.0 <= u <= 1.0 and 0.0 <= v <= 1.0):
        return math.inf, 0.0, 0.0
    return distance, u, v


def shade(quad, u, v, view, light):
    """Returns the diffuse and the glossy radiance. The board has a highlight that moves with view and light."""
    level = 0.4 + 0.2 * light
    if quad != BOARD:
        tiles = math.sin(12 * math.pi * u) * math.sin(12 * math.pi * v)
        return [level * c for c in (0.35 + 0.25 * tiles, 0.3 - 0.1 * tiles, 0.25)], [0.0] * 3
    highlight = 0.5 * math.exp(-25.0 * ((u - 0.3 - 0.05 * view) ** 2 + (v - 0.3 - 0.1 * light) ** 2))
    return [level * c for c in (0.3, 0.3 + 0.1 * v, 0.5)], [highlight] * 3


def camera_of(view):
    """Returns the eye, the axes right, up and back of camera space, and the scale of x and y in clip space."""
    eye = [2.0 * math.sin(0.1 * view), -2.0 * math.cos(0.1 * view), 1.2]
    away = minus(eye, (0.0, 0.3, 0.2))
    back = [x / math.sqrt(dot(away, away)) for x in away]
    side = cross((0.0, 0.0, 1.0), back)
    right = [x / math.sqrt(dot(side, side)) for x in side]
    zoom = 1.0 / math.tan(0.4)
    return eye, (right, cross(back, right), back), (zoom * HEIGHT / WIDTH, zoom)


def seen_from(view):
    """Returns the object, u and v of each sub-pixel, row by row, or None if no object is visible there."""
    eye, (right, up, back), (scale_x, scale_y) = camera_of(view)
    columns, rows = WIDTH * SUB_PIXELS, HEIGHT * SUB_PIXELS
    seen = []
    for y in range(rows):
        for x in range(columns):
            across, high = (2 * (x + 0.5) / columns - 1) / scale_x, (1 - 2 * (y + 0.5) / rows) / scale_y
            ray = [across * r + high * u - b for r, u, b in zip(right, up, back)]
            nearest, quad = min((intersect(quad, eye, ray), number) for number, quad in enumerate(QUADS))
            seen.append((quad, nearest[1], nearest[2]) if nearest[0] < math.inf else None)
    return seen


def write_exr(path, planes):
    """Writes float channels without compression."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data

    names = sorted(planes)
    channels = b"".join(name.encode() + b"\0" + struct.pack("<4i", 2, 0, 1, 1) for name in names) + b"\0"
    window = struct.pack("<4i", 0, 0, WIDTH - 1, HEIGHT - 1)
    header = struct.pack("<2i", 20000630, 2)
    for one in ((b"channels", b"chlist", channels), (b"compression", b"compression", b"\0"),
                (b"dataWindow", b"box2i", window), (b"displayWindow", b"box2i", window),
                (b"lineOrder", b"lineOrder", b"\0"), (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
                (b"screenWindowCenter", b"v2f", bytes(8)), (b"screenWindowWidth", b"float", struct.pack("<f", 1))):
        header += attribute(*one)
    header += b"\0"
    first, size = len(header) + 8 * HEIGHT, 4 * WIDTH * len(names)
    with open(path, "wb") as file:
        file.write(header)
        for y in range(HEIGHT):
            file.write(struct.pack("<q", first + y * (8 + size)))
        for y in range(HEIGHT):
            file.write(struct.pack("<2i", y, size))
            for name in names:
                file.write(struct.pack(f"<{WIDTH}f", *planes[name][y * WIDTH:(y + 1) * WIDTH]))


def write_png(path, grey):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes(grey[y * WIDTH:(y + 1) * WIDTH]) for y in range(HEIGHT))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", WIDTH, HEIGHT, 8, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_pictures(folder, name, seen, view, light):
    planes = {f"{one}.{channel}": [0.0] * (WIDTH * HEIGHT) for one in PASSES for channel in "RGB"}
    numbers = [0] * (WIDTH * HEIGHT)
    for i, hit in enumerate(seen):
        if hit is None:
            continue
        pixel = i // (WIDTH * SUB_PIXELS) // SUB_PIXELS * WIDTH + i % (WIDTH * SUB_PIXELS) // SUB_PIXELS
        numbers[pixel] = hit[0] + 1
        for one, colour in zip(PASSES, shade(*hit, view, light)):
            for channel, value in zip("RGB", colour):
                planes[f"{one}.{channel}"][pixel] += value / SUB_PIXELS ** 2
    write_exr(folder / f"rad_{name}.exr", planes)
    write_png(folder / f"id_{name}.png", numbers)


def object_lines():
    for number, (name, corner, u_edge, v_edge) in enumerate(QUADS):
        yield f"o {name}"
        for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
            yield "v " + " ".join(f"{c + u * a + v * b:g}" for c, a, b in zip(corner, u_edge, v_edge))
            yield f"vt {u} {v}"
        yield "f " + " ".join(f"{4 * number + k}/{4 * number + k}" for k in (1, 2, 3, 4))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "geometry.obj").write_text("\n".join(object_lines()) + "\n")
    samples = []
    for view in range(VIEWS):
        eye, axes, (scale_x, scale_y) = camera_of(view)
        world_to_camera = [list(axis) + [-dot(axis, eye)] for axis in axes] + [[0, 0, 0, 1]]
        projection = [[scale_x, 0, 0, 0], [0, scale_y, 0, 0], [0, 0, -1.01, -0.201], [0, 0, -1, 0]]
        seen = seen_from(view)
        for light in range(LIGHTS):
            name = f"v{view:02}_p{light:02}"
            write_pictures(folder, name, seen, view, light)
            samples.append({"name": name, "view": view, "param": light, "light_swing_deg": 30 * light,
                            "world_to_camera": world_to_camera, "projection": projection})
    still = [[int(row == column) for column in range(4)] for row in range(4)]
    scene = {"width": WIDTH, "height": HEIGHT, "views": VIEWS, "params": LIGHTS, "samples": samples,
             "objects": {quad[0]: {"object_to_world": still} for quad in QUADS}}
    (folder / "scene.json").write_text(json.dumps(scene) + "\n")
    print(f"{folder}: written: {VIEWS} views x {LIGHTS} lights, {WIDTH} x {HEIGHT} pixels")


if __name__ == "__main__":
    main()
