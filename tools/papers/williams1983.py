# SPDX-License-Identifier: Apache-2.0
"""Williams 1983, "Pyramidal Parametrics": filtered magnification and compression, highlights, levels of detail."""
import json
import math

import numpy as np
import OpenImageIO as oiio
from report_page import percent
from study import write_picture

TITLE = "Williams 1983: pyramidal parametrics"


def sheet(study, name, caption, *options):
    """One run of multum-view that writes a sheet; returns the rows of its report."""
    study.run("multum-view", *options, "-o", study.path(f"{name}.png"), "--report", study.path(f"{name}.view.json"))
    study.picture_files([(f"{name}.png", caption)], name != "colours")
    loaded = json.loads(study.path(f"{name}.view.json").read_text())
    study.contexts.add(loaded["context"])
    study.versions.add(loaded["software"].split()[-1])
    return loaded["pictures"]


def colours(study):
    study.heading("Magnification and compression")
    study.paragraph("A picture on a plane that runs to the horizon: magnified near by, compressed far off. Sampled",
                    "at the nearest texel it breaks into blocks and into noise; the pyramid is smooth in both.")
    study.testmap("picture")
    study.run("multum", "mip", study.path("picture_albedo.png"), "-o", study.path("picture.exr"))
    rows = sheet(study, "colours", "the truth and three ways to look up", "pyramid", study.path("picture.exr"),
                 "--lookup", "truth,nearest,level,driver", "--size", "400x300", "--samples", str(study.samples))
    study.table(["lookup", "relative L1"],
                [[row["name"], percent(row["relative_l1"])] for row in rows if "relative_l1" in row])


def bumpy_ball(path, steps=192, bumps=0.05):
    """A ball with bumps all over, as OBJ: curvature that no pixel of a small picture resolves."""
    def point(i, j):
        polar, azimuth = math.pi * i / steps, 2 * math.pi * j / steps
        radius = 1 + bumps * math.sin(9 * polar) * math.sin(9 * azimuth) * math.sin(polar)
        return np.array([math.sin(polar) * math.cos(azimuth), math.sin(polar) * math.sin(azimuth),
                         math.cos(polar)]) * radius
    lines = []
    for i in range(steps + 1):
        for j in range(steps + 1):
            x, y, z = point(i, j)
            lines += [f"v {x:.6f} {y:.6f} {z:.6f}", f"vt {j / steps:.6f} {1 - i / steps:.6f}"]
    for i in range(steps):
        for j in range(steps):
            k = i * (steps + 1) + j + 1
            corners = [k, k + steps + 1, k + steps + 2, k + 1]
            faces = [corners[:3]] * (i < steps - 1) + [[corners[0], *corners[2:]]] * (i > 0)
            lines += ["f " + " ".join(f"{c}/{c}" for c in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def highlights(study):
    study.heading("Highlights")
    study.paragraph("Light and highlights as a map over the normal. Where the surface turns far within a pixel, the",
                    "finest level hits or misses the highlight; the level that the curvature calls for averages it.",
                    "Flicker: the mean change of the error as the picture moves by parts of a pixel.")
    lights = [option for direction in ("0.3,0.8,0.5", "-1,0.2,0.4,2", "0.6,-0.5,0.7", "-0.3,-0.2,1")
              for option in ("--light", direction)]
    study.run("multum", "reflectance", "-o", study.path("lights.exr"), "--brdf", "blinn-phong:300", *lights)
    ball = bumpy_ball(study.path("ball.obj"))
    found = []
    for size in ("28x28", "56x56"):
        rows = sheet(study, f"highlights_{size}", f"{size} pixels: the truth, the finest level, the curvature's level",
                     "pyramid", study.path("lights.exr"), "--mesh", ball, "--lookup", "truth,bilinear,level",
                     "--shifts", "8", "--size", size, "--samples", str(min(study.samples, 64)))
        found += [[size, row["name"], percent(row["relative_l1"]), f"{row['flicker']:.3f}"]
                  for row in rows if "relative_l1" in row]
    study.table(["pixels", "lookup", "relative L1", "flicker"], found)


def levels_of_detail(study):
    study.heading("Levels of detail")
    study.paragraph("A height field's pyramid, drawn at continuous levels: fewer points, smoother hills.")
    size = 257
    y, x = np.mgrid[0:size, 0:size] / size
    heights = sum(0.5 ** k * np.sin(2 ** k * 5 * x + k) * np.cos(2 ** k * 4 * y + 2 * k) for k in range(6))
    write_picture(study.path("hills.exr"), (0.05 * heights)[:, :, None], oiio.FLOAT)
    study.run("multum", "lod", study.path("hills.exr"), "-o", study.path("lod.exr"))
    shown = []
    for level in (0, 2, 3.5, 5):
        name = f"level{str(level).replace('.', '_')}"
        study.run("multum-view", "lod", study.path("lod.exr"), "--level", str(level), "-o", study.path(f"{name}.png"),
                  "--size", "400x240")
        shown.append((f"{name}.png", f"level {level}"))
    study.picture_files(shown)


def reproduce(study):
    colours(study)
    highlights(study)
    levels_of_detail(study)
