# SPDX-License-Identifier: Apache-2.0
"""Every representation on every map: one table of picture errors, one of frame times, beside the usual baselines.

With MULTUM_SHARED_DATA the maps are the normal maps of its folder normal/; else those that multum makes.
"""
import re

import numpy as np
from report_page import percent
from study import StepFailed

TITLE = "Every representation on every map"
SCENE = ("--size", "320x240", "--brdf", "blinn-phong:100", "--diffuse", "0.4", "--specular", "0.15", "--light",
         "0.3,0.8,0.5", "--repeat", "40")
REPRESENTATIONS = (("vmf, 4 lobes", "vmf", ()), ("vmf, 6 lobes", "vmf6", ("--lobes", "6")),
                   ("gmm, 4 lobes", "gmm", ("--ndf", "gmm")),
                   ("sh, order 8", "sh8", ("--ndf", "sh", "--sh-order", "8")),
                   ("sh, order 4", "sh4", ("--ndf", "sh")), ("moments", "moments", ("--ndf", "moments")))
BASELINES = (("Toksvig", "toksvig"), ("LEAN", "lean-jacobian"), ("averaged normals", "mip"))
NORMAL_MAP = re.compile(r"^(pm_\d+|.*(normal|_norm|_nm?|flakes5n))\.(png|jpg|webp)$")


def maps(study):
    """(name, path, options that say how to read it)."""
    if study.data is not None and (study.data / "normal").is_dir():
        for path in sorted((study.data / "normal").iterdir()):
            if NORMAL_MAP.match(path.name):
                yield path.stem, path, ()
        return
    for quarter in ("armour", "rings", "grooves", "noise"):
        yield quarter, study.testmap(quarter, "--quarter", quarter, size=256), ("--green", "up")


def reading_of(study, path):
    """Nothing, unless the map's statistics leave its green undecided: then the same for every representation."""
    try:
        study.bake("probe", path, "--ndf", "moments", "--no-measure")
        return ()
    except StepFailed as failure:
        if "--green" not in str(failure):
            raise
        return ("--green", "up")


def reproduce(study):
    study.paragraph("The oblique plane under one light, Blinn-Phong of s = 100: relative L1 of each picture against",
                    f"{study.samples} samples a pixel of the map itself.")
    errors, times, refused = [], [], []
    for name, path, reading in maps(study):
        read = reading or reading_of(study, path)
        row, milliseconds = [name], {}
        for _, option, bake_options in REPRESENTATIONS:
            study.bake(f"{name}_{option}", path, *read, *bake_options, "--no-measure")
            compare = ("truth", *[b for _, b in BASELINES]) if option == "vmf" else ("truth",)
            view = study.view(f"{name}_{option}", f"{name}_{option}", "--source", path, *SCENE, compare=compare)
            shown = {one["name"]: one for one in view.report["pictures"]}
            row.append(shown["multum"]["relative_l1"])
            milliseconds[option] = shown["multum"]["frame_time_ms"]
            if option == "vmf":
                baseline_errors = [shown[b]["relative_l1"] for _, b in BASELINES]
                milliseconds.update({b: shown[b]["frame_time_ms"] for _, b in BASELINES})
        row += baseline_errors
        if read != reading:
            refused.append(name)
        errors.append(row)
        times.append(milliseconds)
    labels = [label for label, _, _ in REPRESENTATIONS] + [label for label, _ in BASELINES]
    study.heading("Errors")
    study.table(["map", *labels], [[row[0], *[(percent(e), "best" if e == min(row[1:]) else "") for e in row[1:]]]
                                   for row in errors] +
                [["median", *[percent(float(np.median(column))) for column in list(zip(*errors))[1:]]]])
    if refused:
        study.paragraph(f"Read with --green up, which their statistics do not tell: {', '.join(refused)}.")
    study.heading("Frame times")
    keys = [option for _, option, _ in REPRESENTATIONS] + [option for _, option in BASELINES]
    medians = {key: float(np.median([one[key] for one in times])) for key in keys}
    study.paragraph("Medians over the maps of one frame of 320 x 240, and over Toksvig's of the same run.")
    study.table(["", *labels], [["ms", *[f"{medians[key]:.1f}" for key in keys]],
                                ["over Toksvig's", *[f"{medians[key] / medians['toksvig']:.2f}" for key in keys]]])
