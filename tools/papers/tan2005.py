# SPDX-License-Identifier: Apache-2.0
"""Tan, Lin, Quan, Guo and Shum 2005, "Multiresolution Reflectance Filtering": figures 4, 6, 7 and 8.

Their scenes (a carved silver disk, golden armour) are not published. The disk is here the map of rings, once across a
square; the armour is the map of hemispherical scales, repeated. What carries over is which method is nearer to the
truth, and by what factor, not the figure's own value.
"""
import numpy as np
from report_page import percent
from study import colour_distance, flicker, relative_l1

TITLE = "Tan et al. 2005: multiresolution reflectance filtering"
FRAME = ("--size", "400x300")
DISK = ("--repeat", "1", "--up", "0,0,1", "--light", "0.2,0.6,1", "--light", "-0.5,0.1,0.8,1.5", "--brdf",
        "blinn-phong:100", "--diffuse", "0.15", "--specular", "0.12")


def camera(distance, height, field=45):
    """Looks at the middle of the plane from in front of it."""
    return ("--camera", f"0,{30 - distance:.3f},{height:.3f},0,30,0,{field}")


def zoom(study):
    """Figure 4: three neighbouring frames of a camera that zooms out, against Toksvig's."""
    views = [study.view(f"zoom{i}", "disk", *DISK, *FRAME, *camera(38 * far, 36 * far),
                        compare=("truth", "mip", "toksvig", "lean-jacobian"))
             for i, far in enumerate((1.0, 1.06, 1.12))]
    gaussians = [study.view(f"zoom_gmm{i}", "disk_gmm", *DISK, *FRAME, *camera(38 * far, 36 * far))
                 for i, far in enumerate((1.0, 1.06, 1.12))]
    few = [study.view(f"zoom_few{i}", "disk", *DISK, *FRAME, *camera(38 * far, 36 * far), samples=16,
                      compare=("truth",))["truth"] for i, far in enumerate((1.0, 1.06, 1.12))]
    study.heading("Figure 4: three frames of a zoom")
    study.paragraph("A carved disk, the camera moving away by 6 % a frame. Flicker is what a picture changes from",
                    "frame to frame beyond what the truth changes, relative to the truth: 0 is as steady as the truth.")
    frames = {"multum, vmf": [v["multum"] for v in views], "multum, gmm": [v["multum"] for v in gaussians],
              "Toksvig": [v["toksvig"] for v in views], "LEAN": [v["lean-jacobian"] for v in views],
              "averaged normals": [v["mip"] for v in views]}
    truths = [v["truth"] for v in views]
    for label, shown in [("truth", truths), *list(frames.items())[:3]]:
        study.figures([(picture, f"{label}, frame {i + 1}") for i, picture in enumerate(shown)], name="zoom")
    published = {"multum, gmm": "0.060 (ours of the paper)", "Toksvig": "0.165"}
    mean = lambda measure, shown, target: float(np.mean([measure(a, b) for a, b in zip(shown, target)]))
    study.table(["method", "colour error against 16 samples", "published", "against the truth", "relative L1",
                 "flicker"],
                [[label, f"{mean(colour_distance, shown, few):.3f}", published.get(label, "-"),
                  f"{mean(colour_distance, shown, truths):.3f}", percent(mean(relative_l1, shown, truths)),
                  percent(flicker(shown, truths))] for label, shown in frames.items()] +
                [["16 samples a pixel", "0", "0 by definition", f"{mean(colour_distance, few, truths):.3f}",
                  percent(mean(relative_l1, few, truths)), percent(flicker(few, truths))]])
    study.paragraph("The paper measures against 16 rays a pixel. Those are themselves off: the last row says how far.")


def alignment(study):
    """Figures 5 and 6: the same lobes with and without alignment."""
    where = (*DISK, *FRAME, *camera(52, 34, 35))
    aligned = study.view("aligned", "disk", *where, compare=("truth",))
    unaligned = study.view("unaligned", "disk_unaligned", *where)
    study.heading("Figures 5 and 6: alignment")
    study.paragraph("The lobes of every texel fitted by themselves are as near to its normals as aligned ones, but",
                    "between texels the filter mixes lobe 1 of one with lobe 1 of the other, whatever they are.")
    study.figures([(unaligned["multum"], "unaligned lobes"), (aligned["truth"], "truth"),
                   (aligned["multum"], "aligned lobes")], name="alignment")
    study.table(["lobes", "colour error", "relative L1"],
                [[label, f"{colour_distance(picture, aligned['truth']):.3f}",
                  percent(relative_l1(picture, aligned["truth"]))]
                 for label, picture in (("aligned", aligned["multum"]), ("unaligned", unaligned["multum"]))])


def fournier(study):
    """Figure 7: several Phong peaks a texel, shaded before they are filtered, and anisotropic filtering of ours."""
    where = (*DISK, *FRAME, *camera(60, 14, 30))
    ours = study.view("oblique", "disk", *where, "--anisotropy", "8", compare=("truth",))
    gaussians = study.view("oblique_gmm", "disk_gmm", *where, "--anisotropy", "8")
    theirs = study.view("oblique_fournier", "disk_unaligned", *where, "--formula", "paper", "--shade-first")
    study.heading("Figure 7: Fournier's Phong peaks")
    study.paragraph("A disk at a grazing angle. Fournier fits Phong peaks to every texel by itself; they cannot be",
                    "mixed, so that all eight texels of a trilinear footprint are shaded, and a wider footprint cannot",
                    "be had. Aligned lobes are mixed by the hardware, here with 8 times anisotropic filtering.")
    study.figures([(ours["truth"], "truth"), (ours["multum"], "multum, vmf"), (gaussians["multum"], "multum, gmm"),
                   (theirs["multum"], "four Phong peaks a texel")], name="fournier")
    study.table(["method", "colour error", "published", "relative L1", "frame, ms"],
                [[label, f"{colour_distance(view['multum'], ours['truth']):.3f}", published,
                  percent(relative_l1(view["multum"], ours["truth"])), f"{view.frame_ms['multum']:.1f}"]
                 for label, view, published in (("multum, vmf", ours, "-"), ("multum, gmm", gaussians, "0.041"),
                                                ("Phong peaks", theirs, "0.123"))])


def armour(study):
    """Figure 8: golden armour from near and far, against a BRDF that stays as it is near by."""
    gold = ("--mesh", study.torus(), "--repeat", "3", "--up", "0,0,1", "--light", "0.5,-0.6,1", "--brdf",
            "blinn-phong:100", "--diffuse", "0.3,0.2,0.05", "--specular", "0.3,0.22,0.07", *FRAME)
    near = study.view("armour_near", "armour", *gold, "--camera", "0.5,-2.6,0.9,0.3,-1,0.2,24",
                      compare=("truth", "mip"))
    far = study.view("armour_far", "armour", *gold, "--camera", "0.6,-6,5,0,0,0,28", compare=("truth", "mip"))
    gaussians = study.view("armour_gmm", "armour_gmm", *gold, "--camera", "0.6,-6,5,0,0,0,28")
    study.heading("Figure 8: golden armour")
    study.paragraph("Hemispherical scales, near and far. With a fixed BRDF and averaged normals the far one shines",
                    "like a smooth ring.")
    study.figures([(near["multum"], "near, multum"), (far["multum"], "far, multum, vmf"), (far["truth"], "far, truth"),
                   (far["mip"], "far, fixed BRDF")], name="armour")
    study.table(["far", "colour error", "published", "relative L1"],
                [[label, f"{colour_distance(picture, far['truth']):.3f}", published,
                  percent(relative_l1(picture, far["truth"]))]
                 for label, picture, published in (("multum, vmf", far["multum"], "-"),
                                                   ("multum, gmm", gaussians["multum"], "0.058"),
                                                   ("fixed BRDF", far["mip"], "0.175"))])


def reproduce(study):
    rings = study.testmap("disk", "--quarter", "rings")
    scales = study.testmap("armour", "--quarter", "armour")
    for name, source, options in (("disk", rings, ()), ("disk_unaligned", rings, ("--unaligned",)),
                                  ("disk_gmm", rings, ("--ndf", "gmm")), ("armour", scales, ()),
                                  ("armour_gmm", scales, ("--ndf", "gmm"))):
        study.bake(name, source, "--green", "up", *options)
    study.paragraph("Their disk and armour are not published: a map of rings and one of hemispherical scales stand in",
                    "for them. The colour error is theirs in words, the mean distance of displayed colours over that",
                    "of black and white; its value depends on the scene, the factor between two methods less so.")
    zoom(study)
    alignment(study)
    fournier(study)
    armour(study)
