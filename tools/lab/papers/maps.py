# SPDX-License-Identifier: Apache-2.0
"""Compares every representation on every map with other methods, in a table of picture errors and a table of frame
times.

With MULTUM_SHARED_DATA, the maps are the normal maps of its folder normal/. Otherwise multum generates them.
"""
import re

import numpy as np
from report_page import percent
from study import StepFailed, relative_l1, write_sky

TITLE = "Every representation on every map"
LIGHT = ("--light", "0.3,0.8,0.5")
SCENE = ("--size", "320x240", "--brdf", "blinn-phong:100", "--diffuse", "0.4", "--specular", "0.15", *LIGHT, "--repeat",
         "40")
REPRESENTATIONS = (("vmf, 4 lobes", "vmf", ()), ("vmf, 6 lobes", "vmf6", ("--lobes", "6")),
                   ("gmm, 4 lobes", "gmm", ("--ndf", "gmm")),
                   ("sh, order 8", "sh8", ("--ndf", "sh", "--sh-order", "8")),
                   ("sh, order 4", "sh4", ("--ndf", "sh")), ("moments", "moments", ("--ndf", "moments")))
# The last two methods are shaded at as many points per pixel as four lobes need evaluations.
BASELINES = (("Toksvig", "toksvig"), ("LEAN with the Jacobian", "lean-jacobian"), ("averaged normals", "mip"),
             ("LEAN with the Jacobian, 4 points", "lean-jacobian-points"), ("averaged normals, 4 points", "points"))
MATERIAL_RUNS = 5  # number of runs of each material
NORMAL_MAP = re.compile(r"^(pm_\d+|.*(normal|_norm|_nm?|flakes5n))\.(png|jpg|webp)$")


def maps(study):
    """Yields (name, path, options for reading the map)."""
    if study.data is not None and (study.data / "normal").is_dir():
        for path in sorted((study.data / "normal").iterdir()):
            if NORMAL_MAP.match(path.name):
                yield path.stem, path, ()
        return
    for quarter in ("armour", "rings", "grooves", "noise"):
        yield quarter, study.testmap(quarter, "--quarter", quarter, size=256), ("--green", "up")


def reading_of(study, path):
    """Returns --green up for all representations if the map's statistics do not show the direction, otherwise
    nothing."""
    try:
        study.bake("probe", path, "--ndf", "moments", "--no-measure")
        return ()
    except StepFailed as failure:
        if "--green" not in str(failure):
            raise
        return ("--green", "up")


def frame_ratio(view):
    """Divides multum's frame time by Toksvig's frame time in the same run."""
    return view.frame_ms["multum"] / view.frame_ms["toksvig"]


def draw_every_map(study):
    """Makes the tables of errors and of frame times."""
    columns, errors, ratios, milliseconds, guessed = [*REPRESENTATIONS, *BASELINES], [], [], [], []
    references = []
    for name, path, reading in maps(study):
        read = reading or reading_of(study, path)
        if read != reading:
            guessed.append(name)
        row, ratio, ms, reference = [], [], [], None
        for _, option, bake_options in REPRESENTATIONS:
            baked = f"{name}_{option}"
            study.bake(baked, path, *read, *bake_options, "--no-measure")
            first = reference is None  # the reference and the baselines are the same for all representations
            compare = ("reference", *[b for _, b in BASELINES]) if first else ("toksvig",)
            view = study.view(baked, baked, "--source", path, *SCENE, compare=compare)
            if first:
                reference, baselines = view["reference"], view
                references += [one for one in view.report["pictures"] if one["name"] == "reference"]
            row.append(relative_l1(view["multum"], reference))
            ratio.append(frame_ratio(view))
            ms.append(view.frame_ms["multum"])
        row += [relative_l1(baselines[b], reference) for _, b in BASELINES]
        ratio += [baselines.frame_ms[b] / baselines.frame_ms["toksvig"] for _, b in BASELINES]
        ms += [baselines.frame_ms[b] for _, b in BASELINES]
        errors.append((name, row))
        ratios.append(ratio)
        milliseconds.append(ms)
    labels = [one[0] for one in columns]
    study.heading("Errors")
    study.table(["map", *labels], [[name, *[(percent(e), "best" if e == min(row) else "") for e in row]]
                                   for name, row in errors] +
                [["median", *[percent(e) for e in np.median([row for _, row in errors], axis=0)]]])
    counts = [one["samples"] for one in references]
    study.paragraph(f"References have {min(counts)} to {max(counts)} samples per pixel. The noise of the references "
                    f"is at most",
                    f"{percent(max(one['noise_relative_l1'] for one in references))}.")
    if guessed:
        study.paragraph("Read with --green up, because their statistics do not show green's direction:",
                        f"{', '.join(guessed)}.")
    study.heading("Frame times")
    study.paragraph("The table lists the time per frame of 320 x 240 pixels, divided by the time of Toksvig in the "
                    "same run. Each cell contains the median over the maps, the lowest ratio and the highest ratio.")
    low, middle, high = (np.percentile(ratios, q, axis=0) for q in (0, 50, 100))
    study.table(["", *labels], [["ms", *[f"{value:.1f}" for value in np.median(milliseconds, axis=0)]],
                                ["ratio to Toksvig", *[f"{value:.2f}" for value in middle]],
                                ["lowest to highest", *[f"{a:.2f} to {b:.2f}" for a, b in zip(low, high)]]])


def draw_every_material(study):
    """Measures frame times of every BRDF and light, on one map."""
    normal = study.testmap("materials", "--quarter", "grooves", size=256)
    sky = study.path("sky.exr")
    write_sky(sky)
    kinds = [one for one in REPRESENTATIONS if one[1] != "vmf6"]
    for _, option, bake_options in kinds:
        study.bake(f"materials_{option}", normal, "--green", "up", *bake_options, "--no-measure")
    materials = [(words, ("--brdf", brdf, *LIGHT)) for words, brdf in
                 (("Lambert", "lambert"), ("Blinn-Phong, s = 100", "blinn-phong:100"),
                  ("Torrance-Sparrow, sigma 0.1", "torrance-sparrow:0.1"),
                  ("Cook-Torrance, sigma 0.1", "cook-torrance:0.1"), ("GGX, roughness 0.4", "ggx:0.4"))]
    measured = sorted((study.data / "brdf").glob("*.brdf")) if study.data is not None else []
    materials += [(f"measured, {one.stem}", ("--brdf", one, *LIGHT)) for one in measured[:1]]
    materials += [(f"Blinn-Phong, s = 12, environment by {mode}",
                   ("--brdf", "blinn-phong:12", "--environment", sky, "--environment-mode", mode))
                  for mode in ("sh", "prefiltered")]
    rows = []
    for words, options in materials:
        row = [words]
        for _, option, _ in kinds:
            try:
                # Toksvig's frame in the same run has the same BRDF and light.
                ratios = [frame_ratio(study.view("materials", f"materials_{option}", "--source", normal, "--size",
                                                 "320x240", "--repeat", "40", *options, compare=("toksvig",)))
                          for _ in range(MATERIAL_RUNS)]
                row.append(f"{np.median(ratios):.2f}")
            except StepFailed as failure:  # this representation does not support the material
                if "exit code 2" not in str(failure):
                    raise
                row.append("refused")
        rows.append(row)
    study.heading("Frame times of materials")
    study.paragraph("The table lists the time per frame of 320 x 240 pixels for the map of grooves (256 x 256 "
                    "texels). Each time is divided by the time of Toksvig's averaged normal with the same BRDF and "
                    f"light in the same run. Numbers are medians of {MATERIAL_RUNS} runs.")
    study.table(["", *[label for label, _, _ in kinds]], rows)


def draw_same_filter(study):
    """Compares errors against two references. One averages over the texels that the filter reads, the other over the
    pixel."""
    normal = study.testmap("same_filter")
    study.bake("same_filter", normal, "--green", "up", "--no-measure")
    methods = (("4 vMF lobes", "multum"), ("Toksvig", "toksvig"), ("LEAN as published", "lean"),
               ("LEAN with the Jacobian", "lean-jacobian"))
    columns = []
    for exponent in (20, 100, 500):
        for of in ("texels", "pixel"):
            view = study.view(f"same_filter_{exponent}_{of}", "same_filter", "--source", normal, "--size", "320x240",
                              "--brdf", f"blinn-phong:{exponent}", "--diffuse", "0", "--repeat", "60", *LIGHT,
                              "--reference-of", of, compare=("reference", *[name for _, name in methods[1:]]))
            columns.append((f"s = {exponent}, {'same filter' if of == 'texels' else 'pixel'}",
                            {name: relative_l1(view[name], view["reference"]) for _, name in methods}))
    study.heading("Error of the picture's filter")
    study.paragraph("The table lists errors of highlights on the four-quarter map. One reference averages over the "
                    "texels that the filter reads, and the other reference averages over the pixel. The difference "
                    "between the two errors is the error of the filter.")
    study.table(["", *[words for words, _ in columns]],
                [[label, *[percent(errors[name]) for _, errors in columns]] for label, name in methods])


def reproduce(study):
    study.samples = None  # the noise of the reference then determines the number of samples
    study.paragraph("The scene is the oblique plane under one light, with Blinn-Phong and s = 100. All pictures use "
                    "multum-view's own filter. Errors are relative L1 errors against samples of the map itself.")
    draw_every_map(study)
    draw_every_material(study)
    draw_same_filter(study)
