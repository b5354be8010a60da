# SPDX-License-Identifier: Apache-2.0
"""Han, Sun, Ramamoorthi and Grinspun 2007, "Frequency Domain Normal Map Filtering": figures 1 to 9, section 8."""
import json

import cloth
import numpy as np
import OpenImageIO as oiio
from ndf import density_error, density_of_lobes, density_of_normals, disk, picture, read_lobes, read_normals
from report_page import percent
from study import (ELONGATED_FILTER, REFERENCE, ROUND_FILTER, box_reduced, read_picture, relative_l1, srgb,
                   write_picture, write_sky)

TITLE = "Han et al. 2007: frequency domain normal map filtering"
FRAME = ("--size", "400x300")
PLAIN = ("mip", "toksvig", "lean-jacobian")
# These methods are shaded at as many points per pixel as lobes need evaluations.
POINTS = ("points", "toksvig-points", "lean-jacobian-points")
BASELINES = (REFERENCE, *PLAIN, *POINTS)
LABELS = {REFERENCE: "reference", "multum": "multum", "mip": "averaged normals", "toksvig": "Toksvig",
          "lean-jacobian": "LEAN with the Jacobian"}
LABELS |= {points: f"{LABELS[plain]}, as many evaluations" for plain, points in zip(PLAIN, POINTS)}


def compare(study, view, names, name, exposure=1.0):
    study.figures([(view[n], LABELS[n]) for n in names], name=name, exposure=exposure)
    study.table(["method", "relative L1", "frame, ms"],
                [[LABELS[n], percent(relative_l1(view[n], view[REFERENCE])), f"{view.frame_ms[n]:.1f}"]
                 for n in names if n != REFERENCE])


def v_groove(study):
    source = study.testmap("groove", "--quarter", "grooves")
    study.bake("groove", source, "--green", "up")
    study.heading("Figure 1: a V-groove")
    study.paragraph("The groove consists of two slopes and a floor. In the near view, each of the three surfaces "
                    "shows a separate highlight. In the far view, one pixel covers all three surfaces. The average "
                    "normal of these surfaces points straight up, although almost no normal of the map has this "
                    "direction.")
    lobes = ("--brdf", "blinn-phong:60", "--diffuse", "0.4", "--specular", "0.15", "--light", "-0.775,0.442,0.445",
             *FRAME)
    near = study.view("groove_near", "groove", *lobes, "--repeat", "60", "--camera", "0,0,0.7,0,0.7,0,45",
                      compare=BASELINES)
    far = study.view("groove_far", "groove", *lobes, "--repeat", "60", "--camera", "0,0,4,0,8,0,45",
                     compare=BASELINES)
    study.paragraph("Near:")
    study.figures([(near[n], LABELS[n]) for n in (REFERENCE, "multum", "mip")], name="groove_near",
                  exposure=0.35)
    study.paragraph("Far:")
    compare(study, far, (REFERENCE, "multum", *PLAIN, *POINTS), "groove_far", exposure=0.35)
    normals = read_normals(source)
    directions, inside = disk(120)
    level = 5
    reference = density_of_normals(normals[:32, :32].reshape(-1, 3), directions)
    fitted = density_of_lobes(read_lobes(study.path("groove.ndf.exr"), level)[:, 0, 0], directions)
    study.paragraph("The distribution of normals under one texel of level 5, and its four lobes:")
    study.figures([(picture(reference, inside, reference.max()), "the normals"),
                   (picture(fitted, inside, reference.max()), "four lobes")], name="groove_ndf", small=True)


def methods(study):
    source = study.testmap("quarters")
    study.bake("quarters", source, "--green", "up", "--albedo", study.path("quarters_albedo.png"), "--lobes", "6")
    study.bake("quarters_white", source, "--green", "up", "--lobes", "6")
    study.bake("one_lobe", source, "--green", "up", "--albedo", study.path("quarters_albedo.png"), "--lobes", "1")
    material = ("--source", source, "--green", "up", "--albedo", study.path("quarters_albedo.png"), "--brdf",
                "blinn-phong:200", "--diffuse", "0.8", "--specular", "0.15", *FRAME)
    six = study.view("six", "quarters", *material, compare=BASELINES)
    one = study.view("one", "one_lobe", *material)
    study.heading("Figure 2: six lobes with colours, compared with other methods")
    study.figures([(six[REFERENCE], "reference"), (six["multum"], "six lobes"), (one["multum"], "one lobe"),
                   (six["toksvig"], "Toksvig"), (six["mip"], "averaged normals")], name="methods")
    rows = [["six lobes", six["multum"], six.frame_ms["multum"]], ["one lobe", one["multum"], one.frame_ms["multum"]],
            *[[LABELS[n], six[n], six.frame_ms[n]] for n in (*PLAIN, *POINTS)]]
    study.table(["method", "relative L1", "frame, ms"],
                [[label, percent(relative_l1(shown, six[REFERENCE])), f"{ms:.1f}"] for label, shown, ms in rows])
    return material


def harmonics(study):
    source = study.path("quarters_normal.png")
    study.heading("Figure 3: spherical harmonics and anisotropic filtering, Lambert")
    study.paragraph("Each texel has nine coefficients. The coefficients are plain averages, so filtering them with "
                    "several taps is exact. Averaged normals cause errors, because max(n . l, 0) is not linear.")
    study.bake("sh2", source, "--green", "up", "--ndf", "sh", "--sh-order", "2")
    matt = ("--source", source, "--green", "up", "--brdf", "lambert", "--diffuse", "0.9", "--light", "0.9,0.3,0.3",
            *FRAME)
    plain = study.view("sh_plain", "sh2", *matt, *ROUND_FILTER, compare=(REFERENCE, "mip"))
    wide = study.view("sh_wide", "sh2", *matt, *ELONGATED_FILTER)
    study.figures([(plain[REFERENCE], "reference"), (wide["multum"], "SH, 8 taps"),
                   (plain["multum"], "SH, trilinear"), (plain["mip"], "averaged normals")], name="sh")
    study.table(["method", "relative L1"],
                [[label, percent(relative_l1(shown, plain[REFERENCE]))]
                 for label, shown in (("SH, 8 taps", wide["multum"]), ("SH, trilinear", plain["multum"]),
                                      ("averaged normals", plain["mip"]))])


def measured_materials(study):
    """Figure 4: spherical harmonics with measured BRDFs."""
    study.heading("Figure 4: measured materials")
    found = [] if study.data is None else sorted((study.data / "brdf").glob("merl_*.json"))
    if not found:
        study.paragraph("Left out: found no measured BRDFs in the folder brdf of MULTUM_SHARED_DATA.")
        return
    source = study.path("quarters_normal.png")
    study.bake("sh8", source, "--green", "up", "--ndf", "sh", "--sh-order", "8")
    study.paragraph("The materials are fits to measured MERL materials. Each fit is a product of functions of "
                    "the half angle, and the function of theta_h is convolved with the normals. The convolution uses "
                    "harmonics up to order 8, or six lobes.")
    rows = []
    for path in [p for p in found if "fabric" in p.name or "rubber" in p.name]:
        label = path.stem.replace("merl_nbrdf_", "")
        scene = ("--source", source, "--green", "up", "--brdf", path, *FRAME)
        harmonic = study.view(f"measured_sh_{label}", "sh8", *scene, compare=(REFERENCE, "mip"))
        lobes = study.view(f"measured_vmf_{label}", "quarters_white", *scene)
        study.figures([(harmonic[REFERENCE], f"{label}, reference"), (harmonic["multum"], "harmonics, order 8"),
                       (lobes["multum"], "six lobes"), (harmonic["mip"], "averaged normals")], name="measured")
        rows.append([label, *[percent(relative_l1(shown, harmonic[REFERENCE]))
                              for shown in (harmonic["multum"], lobes["multum"], harmonic["mip"])]])
    study.table(["material", "harmonics, order 8", "six lobes", "averaged normals"], rows)


def draped_cloth(study):
    """Figure 5: a moving mesh, blue fabric, harmonics."""
    study.heading("Figure 5: cloth that falls on a sphere")
    fabric = None if study.data is None else study.data / "brdf/merl_nbrdf_blue-fabric.json"
    weave = None if study.data is None else study.data / "normal/pm_0010.webp"
    has_fabric, has_weave = fabric is not None and fabric.is_file(), weave is not None and weave.is_file()
    source = weave if has_weave else study.path("quarters_normal.png")
    study.paragraph("tools/lab/papers/cloth.py simulates the cloth. Harmonics of order 8 represent the normals of a",
                    ("woven map" if has_weave else "generated map (MULTUM_SHARED_DATA has a woven map)") + ".",
                    "In the near view, the filter hardly changes the middle of the picture, but changes the corners",
                    "strongly.")
    study.bake("cloth", source, *(() if has_weave else ("--green", "up")), "--ndf", "sh", "--sh-order", "8")
    material = ("--brdf", fabric if has_fabric else "blinn-phong:12", "--source", source, "--light", "0.3,-0.5,0.8,3",
                "--up", "0,0,1", "--repeat", "1", *FRAME)
    near, far = "0.35,-0.75,1.05,0,-0.05,0.55,60", "2.2,-4.2,3.4,0,0,0.05,30"
    steps, exposure = (30, 150), 2.5
    views = {}
    for step, positions in zip(steps, cloth.drape(steps)):
        mesh = study.path(f"cloth_{step}.obj")
        cloth.write_obj(mesh, positions, repeats=12)
        for place, camera in (("near", near), ("far", far)):
            views[step, place] = study.view(f"cloth_{step}_{place}", "cloth", *material, "--mesh", mesh, "--camera",
                                            camera, compare=(REFERENCE, "mip"))
    first, second = steps
    study.figures([(views[first, "near"]["multum"], "harmonics, falling"),
                   (views[second, "near"]["multum"], "harmonics, at rest"),
                   (views[second, "near"][REFERENCE], "reference, at rest"),
                   (views[second, "near"]["mip"], "averaged normals"),
                   (views[second, "far"]["multum"], "harmonics, from afar")], name="cloth", exposure=exposure)
    study.table(["view", "harmonics, order 8", "averaged normals"],
                [[f"{words}, {place}", *[percent(relative_l1(views[step, place][n], views[step, place][REFERENCE]))
                                         for n in ("multum", "mip")]]
                 for step, words in zip(steps, ("falling", "at rest")) for place in ("near", "far")])


def environment_light(study):
    """Figure 9: a mesh in low-frequency light, and in the full environment."""
    study.heading("Figure 9: a mesh under an environment")
    study.paragraph("Diffuse light uses harmonics up to order 2. The first column of highlights uses harmonics of the "
                    "light as a function of the half vector, up to order 8 (Han, section 8). These harmonics are "
                    "accurate only for broad highlights. The second column uses maps that are filtered for lobes of "
                    "every width. Filtered maps are also accurate for sharp highlights.")
    light = study.path("sky.exr")
    write_sky(light)
    if study.data is not None and (study.data / "env/pm_lobby.exr").is_file():
        light = study.data / "env/pm_lobby.exr"
    scene = ("--source", study.path("quarters_normal.png"), "--green", "up", "--mesh", study.torus(), "--repeat", "3",
             "--up", "0,0,1", "--camera", "0.9,-2.2,1.7,0,0,0,40", "--environment", light, "--no-background",
             "--diffuse", "0.35", "--specular", "0.3", *FRAME)
    rows = []
    for exponent in (12, 100):
        views = {mode: study.view(f"environment_{mode}{exponent}", "quarters_white", *scene, "--environment-mode", mode,
                                  "--brdf", f"blinn-phong:{exponent}", compare=(REFERENCE, "mip", "points"))
                 for mode in ("sh", "prefiltered")}
        reference = views["sh"][REFERENCE]
        study.figures([(reference, f"reference, s = {exponent}"), (views["sh"]["multum"], "harmonics"),
                       (views["prefiltered"]["multum"], "filtered maps"),
                       (views["prefiltered"]["mip"], "averaged normals")], name="environment", exposure=0.35)
        rows.append([exponent, *[percent(relative_l1(shown, reference))
                                 for shown in (views["sh"]["multum"], views["prefiltered"]["multum"],
                                               views["prefiltered"]["mip"], views["prefiltered"]["points"])]])
    study.table(["s", "six lobes, harmonics", "six lobes, filtered maps", LABELS["mip"], LABELS["points"]], rows)


def changing_light(study):
    """Section 8, dynamic lighting: an environment that turns and fades into another."""
    study.heading("Section 8: an environment that changes at run time")
    frames = 5
    study.paragraph("A sky turns by 90 degrees and fades into dusk. Harmonics up to order 2 and filtered maps are "
                    "linear in the light. In each frame, multum therefore mixes their values for the two skies. The "
                    "column *new environment* lists the time for a completely new environment. Han's highlights "
                    "use harmonics of the light as a function of the half vector, up to order 8. These harmonics are "
                    "recomputed in every frame.")
    light, dusk = study.path("sky512.exr"), study.path("dusk512.exr")
    write_sky(light, 512)
    sky = read_picture(light)
    write_picture(dusk, np.roll(sky, 200, axis=1) * np.array([0.9, 0.45, 0.2], dtype=np.float32), oiio.FLOAT)
    scene = (study.path("quarters_white.ndf.exr"), "--green", "up", "--source", study.path("quarters_normal.png"),
             "--mesh", study.torus(), "--repeat", "3", "--up", "0,0,1", "--camera", "0.9,-2.2,1.7,0,0,0,40",
             "--environment", light, "--to-environment", dusk, "--to-environment-turn", "90", "--diffuse", "0.35",
             "--specular", "0.3", "--brdf", "blinn-phong:12", "--exposure", "0.5")
    errors, costs = [], []
    for mode, words in (("sh", "harmonics, order 8"), ("prefiltered", "filtered maps")):
        folder, report = study.path(f"changing_{mode}"), study.path(f"changing_{mode}.json")
        run = lambda *more: study.run("multum-view", "animate", *scene, "--environment-mode", mode, "-o", folder,
                                      "--report", report, *more)
        run("--frames", 3, "--size", "120x90", "--compare", f"{REFERENCE},mip", "--samples", min(study.samples, 64),
            "--no-background")
        rows = [{row["name"]: row for row in frame} for frame in json.loads(report.read_text())["pictures"]]
        for name, key in ((words, "multum"), (f"averaged normals, {words}", "mip")):
            errors.append([name, *[percent(frame[key]["relative_l1"]) for frame in rows]])
        run("--frames", frames, *FRAME)
        costs.append([words, [frame[0]["environment_processor_ms"]
                              for frame in json.loads(report.read_text())["pictures"]]])
    study.strip("changing_light", [(box_reduced(read_picture(folder / f"frame_{k:04}.png")[:, :, :3], 2),
                                    f"frame {k + 1}") for k in range(frames)], kind="jpg")
    study.table(["relative L1", "first frame", "in the middle", "last"], errors)
    study.table(["processor time per frame, ms", "new environment, 512 x 256", "mixture of two environments",
                 "transfer to the shader"],
                [[words, f"{spent[0]['made']:.0f}", f"{np.median([s['made'] for s in spent[1:-1]]):.1f}",
                  f"{np.median([s['set'] for s in spent[1:-1]]):.0f}"] for words, spent in costs])


def shininess(study, material):
    study.heading("Figures 6 and 8: another scale, shininess and light, without a new bake")
    without = list(material)
    at = without.index("--brdf")
    del without[at:at + 2]
    rows = []
    for s in (10, 50, 200, 1000):
        view = study.view(f"shininess{s}", "quarters", *without, "--brdf", f"blinn-phong:{s}",
                          compare=(REFERENCE, "toksvig", "toksvig-points", "lean-jacobian-points"))
        study.figures([(view[REFERENCE], f"reference, s = {s}"), (view["multum"], "six lobes"),
                       (view["toksvig"], "Toksvig")], name="shininess")
        rows.append([s, *[percent(relative_l1(view[n], view[REFERENCE]))
                          for n in ("multum", "toksvig", "toksvig-points", "lean-jacobian-points")]])
    study.table(["s", "six lobes", "Toksvig", LABELS["toksvig-points"], LABELS["lean-jacobian-points"]], rows)


def starts(study):
    """Section 7.1: the start of lobes by Hochbaum and Shmoys, compared with the search."""
    source = study.path("quarters_normal.png")
    study.heading("Section 7.1: where EM starts")
    study.paragraph("For each texel, the paper starts EM from those lobes of the child texels that are farthest apart",
                    "(Hochbaum and Shmoys). multum starts each texel with the lobes of the parent texel, so "
                    "only the coarsest texel needs other starting lobes. The table compares two ways to choose "
                    "them: the normals that are farthest apart, and the default search "
                    "(docs/contributing/ALGORITHMS.md).")
    shown, rows = [], []
    for count in (4, 6):
        views = {}
        for words, name, options in (("farthest apart", "farthest", ("--farthest-start",)),
                                     ("searched", "searched", ())):
            bake = study.bake(f"start_{name}{count}", source, "--green", "up", "--lobes", str(count), *options)
            view = views[words] = study.view(f"start_{name}{count}", f"start_{name}{count}", "--source", source,
                                             "--green", "up", "--brdf", "blinn-phong:100", "--diffuse", "0.4",
                                             "--specular", "0.15", *FRAME, compare=(REFERENCE,))
            rows.append([f"{count} lobes, {words}", percent(relative_l1(view["multum"], view[REFERENCE])),
                         *[percent(measured(bake, level, "blinn-phong:100")) for level in (3, 5, 7)]])
        shown += [(views["searched"][REFERENCE], "reference")] if not shown else []
        shown += [(view["multum"], f"{count} lobes, {words}") for words, view in views.items()]
    study.strip("starts", [(srgb(picture), caption) for picture, caption in shown], kind="jpg")
    study.table(["start", "picture, s = 100", "level 3", "level 5", "level 7"], rows)


def lobe_counts(study):
    source = study.testmap("scales", "--quarter", "armour", size=256)
    normals = read_normals(source)
    directions, inside = disk(120)
    level, row, column = 5, 3, 3
    block = normals[row << level:(row + 1) << level, column << level:(column + 1) << level].reshape(-1, 3)
    reference = density_of_normals(block, directions)
    study.heading("Figure 7: the normals of one texel, as one to six lobes and as planar Gaussians")
    study.paragraph("The texel is on level 5 of the map of scales, and its normals are tilted by up to 72 "
                    "degrees. Near the rim of the disk, a planar Gaussian becomes a broad smear on the sphere. The "
                    "error "
                    "is the difference between the densities in the pictures, integrated over solid angle.")
    shown, rows = [(picture(reference, inside, reference.max()), "the normals")], []
    for count in range(1, 7):
        vmf_bake = study.bake(f"scales_vmf{count}", source, "--green", "up", "--lobes", str(count))
        gmm_bake = study.bake(f"scales_gmm{count}", source, "--green", "up", "--lobes", str(count), "--ndf", "gmm")
        density = density_of_lobes(read_lobes(study.path(f"scales_vmf{count}.ndf.exr"), level)[:, row, column],
                                   directions)
        shown.append((picture(density, inside, reference.max()), f"{count} lobe{'s' if count > 1 else ''}"))
        rows.append([count, percent(density_error(density, reference, directions, inside)),
                     *[percent(measured(bake, level, "blinn-phong:100")) for bake in (vmf_bake, gmm_bake)]])
    study.figures(shown, name="lobes", small=True)
    study.table(["lobes", "density, vmf", "highlight s = 100, level 5, vmf", "highlight, gmm"], rows)


def measured(bake, level, brdf):
    return next(one["relative_l1"] for one in bake["measured_error"]
                if one["level"] == level and one["point"] == "centre" and one["brdf"].startswith(brdf))


def reproduce(study):
    v_groove(study)
    material = methods(study)
    harmonics(study)
    measured_materials(study)
    draped_cloth(study)
    shininess(study, material)
    lobe_counts(study)
    starts(study)
    environment_light(study)
    changing_light(study)
