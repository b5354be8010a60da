# SPDX-License-Identifier: Apache-2.0
"""Williams 1983, "Pyramidal Parametrics": filtered magnification and compression, highlights, limited curvature, levels
of detail and their boiling, patches."""
import json
import math

import numpy as np
import OpenImageIO as oiio
from report_page import percent
from study import REFERENCE, box_reduced, flicker, read_picture, relative_l1, srgb, write_picture

TITLE = "Williams 1983: pyramidal parametrics"


def sheet(study, name, caption, *options):
    """Runs multum-view to write a sheet, and returns the rows of its report."""
    study.run("multum-view", *options, "-o", study.path(f"{name}.png"), "--report", study.path(f"{name}.view.json"))
    study.picture_files([(f"{name}.png", caption)], name != "colours")
    loaded = json.loads(study.path(f"{name}.view.json").read_text())
    study.contexts.add(loaded["context"])
    study.versions.add(loaded["software"].split()[-1])
    return loaded["pictures"]


def colours(study):
    study.heading("Magnification and compression")
    study.paragraph("The picture is mapped onto a plane that extends to the horizon, so the picture is "
                    "magnified near the camera and compressed far away. Nearest-texel lookups show blocks near the "
                    "camera and noise "
                    "far away. The pyramid is smooth in both places.")
    study.testmap("picture")
    study.run("multum", "mip", study.path("picture_albedo.png"), "-o", study.path("picture.exr"))
    rows = sheet(study, "colours", "the reference and three ways to look up", "pyramid", study.path("picture.exr"),
                 "--lookup", f"{REFERENCE},nearest,level,driver", "--size", "400x300", "--samples", str(study.samples))
    study.table(["lookup", "relative L1"],
                [[row["name"], percent(row["relative_l1"])] for row in rows if "relative_l1" in row])


def bumpy_ball(path, steps=192, bumps=0.05):
    """Writes a ball with bumps as OBJ. The pixels of a small picture cannot resolve its curvature."""
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
    study.paragraph("Light and highlights are stored in a map that is indexed by the normal. Where the normal changes "
                    "much within a pixel, a lookup in the finest level hits or misses the highlight. A lookup "
                    "in the level that matches the curvature averages the highlight. Flicker is the mean change of "
                    "the error "
                    "while the picture moves by fractions of a pixel.")
    lights = [option for direction in ("0.3,0.8,0.5", "-1,0.2,0.4,2", "0.6,-0.5,0.7", "-0.3,-0.2,1")
              for option in ("--light", direction)]
    study.run("multum", "reflectance", "-o", study.path("lights.exr"), "--brdf", "blinn-phong:300", *lights)
    ball = bumpy_ball(study.path("ball.obj"))
    found = []
    for size in ("28x28", "56x56"):
        rows = sheet(study, f"highlights_{size}",
                     f"{size} pixels: the reference, the finest level, the curvature's level", "pyramid",
                     study.path("lights.exr"), "--mesh", ball, "--lookup", f"{REFERENCE},bilinear,level", "--shifts",
                     "8", "--size", size, "--samples", str(min(study.samples, 64)))
        found += [[size, row["name"], percent(row["relative_l1"]), f"{row['flicker']:.3f}"]
                  for row in rows if "relative_l1" in row]
    study.table(["pixels", "lookup", "relative L1", "flicker"], found)


def bumpy_positions(path, width=256, height=128, bumps=0.05):
    """Writes the ball as a grid of positions for multum lod: x, y, z over azimuth and polar angle."""
    polar = (np.arange(height) + 0.5)[:, None] / height * np.pi
    azimuth = (np.arange(width) + 0.5)[None, :] / width * 2 * np.pi
    radius = 1 + bumps * np.sin(9 * polar) * np.sin(9 * azimuth) * np.sin(polar)
    points = radius[:, :, None] * np.dstack([np.sin(polar) * np.cos(azimuth), np.cos(polar) * np.ones_like(azimuth),
                                             -np.sin(polar) * np.sin(azimuth)])
    write_picture(path, points, oiio.FLOAT)
    return path


def limited_curvature(study):
    study.heading("Curvature limited before rendering")
    study.paragraph("Before any highlight is looked up, the surface can be replaced by a coarser level of its own",
                    "pyramid, which lacks small details. If the lights have no pyramid, a level whose points are half "
                    "a pixel apart gives lower errors and less flicker than the finest level. If the lights have a "
                    "pyramid, the finest level gives lower errors than the coarser level. The coarser level "
                    "contains only a part of the spread of normals that bumps cause. If the points of the "
                    "level are one pixel apart, this spread is lost completely.")
    study.run("multum", "lod", bumpy_positions(study.path("ball_points.exr")), "-o", study.path("ball_lod.exr"), "--of",
              "positions", "--swrap", "periodic", "--twrap", "clamp")
    found, shown, size = [], [], "28x28"
    for words, name, detail in (("finest", "finest", ("--surface-level", "0")),
                                ("half a pixel", "half", ("--surface-spacing", "0.5")),
                                ("a pixel", "whole", ("--surface-spacing", "1"))):
        rows = sheet(study, f"limited_{name}", f"points: {words}; the reference, the finest lights, lights by level",
                     "pyramid", study.path("lights.exr"), "--surface", study.path("ball_lod.exr"), *detail, "--lookup",
                     f"{REFERENCE},bilinear,level", "--shifts", "8", "--size", size, "--samples",
                     str(min(study.samples, 64)), "--pictures", study.path(f"limited_{name}"), "--exposure", "0.2")
        shown += [(read_picture(study.path(f"limited_{name}_{lookup}.png"))[:, :, :3], f"{words}, {caption}")
                  for lookup, caption in ((REFERENCE, "reference"), ("bilinear", "finest lights"),
                                          ("level", "lights by level"))]
        found += [[words, row["name"], percent(row["relative_l1"]), f"{row['flicker']:.3f}"]
                  for row in rows if "relative_l1" in row]
    study.table(["spacing of points", "lookup of lights", "relative L1", "flicker"], found)
    study.strip("limited", [shown[0], shown[1], shown[4], shown[2], shown[5]], zoom=5)


HILL_SIDE, OCTAVES = 257, 7  # in the finest octave, a wave is 6 points long


def hills(study):
    """Makes the pyramid of a height field."""
    y, x = np.mgrid[0:HILL_SIDE, 0:HILL_SIDE] / HILL_SIDE
    heights = sum(0.5 ** k * np.sin(2 ** k * 5 * x + k) * np.cos(2 ** k * 4 * y + 2 * k) for k in range(OCTAVES))
    write_picture(study.path("hills.exr"), (0.05 * heights)[:, :, None], oiio.FLOAT)
    study.run("multum", "lod", study.path("hills.exr"), "-o", study.path("lod.exr"))


def draw_surface(study, name, pyramid, *options, factor=1, size=(160, 120)):
    """Returns a picture in linear RGB with `factor` x `factor` samples per pixel, and its row of the report."""
    width, height = size
    study.run("multum-view", "lod", study.path(pyramid), *options, "-o", study.path(f"{name}.exr"), "--report",
              study.path(f"{name}.view.json"), "--size", f"{factor * width}x{factor * height}")
    loaded = json.loads(study.path(f"{name}.view.json").read_text())
    return box_reduced(read_picture(study.path(f"{name}.exr"))[:, :, :3], factor), loaded["pictures"][0]


def camera(distance):
    return ("--camera", f"{0.45 * distance:.5f},{-0.75 * distance:.5f},{0.5 * distance:.5f},0,0,0,30", "--up", "0,0,1",
            "--brdf", "blinn-phong:60", "--diffuse", "0.5", "--specular", "0.05", "--light", "0.4,-0.2,0.6")


def boiling(study):
    study.heading("The surface's level from its projection")
    study.paragraph("The camera zooms out over 14 frames, and its distance grows by 8 % per frame. Boiling is the "
                    "change between frames that does not occur in the reference. The reference is the finest surface "
                    "with 6 x 6 samples per pixel. If the level is chosen so that the distance between points in "
                    "pixels is constant, the surface changes smoothly. If only whole levels are used, the surface "
                    "changes in visible jumps.")
    frames = [3.0 * 1.08 ** k for k in range(14)]
    references = [draw_surface(study, f"zoom_reference{k}", "lod.exr", "--level", "0", *camera(d), factor=6)[0]
                  for k, d in enumerate(frames)]
    rows = []
    for words, detail in (("finest", ("--level", "0")), ("1 pixel apart", ("--point-spacing", "1")),
                          ("2 pixels apart", ("--point-spacing", "2")), ("4 pixels apart", ("--point-spacing", "4"))):
        drawn = [draw_surface(study, f"zoom{len(rows)}_{k}", "lod.exr", *detail, *camera(d))
                 for k, d in enumerate(frames)]
        rows.append([words, drawn])
        if detail[-1] == "2":
            whole = [draw_surface(study, f"zoom_whole{k}", "lod.exr", "--level", str(round(row["level"])), *camera(d))
                     for k, (d, (_, row)) in enumerate(zip(frames, drawn))]
            rows.append(["2 pixels apart, whole levels", whole])
    study.table(["points", "levels", "triangles", "relative L1", "boiling"],
                [[words, f"{drawn[0][1]['level']:.2f} to {drawn[-1][1]['level']:.2f}",
                  f"{drawn[0][1]['triangles']} to {drawn[-1][1]['triangles']}",
                  percent(float(np.mean([relative_l1(shown, r) for (shown, _), r in zip(drawn, references)]))),
                  percent(flicker([shown for shown, _ in drawn], references))] for words, drawn in rows])
    covered = np.argwhere(references[-1].max(axis=2) > 0)
    crop = tuple(slice(low - 2, high + 3) for low, high in zip(covered.min(axis=0), covered.max(axis=0)))
    study.strip("boiling", [(srgb(references[-1]), "reference, last frame"),
                            *[(srgb(drawn[-1][0]), f"points {words}") for words, drawn in rows]], 6, crop)


def torus_points(path, around=64, across=32):
    """Writes a fluted ring as a grid of control points, closed in both directions."""
    u = (np.arange(around) + 0.5)[None, :] / around * 2 * np.pi
    v = (np.arange(across) + 0.5)[:, None] / across * 2 * np.pi
    thick = 0.4 * (1 + 0.2 * np.sin(5 * u) * np.ones_like(v))
    far = 1 + thick * np.cos(v)
    write_picture(path, np.dstack([far * np.cos(u), far * np.sin(u), thick * np.sin(-v)]), oiio.FLOAT)
    return path


def patches(study):
    study.heading("Patches by their control points")
    study.paragraph("The points of a level are used as control points of bicubic B-spline patches. The patches "
                    "are smooth, whereas triangles with the same points have visible edges. The reference for the "
                    "errors is the "
                    "spline itself, drawn with 32 x 32 cells per patch.")
    study.run("multum", "lod", torus_points(study.path("torus_points.exr")), "-o", study.path("torus_lod.exr"), "--of",
              "positions", "--wrap", "periodic")
    view = ("--camera", "0.3,-3.2,2.2,0,0,0,38", "--up", "0,0,1", "--brdf", "blinn-phong:60", "--specular", "0.1",
            "--light", "0.4,-0.6,1")
    draw = lambda name, *options: draw_surface(study, name, "torus_lod.exr", *options, *view, factor=4, size=(240, 160))
    rows, shown = [], []
    for level, points in (("1", "32 x 16"), ("2", "16 x 8")):
        spline, _ = draw(f"spline{level}", "--level", level, "--patches", "32")
        pictures = {"triangles": draw(f"points{level}", "--level", level)[0],
                    **{cells: draw(f"patches{level}_{cells}", "--level", level, "--patches", cells)[0]
                       for cells in ("2", "4", "8")}}
        rows.append([level, points, *[percent(relative_l1(picture, spline)) for picture in pictures.values()]])
        shown += [(srgb(pictures["triangles"]), f"{points} points as triangles"),
                  (srgb(pictures["8"]), "as patches of 8 x 8 cells")]
    study.table(["level", "control points", "triangles", *[f"patches of {n} x {n} cells" for n in (2, 4, 8)]], rows)
    study.strip("patches", shown)


def levels_of_detail(study):
    study.heading("Levels of detail")
    study.paragraph("The pyramid of a height field is drawn at fractional levels. Coarser levels have fewer "
                    "points than finer levels, and smoother hills.")
    hills(study)
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
    limited_curvature(study)
    levels_of_detail(study)
    boiling(study)
    patches(study)
