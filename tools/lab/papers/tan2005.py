# SPDX-License-Identifier: Apache-2.0
"""Tan, Lin, Quan, Guo and Shum 2005, "Multiresolution Reflectance Filtering": figures 4, 6, 7 and 8.

The paper's scenes (a carved silver disk, golden armour) are not published. The map of rings, once across a square,
replaces the disk. The repeated map of hemispherical scales replaces the armour. The order of methods and the ratios of
their errors can be compared with the paper, but the values cannot. Tables therefore list ratios next to the paper's
ratios.

The material follows the paper: Cook-Torrance's highlight with Schlick's Fresnel factor F(v.h), and Lambert times 1 - F.
The paper's formula omits shadowing and masking. Here both are included, for the reference and for every method.
"""
import numpy as np
from report_page import percent
from study import ELONGATED_FILTER, REFERENCE, ROUND_FILTER, box_reduced, colour_distance, flicker, relative_l1

TITLE = "Tan et al. 2005: multiresolution reflectance filtering"
WIDTH, HEIGHT = 400, 300
FRAME = ("--size", f"{WIDTH}x{HEIGHT}")
FINER = 8  # each side of a pixel is divided into this many parts, to separate the error of the filter from other errors
SILVER = ("--brdf", "cook-torrance:0.07,0.95,0.93,0.88", "--diffuse", "0.5", "--specular", "0.2")
GOLD = ("--brdf", "cook-torrance:0.07,1.0,0.77,0.34", "--diffuse", "0.5", "--specular", "0.25")
DISK = ("--repeat", "1", "--up", "0,0,1", "--light", "0.2,0.6,1", "--light", "-0.5,0.1,0.8,1.5", *SILVER)
OURS = "planar Gaussians, 4 (method of the paper)"
BASELINES = (("Toksvig", "toksvig"), ("LEAN, slopes as published", "lean"),
             ("LEAN with the Jacobian", "lean-jacobian"), ("averaged normals", "mip"),
             # These methods are shaded at as many points per pixel as four lobes need evaluations.
             ("Toksvig, 4 points", "toksvig-points"), ("LEAN with the Jacobian, 4 points", "lean-jacobian-points"),
             ("averaged normals, 4 points", "points"))


def camera(distance, height, field=45):
    """A camera in front of the plane that looks at its middle."""
    return ("--camera", f"0,{30 - distance:.3f},{height:.3f},0,30,0,{field}")


def mean(measure, shown, targets):
    return float(np.mean([measure(a, b) for a, b in zip(shown, targets)]))


def beside(rows, label):
    """Returns the colour error of `label`, and in brackets its ratio to the first row. `rows` maps labels to errors."""
    return f"{rows[label]:.3f} ({rows[label] / next(iter(rows.values())):.2f})"


def factors(study, rows, published):
    """Makes a table of colour errors next to the paper's errors. `rows` maps labels to (colour error, further cells).
    `published` maps labels to the paper's colour errors. The first row is the paper's method."""
    head, further = next(iter(rows)), [name for name, _ in next(iter(rows.values()))[1]]
    study.table(["method", "colour error", "ratio to the paper's method", "published", "published ratio", *further],
                [[label, f"{error:.3f}", f"{error / rows[head][0]:.2f}",
                  *([f"{published[label]:.3f}", f"{published[label] / published[head]:.2f}"] if label in published
                    else ["-", "-"]), *[cell for _, cell in cells]] for label, (error, cells) in rows.items()])


def zoom(study):
    """Figure 4: three neighbouring frames of a camera that zooms out, compared with Toksvig."""
    distances = (1.0, 1.06, 1.12)
    drawn = {}
    for i, far in enumerate(distances):
        where = (*DISK, *FRAME, *camera(38 * far, 36 * far))
        of_texels = (*where, "--reference-of", "texels")
        names = (REFERENCE, *[name for _, name in BASELINES])
        drawn[i] = {"vmf": study.view(f"zoom{i}", "disk", *where, compare=names),
                    "gmm": study.view(f"zoom_gmm{i}", "disk_gmm", *where),
                    "few": study.view(f"zoom_few{i}", "disk", *where, samples=16, compare=(REFERENCE,)),
                    "texels": study.view(f"zoom_texels{i}", "disk", *of_texels, compare=(REFERENCE,))}
    frames = [drawn[i] for i in range(len(distances))]
    shown = {OURS: [f["gmm"]["multum"] for f in frames], "vMF lobes, 4": [f["vmf"]["multum"] for f in frames],
             **{label: [f["vmf"][name] for f in frames] for label, name in BASELINES}}
    references = [f["vmf"][REFERENCE] for f in frames]
    few = [f["few"][REFERENCE] for f in frames]
    texels = [f["texels"][REFERENCE] for f in frames]
    study.heading("Figure 4: three frames of a zoom")
    study.paragraph("The camera moves away from a carved disk by 6 % per frame. Flicker is the change between frames "
                    "that does not occur in the reference, relative to the reference. If the flicker is 0, the "
                    "picture is as steady as the reference. The paper computes colour errors against a reference with "
                    "16 rays per pixel.")
    for label, pictures in [("reference", references), *list(shown.items())[:3]]:
        study.figures([(picture, f"{label}, frame {i + 1}") for i, picture in enumerate(pictures)], name="zoom")
    own = {label: mean(colour_distance, pictures, texels) for label, pictures in shown.items()}
    rows = {label: (mean(colour_distance, pictures, few),
                    [("against all samples", f"{mean(colour_distance, pictures, references):.3f}"),
                     ("against the reference with the same filter", beside(own, label)),
                     ("relative L1", percent(mean(relative_l1, pictures, references))),
                     ("flicker", percent(flicker(pictures, references)))]) for label, pictures in shown.items()}
    factors(study, rows, {OURS: 0.060, "Toksvig": 0.165})
    ours, theirs = rows[OURS][0], rows["Toksvig"][0]
    study.paragraph("In the paper, the error of Toksvig is 2.75 times the error of the paper's method. Here, the",
                    f"factor is {theirs / ours:.2f}. Against the reference with the same filter, the factor is",
                    f"{own['Toksvig'] / own[OURS]:.2f}.")
    study.paragraph(f"A reference with 16 samples per pixel differs from a reference with {study.samples} samples by",
                    f"{mean(colour_distance, few, references):.3f} in colour error and by",
                    f"{percent(mean(relative_l1, few, references))} in relative L1. The reference with the same "
                    f"filter averages over the texels that the filter reads. Errors against this reference come only "
                    f"from the methods, without the blur that all methods share.")


def alignment(study):
    """Figures 5 and 6: the same lobes with and without alignment."""
    where = (*DISK, *FRAME, *camera(52, 34, 35))
    aligned = study.view("aligned", "disk_gmm", *where, compare=(REFERENCE,))
    unaligned = study.view("unaligned", "disk_gmm_unaligned", *where)
    study.heading("Figures 5 and 6: alignment")
    study.paragraph("If Gaussians are fitted independently for every texel, they approximate the normals about as",
                    "accurately as aligned Gaussians. Between two texels, however, the filter mixes the first "
                    "Gaussian of one texel with the first Gaussian of the other texel, even if these Gaussians "
                    "represent different normals.")
    study.figures([(unaligned["multum"], "unaligned Gaussians"), (aligned[REFERENCE], "reference"),
                   (aligned["multum"], "aligned Gaussians")], name="alignment")
    study.table(["Gaussians", "colour error", "relative L1"],
                [[label, f"{colour_distance(picture, aligned[REFERENCE]):.3f}",
                  percent(relative_l1(picture, aligned[REFERENCE]))]
                 for label, picture in (("aligned", aligned["multum"]), ("unaligned", unaligned["multum"]))])


def fournier(study):
    """Figure 7: several peaks per texel, shaded before they are filtered, and anisotropic filtering of aligned
    lobes."""
    where, frame = (*DISK, *camera(60, 14, 30)), FRAME
    finer = ("--size", f"{FINER * WIDTH}x{FINER * HEIGHT}")
    wide = study.view("oblique_gmm", "disk_gmm", *where, *frame, *ELONGATED_FILTER, compare=(REFERENCE,))
    lobes = study.view("oblique", "disk", *where, *frame, *ELONGATED_FILTER)
    round_filter = study.view("oblique_round", "disk_gmm", *where, *frame, *ROUND_FILTER)
    many = study.view("oblique_finer", "disk_gmm", *where, *finer, *ROUND_FILTER)
    theirs = study.view("oblique_fournier", "disk_unaligned", *where, *frame, *ROUND_FILTER, "--shade-first")
    reference, fitting = wide[REFERENCE], box_reduced(many["multum"], FINER)
    study.heading("Figure 7: Fournier's Phong peaks")
    study.paragraph("The camera sees a disk at a grazing angle. Fournier fits Phong peaks to every texel",
                    "independently, so a filter cannot mix them. All eight texels of a trilinear footprint must",
                    "therefore be shaded, and wider footprints are not possible. The filter can mix aligned",
                    f"lobes, here with {' '.join(ELONGATED_FILTER)}. Here, vMF lobes of an unaligned bake replace",
                    "Phong peaks.")
    rows = [(OURS + ", elongated filter", wide["multum"], wide),
            ("vMF lobes, elongated filter", lobes["multum"], lobes),
            ("planar Gaussians, round filter", round_filter["multum"], round_filter),
            (f"planar Gaussians, {FINER} x {FINER} round lookups per pixel", fitting, many),
            ("peaks, all eight texels shaded", theirs["multum"], theirs)]
    study.figures([(reference, "reference"), *[(picture, label) for label, picture, _ in rows]], name="fournier")
    factors(study, {label: (colour_distance(picture, reference),
                            [("relative L1", percent(relative_l1(picture, reference))),
                             ("frame, ms", f"{view.frame_ms['multum']:.1f}")]) for label, picture, view in rows},
            {rows[0][0]: 0.041, rows[-1][0]: 0.123})
    study.paragraph("Together, many small lookups per pixel act like a filter with the shape of the pixel. The row "
                    "with 8 x 8 "
                    "lookups therefore lists only the error of the Gaussians. The other rows include the errors of "
                    "their filters. The picture of the",
                    "elongated filter differs from the picture of the round filter by",
                    f"{percent(relative_l1(wide['multum'], round_filter['multum']))} of its light. The factor "
                    f"in the paper is the time for the peaks, divided by the time for a filter that fits the "
                    f"pixel. Here, this "
                    f"factor is",
                    f"{colour_distance(theirs['multum'], reference) / colour_distance(fitting, reference):.1f}.")


def armour(study):
    """Figure 8: golden armour from near and far, compared with a BRDF that does not change with distance."""
    gold = ("--mesh", study.torus(), "--repeat", "3", "--up", "0,0,1", "--light", "0.5,-0.6,1", *GOLD, *FRAME)
    far_away = ("--camera", "0.6,-6,5,0,0,0,28")
    near = study.view("armour_near", "armour_gmm", *gold, "--camera", "0.5,-2.6,0.9,0.3,-1,0.2,24",
                      compare=(REFERENCE, "mip"))
    far = study.view("armour_far", "armour_gmm", *gold, *far_away, compare=(REFERENCE, "mip", "points"))
    lobes = study.view("armour_vmf", "armour", *gold, *far_away)
    eight = study.view("armour_gmm8", "armour_gmm8", *gold, *far_away)
    texels = study.view("armour_texels", "armour_gmm", *gold, *far_away, "--reference-of", "texels",
                        compare=(REFERENCE,))
    study.heading("Figure 8: golden armour")
    study.paragraph("The picture shows hemispherical scales from near and far. With a fixed BRDF and averaged "
                    "normals, the "
                    "distant armour shines like a smooth ring.")
    study.figures([(near["multum"], "near, planar Gaussians"), (far["multum"], "far, planar Gaussians"),
                   (far[REFERENCE], "far, reference"), (far["mip"], "far, fixed BRDF")], name="armour")
    rows = {OURS: far["multum"], "planar Gaussians, 8": eight["multum"], "vMF lobes, 4": lobes["multum"],
            "fixed BRDF": far["mip"], "fixed BRDF, 4 points": far["points"]}
    own = {label: colour_distance(picture, texels[REFERENCE]) for label, picture in rows.items()}
    factors(study, {label: (colour_distance(picture, far[REFERENCE]),
                            [("against the reference with the same filter", beside(own, label)),
                             ("relative L1", percent(relative_l1(picture, far[REFERENCE])))])
                    for label, picture in rows.items()}, {OURS: 0.058, "fixed BRDF": 0.175})
    factor = lambda errors: f"{errors['fixed BRDF'] / errors[OURS]:.2f}"
    study.paragraph("In the paper, the error of a fixed BRDF is 3.0 times the error of the paper's method. Here, the",
                    f"factor is {factor({label: colour_distance(rows[label], far[REFERENCE]) for label in rows})}.",
                    "Against the reference with the same filter, the factor is",
                    f"{factor(own)}. The normals of hemispherical scales fill the whole hemisphere, which four "
                    "lobes cannot represent well.")


def reproduce(study):
    rings = study.testmap("disk", "--quarter", "rings")
    scales = study.testmap("armour", "--quarter", "armour")
    for name, source, options in (("disk", rings, ()), ("disk_unaligned", rings, ("--unaligned",)),
                                  ("disk_gmm", rings, ("--ndf", "gmm")),
                                  ("disk_gmm_unaligned", rings, ("--ndf", "gmm", "--unaligned")),
                                  ("armour", scales, ()), ("armour_gmm", scales, ("--ndf", "gmm")),
                                  ("armour_gmm8", scales, ("--ndf", "gmm", "--lobes", "8"))):
        study.bake(name, source, "--green", "up", *options)
    study.paragraph("The disk and the armour of the paper are not published. A map of rings replaces the disk, and a "
                    "map of hemispherical scales replaces the armour. The paper defines the colour error only in "
                    "words: the mean distance between displayed colours, divided by the distance between black and "
                    "white. The colour error depends on the scene, but the ratio between two methods depends less on "
                    "it.")
    zoom(study)
    alignment(study)
    fournier(study)
    armour(study)
