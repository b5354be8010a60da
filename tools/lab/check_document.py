#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/evidence/VERDICTS.md, or with --models a page about models. Compares the verdicts of `multum check` with
pictures that three.js draws, with plain mips, with `multum export` (of a model: `multum gltf`), and with lobes.

    tools/lab/check_document.py BIN_FOLDER FOLDER OUT --sky FILE.exr --cache CACHE [--only NAME...] [--metal | --models]

FOLDER has normal maps, or with --models the files of tools/lab/models.json. The cache contains the errors of pictures,
so only new maps are drawn. OUT is written at the end, unless --only chooses some maps. Needs Node.js, Chromium and the
packages of tests/service/web.
"""
import argparse
import itertools
import json
import math
import pathlib
import shutil
import struct
import tempfile

import committed_tree
from model_views import ROOT, draw, fail, files_of, run
from target_table import is_normal_map

# By distance in metres: side of the picture, which shows the middle of a sphere, samples per side of a pixel, and the
# radius of the sphere in metres. All spheres of a model have the same material.
DISTANCES = {2: (244, 3, 0.25), 5: (195, 6, 0.5), 25: (118, 12, 1.5)}
APART = 100  # metres between spheres
ROUGHNESS = (0.1, 0.3, 0.6)
LIGHTS = {"sun": {"intensity": 3.0, "room": 0.3}, "sky": {"intensity": 0.0, "room": 1.0}}
FORMS = ("plain", "export", "lobes")
ROWS, ANGLE = 1080, 45
LIST = ROOT / "tools" / "lab" / "models.json"
MODEL_SIDE, MODEL_SAMPLES = 200, {2: 6, 5: 6, 25: 12}
TILE = 0.25 * math.pi  # metres, so that whole numbers of tiles surround every sphere
MATERIALS = {False: "The material is grey and not a metal.", True: "The material is a grey metal."}
POINTS = 1.0  # differences up to this number of percentage points count as equal


def spheres():
    """Returns positions, normals, texture coordinates and indices of all spheres."""
    columns, rows = 192, 96
    positions, normals, uvs, indices = [], [], [], []
    for number, (_, _, radius) in enumerate(DISTANCES.values()):
        first, repeat = len(positions) // 3, round(2 * math.pi * radius / TILE)
        for row in range(rows + 1):
            for column in range(columns + 1):
                turn, rise = 2 * math.pi * column / columns, math.pi * (row / rows - 0.5)
                normal = (math.cos(rise) * math.sin(turn), math.sin(rise), math.cos(rise) * math.cos(turn))
                normals += normal
                positions += [radius * normal[0] + number * APART, radius * normal[1], radius * normal[2]]
                uvs += [repeat * column / columns, repeat / 2 * (1 - row / rows)]
        for row in range(rows):
            for column in range(columns):
                corner = first + row * (columns + 1) + column
                above = corner + columns + 1
                indices += [corner, corner + 1, above + 1, corner, above + 1, above]
    return positions, normals, uvs, indices


def write_glb(path, roughness, metal, images):
    """Writes the spheres. `images` has the bytes of its normal map, or of its normal and ORM maps, as PNG or KTX2."""
    positions, normals, uvs, indices = spheres()
    parts = [struct.pack(f"<{len(one)}f", *one) for one in (positions, normals, uvs)]
    parts += [struct.pack(f"<{len(indices)}I", *indices)] + [one + b"\0" * (-len(one) % 4) for one in images]
    buffer_views, offset = [], 0
    for part in parts:
        buffer_views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(part)})
        offset += len(part)
    count = len(positions) // 3
    accessors = [{"bufferView": i, "componentType": 5126, "count": count, "type": kind}
                 for i, kind in enumerate(("VEC3", "VEC3", "VEC2"))]
    accessors[0] |= {"min": [min(positions[i::3]) for i in range(3)], "max": [max(positions[i::3]) for i in range(3)]}
    accessors.append({"bufferView": 3, "componentType": 5125, "count": len(indices), "type": "SCALAR"})
    surface = {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 1 if metal else 0, "roughnessFactor": roughness}
    model = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3,
                                         "material": 0}]}],
             "materials": [{"normalTexture": {"index": 0}, "pbrMetallicRoughness": surface}],
             "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}],
             "accessors": accessors, "bufferViews": buffer_views, "buffers": [{"byteLength": offset}]}
    is_ktx2 = images[0].startswith(b"\xabKTX")
    model["images"] = [{"bufferView": 4 + i, "mimeType": "image/ktx2" if is_ktx2 else "image/png"}
                       for i in range(len(images))]
    model["textures"] = [{"sampler": 0, "extensions": {"KHR_texture_basisu": {"source": i}}} if is_ktx2
                         else {"sampler": 0, "source": i} for i in range(len(images))]
    if is_ktx2:
        model["extensionsUsed"] = model["extensionsRequired"] = ["KHR_texture_basisu"]
    if len(images) > 1:
        surface |= {"roughnessFactor": 1, "metallicRoughnessTexture": {"index": 1}}
    text = json.dumps(model).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", offset, b"BIN\0") + b"".join(parts)
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)


def views():
    direction = (0.28, 0.1, 0.955)
    for number, (distance, (side, samples, _)) in enumerate(DISTANCES.items()):
        angle = 2 * math.degrees(math.atan(math.tan(math.radians(ANGLE / 2)) * side / ROWS))
        target = [number * APART, 0, 0]
        eye = [at + distance * step for at, step in zip(target, direction)]
        for light, lit in LIGHTS.items():
            yield {"name": f"{distance}_{light}", "eye": eye, "target": target, "angle": angle, "width": side,
                   "height": side, "samples": samples, "frames": 1, "edges": 4, "crop": [0, 0, side, side], "zoom": 1,
                   "light": [1.0, 1.0, 0.6], **lit}


def model_views():
    for distance, samples in MODEL_SAMPLES.items():
        angle = 2 * math.degrees(math.atan(math.tan(math.radians(ANGLE / 2)) * MODEL_SIDE / ROWS))
        for light, lit in LIGHTS.items():
            yield {"name": f"{distance}_{light}", "direction": [0.28, 0.1, 0.955], "distance": distance, "angle": angle,
                   "width": MODEL_SIDE, "height": MODEL_SIDE, "samples": samples, "frames": 1, "edges": 4,
                   "light": [1.0, 1.0, 0.6], **lit}


def errors_of(package, folder, models, asked):
    """Returns errors in percent by view, in the order of FORMS."""
    plan = {"models": [{"file": models[0]}, {"file": models[1]},
                       {"file": models[2], "lobes": True, "options": {"evaluations": 4}}],
            "views": list(asked), "strips": False, "surroundings": "sky.exr"}
    # A picture from inside a model can be black, and then has no relative error.
    return {name: [100 * one["error"] for one in view["models"]]
            for name, view in draw(package, plan, folder).items() if view["models"][0]["error"] is not None}


def drawn_errors(multum, package, path, metal, folder):
    """Returns errors in percent by roughness, view and form."""
    run(multum, "export", path, "-o", folder / "level", "--no-measure")
    image = (folder / "level" / "normal_00.png").read_bytes()
    found = {}
    for roughness in ROUGHNESS:
        write_glb(folder / "plain.glb", roughness, metal, [image])
        run(multum, "export", path, "-o", folder / "map.ktx2", "--form", "auto", "--base-roughness", roughness,
            "--no-measure")
        write_glb(folder / "export.glb", roughness, metal,
                  [(folder / f"map_{kind}.ktx2").read_bytes() for kind in ("normal", "orm")])
        run(multum, "gltf", folder / "plain.glb", "-o", folder / "lobes.glb", "--format", "rgba8", "--form", "one-lobe",
            "--lobes")
        found[str(roughness)] = errors_of(package, folder, ["plain.glb", "export.glb", "lobes.glb"], views())
    return found


def model_errors(multum, package, path, folder):
    """Returns errors of a model with its own roughness, as drawn_errors() does."""
    for name, options in (("export", []), ("lobes", ["--form", "one-lobe", "--lobes"])):
        run(multum, "gltf", path, "-o", folder / f"{name}.glb", "--format", "rgba8", *options)
    return {"None": errors_of(package, folder, [path.name, "export.glb", "lobes.glb"], model_views())}


def node_matrix(node):
    """Returns the rows of the 3 x 4 matrix of a glTF node."""
    if "matrix" in node:
        return [[node["matrix"][4 * column + row] for column in range(4)] for row in range(3)]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    turned = ((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
              (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
              (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))
    scale, moved = node.get("scale", (1, 1, 1)), node.get("translation", (0, 0, 0))
    return [[turned[row][column] * scale[column] for column in range(3)] + [moved[row]] for row in range(3)]


def transformed(matrix, point):
    return [sum(row[i] * point[i] for i in range(3)) + row[3] for row in matrix]


def half_diagonal(model):
    """Returns half of the diagonal of the box around a glTF model, from the boxes of its meshes."""
    def corners(node):
        points = [corner for child in node.get("children", []) for corner in corners(model["nodes"][child])]
        if "mesh" in node:
            for primitive in model["meshes"][node["mesh"]]["primitives"]:
                accessor = model["accessors"][primitive["attributes"]["POSITION"]]
                points += itertools.product(*zip(accessor["min"], accessor["max"]))
        return [transformed(node_matrix(node), point) for point in points]

    scene = model["scenes"][model.get("scene", 0)]
    points = [point for root in scene["nodes"] for point in corners(model["nodes"][root])]
    return 0.5 * math.dist(*([limit(axis) for axis in zip(*points)] for limit in (min, max)))


def scaled_model(path, reach, folder):
    """Writes the model into `folder`, scaled so that half of its diagonal is `reach` metres, or unchanged without
    `reach`. Returns its path."""
    for name in files_of(path):  # copies, because multum follows no links that leave a model's folder
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path.parent / name, folder / name)
    if reach is None:
        return folder / path.name
    data, is_glb = path.read_bytes(), path.suffix == ".glb"
    length = struct.unpack_from("<I", data, 12)[0] if is_glb else 0
    model = json.loads(data[20:20 + length] if is_glb else data)
    scene, scale = model["scenes"][model.get("scene", 0)], reach / half_diagonal(model)
    model["nodes"].append({"children": scene["nodes"], "scale": [scale] * 3})
    scene["nodes"] = [len(model["nodes"]) - 1]
    text = json.dumps(model).encode()
    if is_glb:
        text += b" " * (-len(text) % 4)
        rest = data[20 + length:]
        text = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON") + text + rest
    (folder / path.name).write_bytes(text)
    return folder / path.name


def measured(given, package, entry):
    """Returns the errors of pictures of a map or model, and what `multum check` says about its maps."""
    multum, path = given.programs / "multum", given.folder / entry["file"]
    kept = given.cache / f"{path.name}{'_metal' if given.metal else ''}.json"
    with tempfile.TemporaryDirectory(dir=given.cache) as name:
        folder = pathlib.Path(name)
        if given.models:
            path = scaled_model(path, entry.get("reach"), folder)
        if not kept.exists():
            (folder / "sky.exr").symlink_to(given.sky.resolve())
            errors = (model_errors(multum, package, path, folder) if given.models
                      else drawn_errors(multum, package, path, given.metal, folder))
            kept.write_text(json.dumps(errors), encoding="utf-8")
        options = [] if given.models else ["--tile-size", TILE] + (["--metal"] if given.metal else [])
        said = json.loads(run(multum, "check", path, "--json", *options))["maps"]
    return json.loads(kept.read_text(encoding="utf-8")), [one for one in said if "errors" in one]


def orders(drawn, said):
    """Yields (roughness, distance, light, errors of pictures, errors of the verdict). The verdict of a model is the
    mean of its materials, whose own roughness is called None."""
    for roughness, by_view in drawn.items():
        for view, errors in by_view.items():
            distance, light = view.split("_")
            told = [[error[form] for form in FORMS] for one in said for error in one["errors"]
                    if (error["distance"], error["light"]) == (float(distance), light)
                    and roughness in ("None", str(error["roughness"]))]
            if told:
                yield roughness, distance, light, errors, [sum(values) / len(values) for values in zip(*told)]


def wrong_orders(drawn, said):
    """Lists pairs of forms that differ by more than POINTS in a picture and whose order the verdict reverses."""
    wrong, pairs = [], 0
    for roughness, distance, light, errors, told in orders(drawn, said):
        for a in range(3):
            for b in range(a + 1, 3):
                if abs(errors[a] - errors[b]) <= POINTS:
                    continue
                pairs += 1
                if (errors[a] - errors[b]) * (told[a] - told[b]) <= 0:
                    wrong.append((roughness, distance, light, FORMS[a], FORMS[b], errors[a], errors[b], told[a],
                                  told[b]))
    return wrong, pairs


def mean_text(drawn, said, distance="5"):
    """Returns the mean errors under sun and sky of pictures and of the verdict, at roughness 0.3 or the model's own."""
    rows = [(errors, told) for roughness, at, _, errors, told in orders(drawn, said)
            if at == distance and roughness in ("0.3", "None")]
    if not rows:
        return ["-", "-"]
    return [" / ".join(f"{sum(row[which][form] for row in rows) / len(rows):.1f}" for form in range(3))
            for which in (0, 1)]


def table(entries):
    lines = ["| file | pictures, % | verdict, % | pairs | wrong | advice |", "|---|---|---|---|---|---|"]
    for name, drawn, said in entries:
        wrong, pairs = wrong_orders(drawn, said)
        shown = " ".join(f"{a}/{b} at {distance} m, {roughness if roughness != 'None' else 'own'}, {light}: "
                         f"{one:.1f}/{other:.1f}, verdict {told_one:.1f}/{told_other:.1f}."
                         for roughness, distance, light, a, b, one, other, told_one, told_other in wrong)
        advice = ", ".join(sorted({one["advice"] for one in said}))
        lines.append("| " + " | ".join([name, *mean_text(drawn, said), str(pairs), shown or "-", advice]) + " |")
    return "\n".join(lines)


HEAD = """Generated by `tools/lab/check_document.py{option}` ({commit}). Do not edit.
"""
PAIRS = f"""A *pair* consists of two forms whose errors differ by more than {POINTS:g} percentage point in a picture. It
is *wrong* if the verdict has the opposite order."""


def counts_of(results):
    """Returns the number of files without a wrong pair, of wrong pairs, and of pairs."""
    counts = [wrong_orders(drawn, said) for _, drawn, said in results]
    return (sum(not found for found, _ in counts), sum(len(found) for found, _ in counts),
            sum(count for _, count in counts))


def map_document(maps, given):
    right, wrong, pairs = counts_of(maps)
    head = HEAD.format(option=" --metal" if given.metal else "", commit=committed_tree.stated_commit(given.allow_dirty))
    return f"""# Verdicts

This page compares the verdicts of `multum check` with pictures that three.js draws.

{head}
For each map, three.js drew a sphere in Chromium from 2, 5 and 25 m, with roughness 0.1, 0.3 and 0.6. *Sun* is a
directional light with a dim sky, and *sky* is {given.sky.name} without another light.
{MATERIALS[given.metal]} A tile of the map covers {TILE:.2f} m. The spheres have radii of 0.25, 0.5 and 1.5 m, and the
pictures show their middle. The reference averages 9, 36 or 144 samples per pixel. *Plain* has the map's own mips,
*export* the textures of `multum export --form auto`, and *lobes* are drawn by @multum/three with 4 evaluations per
pixel.

{PAIRS} The columns with per cent list plain / export / lobes at 5 m and roughness 0.3,
as the mean of sun and sky.

On {right} of {len(maps)} maps, no pair is wrong. In total, {wrong} of {pairs} pairs are wrong.

{table(maps)}
"""


def model_document(models, given):
    right, wrong, pairs = counts_of(models)
    head = HEAD.format(option=" --models", commit=committed_tree.stated_commit(given.allow_dirty))
    return f"""# Verdicts about models

This page compares the verdicts of `multum check` about models with pictures that three.js draws.

{head}
The models are all of `tools/lab/models.json`, which lists their sources and licences. three.js drew each model in
Chromium from 2, 5 and 25 m, with its own materials. *Sun* is a directional light with a dim sky, and *sky* is
{given.sky.name} without another light. Models without a meaningful size are scaled so that half of their diagonal is
1.2 m long. The pictures show the whole model with {MODEL_SIDE} x {MODEL_SIDE} pixels or fewer. The reference averages
36 or 144 samples per pixel. *Plain* is the original model, *export* is the model after `multum gltf`, and *lobes* are
drawn by @multum/three with 4 evaluations per pixel. `multum check` shades
pixels of the model's own triangles, but reads each pixel's normals at a random place of the map. The verdict is the
mean of the materials that have a normal map. In pictures, parts without a normal map lower the relative error, and
edges raise it.

{PAIRS} The columns with per cent list plain / export / lobes at 5 m, as the mean of sun and sky. A picture from inside
a model can be black, and is then left out.

On {right} of {len(models)} models, no pair is wrong. In total, {wrong} of {pairs} pairs are wrong.

{table(models)}
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path, help="maps, or the models of tools/lab/models.json")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--cache", type=pathlib.Path, required=True)
    parser.add_argument("--sky", type=pathlib.Path, required=True, help="EXR picture of the surroundings")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="draw only these, and do not write the page")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--metal", action="store_true", help="draw the maps on a metal")
    kind.add_argument("--models", action="store_true", help="draw models")
    committed_tree.add_option(parser)
    given = parser.parse_args()
    given.cache.mkdir(parents=True, exist_ok=True)
    package = given.cache / "shaders" / "three"
    run(given.programs / "multum", "shaders", "-o", given.cache / "shaders")
    if given.models:
        entries = json.loads(LIST.read_text(encoding="utf-8"))
    else:
        paths = sorted(given.folder.iterdir())
        entries = [{"name": path.name, "file": path.name} for path in paths if is_normal_map(path)]
    if unknown := sorted(set(given.only or []) - {entry["name"] for entry in entries}):
        fail(f"--only: found no {', '.join(unknown)} among {given.folder}'s maps or the listed models")
    results = []
    for entry in entries:
        if given.only and entry["name"] not in given.only:
            continue
        drawn, said = measured(given, package, entry)
        wrong, pairs = wrong_orders(drawn, said)
        print(entry["name"], f"{len(wrong)} of {pairs} wrong", flush=True)
        results.append((entry["name"], drawn, said))
    if not given.only:
        write = model_document if given.models else map_document
        given.out.write_text(write(results, given), encoding="utf-8")


if __name__ == "__main__":
    main()
