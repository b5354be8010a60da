#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/evidence/GLTF_MODELS.md. three.js draws models and bumpy surfaces with every method of multum and with an
equal number of evaluations of light per pixel.

    tools/lab/model_table.py BIN_FOLDER MODELS OUT --cache FOLDER [--package FOLDER] [--only NAME...] [--rows NAME...]
        [--distances METRES...] [--gltf=OPTIONS]

MODELS is a folder with the files of tools/lab/models.json, which lists their sources. OUT is written again after each
model. The cache contains converted models, references and errors, so only changed parts are drawn again. With --only
and --rows, the document contains only the chosen models and rows. --package draws with another @multum/three, but
BIN_FOLDER still converts the models. Needs Node.js, Chromium and the packages of tests/service/web.
"""
import argparse
import hashlib
import json
import pathlib
import shlex
import sys
import tempfile

import model_table_text
from model_views import DISTANCES, MODULES, ROOT, VIEW, digest, draw, dress, fail, link_model, run

LIST = ROOT / "tools" / "lab" / "models.json"
SURFACES = ROOT / "tests" / "three" / "bumpy_models.mjs"
SURFACE_TEXELS = 1024
SURFACE_REACH = 1.2  # half of the diagonal in metres, as for most listed models
DRAWING = 1  # version of tests/three/model_page.js; increase it if the pictures change
GRIDS = 2  # the largest number of grids of 12 x 12 samples per pixel; parts of the picture can have more
COUNTS = (1, 4, 8, 16)  # numbers of evaluations per pixel
# Rows by name. `dressed` contains options of `multum gltf`, or is None for the original model. Other keys belong to
# model_page.js.
ROWS = {"plain mips": {"dressed": None}}
ROWS |= {f"points, {n}": {"dressed": None, "points": n} for n in COUNTS}
ROWS |= {"one lobe": {"dressed": ["--lobes"]}}
ROWS |= {f"one lobe and points, {n}": {"dressed": ["--lobes"], "points": n} for n in COUNTS}
for ROW_NAME, SPEND in (("lobes", "lobes"), ("rule", "auto")):
    ROWS |= {f"{ROW_NAME}, {n}": {"dressed": ["--lobes"], "lobes": True, "options": {"evaluations": n, "spend": SPEND}}
             for n in COUNTS}
ROWS_AT_ONCE = 6  # number of rows that a browser draws before the results are stored
# Files of the package on which a row depends.
POINT_SCRIPTS = ("lobe_material.js", "shading_points.js")


def key_of(*parts):
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]


class Cache:
    """Keeps earlier results by the hash of their inputs."""

    def __init__(self, folder, programs, package=None):
        self.folder = folder
        for name in ("dressed", "references", "rows", "surfaces"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        self.multum = programs / "multum"
        self.multum_digest = digest(self.multum)
        if package is None:
            run(self.multum, "shaders", "-o", folder / "shaders")
        self.package = package.resolve() if package else folder / "shaders" / "three"
        self.scripts = {one.name: digest(one) for one in sorted(self.package.glob("*.js"))}

    def surfaces(self):
        """Lists the bumpy surfaces, in the form of models.json."""
        names = run("node", SURFACES, self.folder / "surfaces", SURFACE_TEXELS).split()
        return [{"name": name.removesuffix(".glb"), "path": self.folder / "surfaces" / name, "reach": SURFACE_REACH,
                 "surface": True} for name in names if "_" in name]

    def dressed(self, model, options):
        """Returns the model after `multum gltf`, and its report."""
        key = key_of(digest(model), self.multum_digest, options)
        out, report = (self.folder / "dressed" / f"{key}.{kind}" for kind in ("glb", "json"))
        if not report.exists():
            part = report.with_suffix(".part")
            dress(self.multum, model, out, part, *options)
            part.rename(report)
        return out, json.loads(report.read_text(encoding="utf-8"))

    def row_file(self, file, row, view, reach):
        """Names the file that keeps the errors of a row."""
        names = self.scripts if row.get("lobes") else POINT_SCRIPTS if "points" in row else ()
        scripts = [self.scripts[name] for name in names]
        ways = {name: value for name, value in row.items() if name != "dressed"}
        return self.folder / "rows" / f"{key_of(DRAWING, digest(file), ways, view, reach, scripts)}.json"

    def reference_file(self, file, view, reach):
        return self.folder / "references" / f"{key_of(DRAWING, digest(file), view, reach)}.json"


def view_from(distance):
    return {**VIEW, "distance": distance, "grids": GRIDS}


def file_of(cache, entry, row):
    """Names the file that the row draws: the original or the converted model."""
    return entry["path"] if row["dressed"] is None else cache.dressed(entry["path"], row["dressed"])[0]


def measure(cache, entry, rows, distances):
    """Returns { reports, views: by distance { rows, floor, noise, grids } } of one model."""
    source, reach = entry["path"], entry.get("reach")
    files = {name: file_of(cache, entry, row) for name, row in rows.items()}
    reports = {" ".join(row["dressed"]): cache.dressed(source, row["dressed"])[1] for row in rows.values()
               if row["dressed"] is not None}
    wanted = {}  # rows to draw, grouped by the distances for which they have no result
    for name, row in rows.items():
        lacking = tuple(one for one in distances if not
                        cache.row_file(files[name], row, view_from(one), reach).exists())
        if lacking:
            wanted.setdefault(lacking, []).append(name)
    unseen = tuple(one for one in distances if not cache.reference_file(source, view_from(one), reach).exists())
    if unseen:
        wanted.setdefault(unseen, [])
    for lacking, names in wanted.items():
        for first in range(0, max(1, len(names)), ROWS_AT_ONCE):
            part = names[first:first + ROWS_AT_ONCE]
            draw_rows(cache, entry, {name: rows[name] for name in part}, lacking)
    views = {}
    for one in distances:
        kept = json.loads(cache.reference_file(source, view_from(one), reach).read_text(encoding="utf-8"))
        views[one] = {**{key: kept[key] for key in ("floor", "noise", "grids")}, "rows": {
            name: json.loads(cache.row_file(files[name], row, view_from(one), reach).read_text(encoding="utf-8"))
            for name, row in rows.items()}}
    return {"reports": reports, "views": views}


def with_options(row, options):
    """Adds options of `multum gltf` to the row."""
    return row if row["dressed"] is None else {**row, "dressed": row["dressed"] + options}


def link_rows(cache, entry, rows, folder):
    """Links the files that `rows` draw into `folder`, and returns the rows for model_page.js."""
    link_model(entry["path"], folder)
    models = []
    for row in rows.values():
        file = file_of(cache, entry, row)
        if row["dressed"] is not None:
            (folder / file.name).unlink(missing_ok=True)
            (folder / file.name).symlink_to(file.resolve())
        models.append({**{key: value for key, value in row.items() if key != "dressed"}, "file": file.name})
    return models


def draw_rows(cache, entry, rows, distances):
    """Draws rows and puts them into the cache."""
    source, reach = entry["path"], entry.get("reach")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        models = link_rows(cache, entry, rows, folder)
        plan = {"reference": source.name, "models": models, "strips": False,
                "views": [{**view_from(one), "name": str(one)} for one in distances],
                "keep": {str(one): str(cache.reference_file(source, view_from(one), reach)) for one in distances}}
        if reach is not None:
            plan["reach"] = reach
        drawn = draw(cache.package, plan, folder)
    for one in distances:
        for row, found in zip(rows.values(), drawn[str(one)]["models"]):
            file = cache.row_file(file_of(cache, entry, row), row, view_from(one), reach)
            file.write_text(json.dumps(found), encoding="utf-8")


def listed(folder, cache, only):
    """Returns the entries to measure and the names of the others. Ends the program if a listed file has another
    hash."""
    entries = json.loads(LIST.read_text(encoding="utf-8"))
    for entry in entries:
        entry["path"] = folder / entry["file"]
    entries += cache.surfaces()
    names = [entry["name"] for entry in entries]
    if only:
        unknown = set(only) - set(names)
        if unknown:
            fail(f"--only: found {', '.join(sorted(unknown))}, expected names of {LIST.name} or of surfaces")
        entries = sorted((entry for entry in entries if entry["name"] in only),
                         key=lambda entry: only.index(entry["name"]))
    for entry in entries:
        if not entry["path"].exists():
            fail(f"found no {entry['path']}, expected {entry['source']}")
        if "sha256" in entry and digest(entry["path"]) != entry["sha256"]:
            fail(f"{entry['path']}: found SHA-256 {digest(entry['path'])}..., expected {entry['sha256']}")
    return entries, [name for name in names if only and name not in only]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("models", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--cache", type=pathlib.Path, required=True)
    parser.add_argument("--package", type=pathlib.Path, help="folder of @multum/three, which is used instead of the "
                                                             "package from BIN_FOLDER")
    parser.add_argument("--gltf", default="", metavar="OPTIONS", help="more options of `multum gltf`, as one argument")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME")
    parser.add_argument("--rows", nargs="+", default=list(ROWS), choices=ROWS, metavar="NAME")
    parser.add_argument("--distances", nargs="+", type=float, default=DISTANCES, metavar="METRES")
    options = parser.parse_args()
    if not MODULES.exists():
        fail(f"found no {MODULES}: tools/install_dependencies test installs it")
    cache = Cache(options.cache.resolve(), options.programs, options.package)
    rows = {name: with_options(ROWS[name], shlex.split(options.gltf)) for name in ROWS if name in options.rows}
    distances = [int(one) if float(one).is_integer() else one for one in options.distances]
    found = []
    entries, others = listed(options.models, cache, options.only)
    for number, entry in enumerate(entries):
        print(entry["name"], file=sys.stderr, flush=True)
        found.append((entry, measure(cache, entry, rows, distances)))
        lacking = [one["name"] for one in entries[number + 1:]] + others
        options.out.write_text(model_table_text.document(found, list(rows), COUNTS, VIEW, lacking), encoding="utf-8")


if __name__ == "__main__":
    main()
