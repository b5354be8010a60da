# SPDX-License-Identifier: Apache-2.0
"""Writes a small field of traced frames: a patterned ground and an upright board, from some views under some lights,
like tests/cli/traced_scene.cpp. docs/reference/animation_jobs.md describes the format of the files."""
import json
import pathlib

import numpy as np
import OpenImageIO as oiio

SUB_PIXELS = 4  # along each side
# These are the corner, and the edges along which u and v go from 0 to 1.
QUADS = {"ground": ((-1.5, -1.0, 0.0), (3.0, 0.0, 0.0), (0.0, 3.0, 0.0)),
         "board": ((-0.5, 0.4, 0.0), (0.9, 0.2, 0.0), (0.0, 0.0, 0.7))}
HASHES = {"ground": 0x3F400000, "board": 0x3E800000}


def camera(view):
    """Returns the matrix from world to camera, 4 x 4."""
    eye = np.array([2.0 * np.sin(0.1 * view), -2.0 * np.cos(0.1 * view), 1.2])
    back = eye - np.array([0.0, 0.3, 0.2])
    back /= np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    rows = np.stack([right, np.cross(back, right), back])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rows, -rows @ eye
    return matrix


def projection(width, height):
    near, far, scale = 0.1, 20.0, 1 / np.tan(0.4)
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = scale * height / width, scale
    matrix[2, 2:] = -(far + near) / (far - near), -2 * far * near / (far - near)
    matrix[3, 2] = -1
    return matrix


def traced(view, width, height, steps):
    """Returns arrays of [height * steps, width * steps]: the object of each ray (0: none, 1: ground, 2: board), u, v,
    and the depth."""
    to_clip, to_world = projection(width, height), np.linalg.inv(camera(view))
    y, x = (np.mgrid[0:height * steps, 0:width * steps] + 0.5) / steps
    in_camera = np.stack([(2 * x / width - 1) / to_clip[0, 0], (1 - 2 * y / height) / to_clip[1, 1], -np.ones_like(x)],
                         -1)
    towards, eye = in_camera @ to_world[:3, :3].T, to_world[:3, 3]
    number, depth = np.zeros(x.shape, np.uint8), np.full(x.shape, 1e10)
    u, v = np.zeros(x.shape), np.zeros(x.shape)
    for which, quad in enumerate(QUADS.values(), start=1):
        corner, u_edge, v_edge = map(np.array, quad)
        normal = np.cross(u_edge, v_edge)
        distance = normal @ (corner - eye) / (towards @ normal)
        local = eye + distance[..., None] * towards - corner
        at_u, at_v = local @ u_edge / (u_edge @ u_edge), local @ v_edge / (v_edge @ v_edge)
        hit = (distance > 0) & (distance < depth) & (at_u >= 0) & (at_u <= 1) & (at_v >= 0) & (at_v <= 1)
        number[hit], depth[hit], u[hit], v[hit] = which, distance[hit], at_u[hit], at_v[hit]
    return number, u, v, depth


def pixel_means(values):
    height, width = (n // SUB_PIXELS for n in values.shape[:2])
    return values.reshape(height, SUB_PIXELS, width, SUB_PIXELS, -1).mean(axis=(1, 3))


def colours(number, u, v, view, light):
    """Returns the diffuse and the glossy radiance."""
    waves = np.sin(12 * np.pi * u) * np.sin(12 * np.pi * v)
    ground = np.stack([0.35 + 0.25 * waves, 0.3 - 0.1 * waves, np.full_like(u, 0.25)], -1)
    board = np.stack([np.full_like(u, 0.3), 0.3 + 0.1 * v, np.full_like(u, 0.5)], -1)
    is_board = (number == 2)[..., None]
    diffuse = (0.6 + 0.3 * light) * np.where(is_board, board, ground) * (number > 0)[..., None]
    spot = 0.3 * np.exp(-25 * ((u - 0.4 - 0.05 * view) ** 2 + (v - 0.5 - 0.1 * light) ** 2))
    return diffuse, np.where(is_board, spot[..., None], 0.0) * np.ones(3)


def write(path, planes, attributes=()):
    spec = oiio.ImageSpec(*reversed(next(iter(planes.values())).shape), len(planes), oiio.FLOAT)
    spec.channelnames = tuple(planes)
    for name, value in attributes:
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    if not output.open(str(path), spec):
        raise RuntimeError(output.geterror())
    output.write_image(np.ascontiguousarray(np.stack(list(planes.values()), -1), np.float32))
    output.close()


def write_geometry(path, view, width, height):
    number, *_ = traced(view, width, height, SUB_PIXELS)
    covered = {name: pixel_means((number == which).astype(float))[..., 0] for which, name in enumerate(QUADS, start=1)}
    is_ground_first = covered["ground"] >= covered["board"]
    planes = {"Z": traced(view, width, height, 1)[3]}
    for rank, (first, second) in enumerate((("ground", "board"), ("board", "ground"))):
        share = np.where(is_ground_first, covered[first], covered[second])
        hashes = np.where(is_ground_first, HASHES[first], HASHES[second]).astype(np.uint32).view(np.float32)
        planes[f"CryptoObject00.{'rb'[rank]}"] = np.where(share > 0, hashes, 0)
        planes[f"CryptoObject00.{'ga'[rank]}"] = share
    manifest = json.dumps({name: f"{value:08x}" for name, value in HASHES.items()})
    write(path, planes, [("cryptomatte/1234567/name", "ViewLayer.CryptoObject"),
                         ("cryptomatte/1234567/hash", "MurmurHash3_32"),
                         ("cryptomatte/1234567/conversion", "uint32_to_float32"),
                         ("cryptomatte/1234567/manifest", manifest)])


def write_traced_field(folder, views=2, lights=2, width=96, height=72):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True)
    samples, lines = [], []
    for view in range(views):
        number, u, v, _ = traced(view, width, height, SUB_PIXELS)
        write_geometry(folder / f"geom_v{view:02d}.exr", view, width, height)
        for light in range(lights):
            name = f"v{view:02d}_p{light:02d}"
            diffuse, glossy = map(pixel_means, colours(number, u, v, view, light))
            passes = {"": diffuse + glossy, "diffuse.": diffuse, "glossy.": glossy, "transmission.": 0 * glossy}
            write(folder / f"rad_{name}.exr", {f"{prefix}{'RGB'[c]}": values[..., c]
                                               for prefix, values in passes.items() for c in range(3)})
            samples.append({"index": view * lights + light, "view": view, "param": light, "name": name,
                            "light_swing_deg": 30.0 * light, "world_to_camera": camera(view).tolist(),
                            "projection": projection(width, height).tolist(),
                            "world_to_clip": (projection(width, height) @ camera(view)).tolist()})
    for number, (name, quad) in enumerate(QUADS.items()):
        corner, u_edge, v_edge = map(np.array, quad)
        lines.append(f"o {name}_Mesh")
        for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
            lines += ["v {} {} {}".format(*(corner + u * u_edge + v * v_edge)), f"vt {u} {v}"]
        a, b, c, d = (f"{4 * number + k}/{4 * number + k}" for k in (1, 2, 3, 4))
        lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    (folder / "geometry.obj").write_text("\n".join(lines) + "\n")
    objects = {name: {"triangles": 2, "object_to_world": np.eye(4).tolist()} for name in QUADS}
    (folder / "scene.json").write_text(json.dumps({"mode": "demo1", "width": width, "height": height, "views": views,
                                                   "params": lights, "objects": objects, "samples": samples}))
