#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the table of pictures in docs/evidence/EXPORT.md, for which three.js draws exports on planes and a sphere.

    tools/lab/export_pictures.py MAP... [--bin DIR] [--package DIR]

Every map is drawn as a metal of roughness 0.5 and as a dielectric of roughness 0.25, with 4 and 16 texels per pixel, on
a plane from above, on a tilted plane and on a sphere. --package is a folder of @multum/three (`multum shaders -o DIR`:
DIR/three). Errors are relative L1 in % against 8 x 8 samples per pixel of level 0, averaged over the views. Each
material takes a minute.
"""
import argparse
import json
import math
import pathlib
import struct
import sys
import tempfile

import debian_python

debian_python.use_a_python_with("numpy", "OpenImageIO")

import numpy
import OpenImageIO

import model_views

MATERIALS = (("metal, 0.5", 0.5, 1), ("dielectric, 0.25", 0.25, 0))
TEXELS = (4, 16)  # texels per pixel
SIDE, ANGLE, DISTANCE = 100, 45, 2.9
DIRECTIONS = {"plane": ((0.3, 0.1, 1.0), (1.0, 0.5, 0.7)), "sphere": ((0.3, 0.1, 1.0),)}
KTX2 = "image/ktx2"


def grid(kind, repeat):
    """Returns positions, normals, tangents, texture coordinates and indices. Shapes are two units wide. The map goes
    twice around the sphere."""
    columns, rows = (1, 1) if kind == "plane" else (192, 96)
    sides = numpy.array([rows, columns])[:, None, None]
    v, u = (one.ravel() for one in numpy.mgrid[0 : rows + 1, 0 : columns + 1] / sides)
    zero, one = numpy.zeros_like(u), numpy.ones_like(u)
    if kind == "plane":
        positions, normals = numpy.stack([2 * u - 1, 2 * v - 1, zero], 1), numpy.stack([zero, zero, one], 1)
        tangents = numpy.stack([one, zero, zero, one], 1)
    else:
        turn, rise = 2 * math.pi * u, math.pi * (v - 0.5)
        positions = normals = numpy.stack(
            [numpy.cos(rise) * numpy.sin(turn), numpy.sin(rise), numpy.cos(rise) * numpy.cos(turn)], 1)
        tangents = numpy.stack([numpy.cos(turn), zero, -numpy.sin(turn), one], 1)
    places = numpy.stack([u * repeat * (1 if kind == "plane" else 2), (1 - v) * repeat], 1)
    corner = (numpy.arange(rows)[:, None] * (columns + 1) + numpy.arange(columns)).ravel()
    above = corner + columns + 1
    indices = numpy.stack([corner, corner + 1, above + 1, corner, above + 1, above], 1).ravel()
    return positions, normals, tangents, places, indices


def write_glb(path, kind, repeat, images, roughness, metalness):
    """`images` contains the bytes and the MIME type for each of the uses "normal" and "orm"."""
    blob, views, accessors = bytearray(), [], []

    def view(data):
        blob.extend(b"\0" * (-len(blob) % 4))
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        blob.extend(data)
        return len(views) - 1

    *attributes, indices = grid(kind, repeat)
    for values in attributes:
        accessors.append({"bufferView": view(values.astype("<f4").tobytes()), "componentType": 5126,
                          "count": len(values), "type": f"VEC{values.shape[1]}"})
    accessors[0].update(min=attributes[0].min(0).tolist(), max=attributes[0].max(0).tolist())
    accessors.append({"bufferView": view(indices.astype("<u4").tobytes()), "componentType": 5125,
                      "count": len(indices), "type": "SCALAR"})
    surface = {"baseColorFactor": [0.5, 0.5, 0.5, 1], "roughnessFactor": roughness, "metallicFactor": metalness}
    material, model = {"pbrMetallicRoughness": surface}, {"images": [], "textures": []}
    for number, (use, (data, mime)) in enumerate(images.items()):
        model["images"].append({"bufferView": view(data), "mimeType": mime})
        is_ktx2 = mime == KTX2
        source = {"extensions": {"KHR_texture_basisu": {"source": number}}} if is_ktx2 else {"source": number}
        model["textures"].append({"sampler": 0, **source})
        if is_ktx2:
            model["extensionsUsed"] = model["extensionsRequired"] = ["KHR_texture_basisu"]
        if use == "normal":
            material["normalTexture"] = {"index": number}
        else:
            surface["metallicRoughnessTexture"] = {"index": number}
    primitive = {"attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2, "TEXCOORD_0": 3}, "indices": 4, "material": 0}
    model.update(asset={"version": "2.0"}, scene=0, scenes=[{"nodes": [0]}], nodes=[{"mesh": 0}],
                 meshes=[{"primitives": [primitive]}], samplers=[{"magFilter": 9729, "minFilter": 9987}],
                 materials=[material], accessors=accessors, bufferViews=views, buffers=[{"byteLength": len(blob)}])
    text = json.dumps(model).encode()
    text, blob = text + b" " * (-len(text) % 4), blob + b"\0" * (-len(blob) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(blob), b"BIN\0") + blob
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def export(multum, path, folder, form, roughness, metalness, size):
    """Returns the textures of an export and its report."""
    options = []
    if metalness:
        white = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(*size, 1, "uint8"))
        OpenImageIO.ImageBufAlgo.fill(white, (1.0,))
        white.write(str(folder / "white.png"))
        options = ["--metalness", folder / "white.png"]
    model_views.run(multum, "export", path, "-o", folder / f"{form}.ktx2", "--quiet", "--no-measure", "--form", form,
                    "--base-roughness", roughness, "--report", folder / "report.json", *options)
    images = {use: ((folder / f"{form}_{use}.ktx2").read_bytes(), KTX2) for use in ("normal", "orm")}
    return images, json.loads((folder / "report.json").read_text())


def errors_of(arguments, path, roughness, metalness):
    """Returns the errors of all views by row, and the errors that `multum export` predicted for three rows."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        multum = arguments.bin / "multum"
        model_views.run(multum, "export", path, "-o", folder / "png", "--quiet", "--no-measure")
        level_0 = {"normal": ((folder / "png/normal_00.png").read_bytes(), "image/png")}
        spec = OpenImageIO.ImageInput.open(str(folder / "png/normal_00.png")).spec()
        one, _ = export(multum, path, folder, "one-lobe", roughness, metalness, (spec.width, spec.height))
        auto, report = export(multum, path, folder, "auto", roughness, metalness, (spec.width, spec.height))
        rows = []
        pixel = 2 * math.tan(math.radians(ANGLE / 2)) / SIDE  # size of a pixel at distance 1
        for kind, directions in DIRECTIONS.items():
            unit = spec.width / (2 if kind == "plane" else math.pi)  # texels per unit, for a map that is not repeated
            for texels in TEXELS:
                repeat = max(1, round(texels / (pixel * DISTANCE * unit)))
                for file, images, factor in (("plain", level_0, roughness), ("one", one, 1.0), ("auto", auto, 1.0)):
                    write_glb(folder / f"{file}.glb", kind, repeat, images, factor, metalness)
                view = {**model_views.VIEW, "width": SIDE, "height": SIDE, "samples": 8, "angle": ANGLE,
                        "distance": texels / (pixel * repeat * unit)}
                models = [{"file": "plain.glb"}, {"file": "one.glb"}, {"file": "auto.glb"},
                          {"file": "plain.glb", "points": 4}, {"file": "one.glb", "points": 4}]
                plan = {"models": models, "strips": False,
                        "views": [{**view, "name": str(i), "direction": way} for i, way in enumerate(directions)]}
                drawn = model_views.draw(arguments.package, plan, folder)
                rows += [[100 * model["error"] for model in one_view["models"]] for one_view in drawn.values()]
    said = report["forms"][0]["errors"]
    return numpy.array(rows), [sum(said[key]) / len(said[key]) for key in ("plain", "one_lobe", "chosen")]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("maps", nargs="+", type=pathlib.Path)
    parser.add_argument("--bin", default="build/release/bin", type=pathlib.Path)
    parser.add_argument("--package", required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    print("| map and material | plain | one lobe | auto | plain, 4 points | one lobe, 4 points | as auto saw it |")
    print("|---|---|---|---|---|---|---|")
    for path in arguments.maps:
        for name, roughness, metalness in MATERIALS:
            rows, said = errors_of(arguments, path, roughness, metalness)
            print(f"| `{path.stem}`, {name} | " + " | ".join(f"{mean:.1f}" for mean in rows.mean(0)) + " | "
                  + " / ".join(f"{mean:.1f}" for mean in said) + " |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
