#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes index.html, with pictures, errors and times, into a folder that tools/demo has filled. Uses only the standard
library.

Reads steps.tsv (one line per step: kind, name, milliseconds, command), NAME.bake.json of each bake, and NAME.view.json
of each view and of each picture of a material, NAME-near and NAME-far. The pictures of a view are NAME_reference.png,
NAME_multum.png and so on. The page refers only to files in the folder.

  tools/lab/demo_page.py FOLDER [--programs DIR]
"""
import argparse
import json
import pathlib
import sys

from report_page import STYLE, chart, key, machine, percent, table, text

METHODS = {
    "reference": ("reference", "the finest map with many samples per pixel: slow, and the standard for the others"),
    "multum": ("multum", "the baked distribution of normals"),
    "mip": ("averages", "averaged normals: the plain mip pyramid of most engines"),
    "toksvig": ("Toksvig", "averaged normals, with wider highlights where normals vary"),
    "lean-jacobian": ("LEAN", "one Gaussian of slopes per texel"),
}
MATERIALS = {
    "hammered": "Hammered metal",
    "car-paint": "Car paint",
    "water": "Water",
    "denim": "Denim",
    "bricks": "Bricks",
}
COMPARE_STYLE = """
.materials { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(28rem, 100%), 1fr)); gap: 1rem 1.25rem; }
.compare { margin: 0; }
.compare .stage { position: relative; }
.compare img { display: block; width: 100%; height: auto; }
.compare .over { position: absolute; inset: 0; clip-path: inset(0 0 0 var(--split)); }
.compare .line { position: absolute; top: 0; bottom: 0; left: var(--split); width: 2px; margin-left: -1px;
  background: #fff; pointer-events: none; }
.compare input { width: 100%; min-height: 2rem; margin: .2rem 0; }
.compare .sides { display: flex; justify-content: space-between; gap: .5rem; }
.compare select { font: inherit; min-height: 2.2rem; max-width: 48%; color: var(--text); background: var(--box);
  border: 1px solid var(--line); border-radius: 4px; }
"""
COMPARE_SCRIPT = """
for (const figure of document.querySelectorAll(".compare")) {
  const stage = figure.querySelector(".stage"), [under, over] = stage.querySelectorAll("img");
  const range = figure.querySelector("input"), [left, right] = figure.querySelectorAll("select");
  const move = () => stage.style.setProperty("--split", `${range.value}%`);
  const show = (image, select) => { image.src = select.value;
    image.alt = `${figure.dataset.title}: ${select.selectedOptions[0].text}`; };
  range.addEventListener("input", move);
  left.addEventListener("change", () => show(under, left));
  right.addEventListener("change", () => show(over, right));
  move(); // browsers restore the values of forms
  show(under, left);
  show(over, right);
  stage.addEventListener("pointermove", (event) => {
    if (event.buttons === 0 && event.pointerType !== "mouse") return;
    const box = stage.getBoundingClientRect();
    range.value = 100 * (event.clientX - box.left) / box.width;
    move();
  });
}
"""
BAKES = {
    "white": "the four-quarter map (spheres, rings, grooves, noise)",
    "coloured": "the four-quarter map with colours, one per lobe",
    "terrain": "measured terrain: the Jacksboro fault, with heights scaled by 4",
}
VIEWS = {
    "plain": ("A plain to the horizon", "Each side of a groove has its own colour. From one side, only the colour of "
              "that side should be visible. Averaging mixes both colours beforehand."),
    "ring": ("A ring, seen from all angles", "Highlights that split into arcs and stars have more than one direction. "
             "One Gaussian or one average cannot represent them."),
    "near": ("Closer, without colour, sharp highlights", "Near the viewer, all filtered pictures magnify texels "
             "smoothly. The reference does not, so they differ from it."),
    "terrain": ("Measured terrain", "Rough ground without a pattern: the hardest of these maps for four lobes per "
                "texel."),
}
def errors_by_level(bake, brdf, points):
    """Returns the worst error of all points, by level. The 1 x 1 level has no point midway between texels."""
    found = {}
    for one in bake["measured_error"]:
        if one["brdf"] == brdf and one["point"] in points and one["samples"] > 0:
            found[one["level"]] = max(found.get(one["level"], 0.0), one["relative_l1"])
    return found


def fit_parts(bake):
    """Divides the time of the fit into rows (name, seconds). The levels come first, then the rest, and the sum of the
    rows is the time of the whole stage."""
    parts = [(str(level["level"]), level["seconds"]) for level in bake["levels"]]
    if "start" in bake:
        parts.append(("start", bake["start"]["seconds"]))
    fit = sum(stage["seconds"] for stage in bake["stages"] if stage["name"] == "fit")
    return parts + [("rest", max(0.0, fit - sum(seconds for _, seconds in parts)))]


def bake_section(name, bake, step):
    brdfs = list(dict.fromkeys(e["brdf"] for e in bake["measured_error"]))
    # A bake with colours has the same lobes as the bake without colours, so only the errors with colours are new.
    coloured = [b for b in brdfs if b.endswith(" coloured")]
    brdfs = coloured or brdfs
    names = [b.removesuffix(" coloured") for b in brdfs]
    what = "error with colours" if coloured else "error"
    labels = [level["level"] for level in bake["levels"]]
    rows = []
    centre = {b: errors_by_level(bake, b, ("centre",)) for b in brdfs}
    midway = {b: errors_by_level(bake, b, ("midway-x", "midway-y")) for b in brdfs}
    for level in bake["levels"]:
        cells = [f"{percent(centre[b].get(level['level'], 0))} | "
                 f"{percent(midway[b][level['level']]) if level['level'] in midway[b] else '-'}" for b in brdfs]
        rows.append([f"{level['level']}: {level['width']} x {level['height']}", *cells, f"{level['seconds']:.3f}"])
    parts = fit_parts(bake)
    rows += [[part, *["-"] * len(brdfs), f"{seconds:.3f}"] for part, seconds in parts[len(bake["levels"]):]]
    rows.append(["together", *["-"] * len(brdfs), f"{sum(seconds for _, seconds in parts):.3f}"])
    outside = step["seconds"] - sum(s["seconds"] for s in bake["stages"])
    stages = ", ".join(f"{s['name']} {s['seconds']:.2f}" for s in
                       [*bake["stages"], {"name": "starting and ending", "seconds": max(0.0, outside)}])
    counts = bake["counts"]
    percent_series = [(n, [100 * centre[b][l] if l in centre[b] else None for l in labels])
                      for n, b in zip(names, brdfs)]
    errors = chart(f"{name}: {what} by level, in percent", f"{what} at texel centres, %", labels, percent_series)
    seconds = chart(f"{name}: seconds of the fit", f"fit, seconds: {sum(s for _, s in parts):.2f} together",
                    [part for part, _ in parts], [("fit", [s for _, s in parts])], bars=True, axis="level")
    return f"""<h3 id="bake-{text(name)}">{text(BAKES.get(name, name))}</h3>
<p>Seconds: {text(stages)}; the whole command took {step["seconds"]:.2f}. {counts["lobes"]} lobes fitted,
{counts["nonfinite"]} of them not finite, {counts["kappa_clamped"]} sharper than the limit, {counts["dead_lobes"]}
without normals.</p>
<p class="soft">Detected: {text(bake["input"]["encoding"])}.</p>
<div class="charts">
<figure>{errors}
{key(names)}</figure>
<figure>{seconds}
<figcaption>Start is the search for the first lobes of the coarsest level. Rest is binning of normals, compiling
kernels and copying data.</figcaption></figure></div>
<details><summary>the numbers</summary>
<p>The {what} is relative L1, at texel centres | midway between texels (the worse of x and y). Seconds are seconds
of the fit.</p>
{table(["level", *names, "seconds"], rows)}</details>"""


def picture(folder, name, method, caption, kind, size=""):
    """`size` contains HTML attributes that reserve space for a picture before it is loaded."""
    file = f"{name}_{method}{kind}.png"
    if not (folder / file).is_file():
        return ""
    label = METHODS[method][0]
    alt = f"{VIEWS.get(name, (name,))[0]}: {label}"
    if kind:
        alt += ", difference from the reference, four times as bright"
    return (f'<figure><a href="{text(file)}"><img src="{text(file)}" alt="{text(alt)}"{size}></a>'
            f"<figcaption>{caption}</figcaption></figure>")


def view_section(folder, name, view, step):
    title, what = VIEWS.get(name, (name, ""))
    size = f' width="{view["width"]}" height="{view["height"]}"' if "width" in view else ""
    shown, differences = [], []
    for one in view["pictures"]:
        method = one["name"]
        error = f', error <b>{percent(one["relative_l1"])}</b>' if "relative_l1" in one else ""
        label = text(METHODS[method][0])
        shown.append(picture(folder, name, method, f"<b>{label}</b>{error}", "", size))
        # These pictures have the same order as the pictures above, whose first column is the reference.
        differences.append(picture(folder, name, method, f"<b>{label}</b> minus reference{error}", "_difference", size)
                           if error else picture(folder, name, method, f"<b>{label}</b>", "", size))
    errors = [one["relative_l1"] for one in view["pictures"] if "relative_l1" in one]
    rows = [[METHODS[one["name"]][0],
             (percent(one["relative_l1"]), "best" if one["relative_l1"] == min(errors) else "")
             if "relative_l1" in one else "-",
             f'{one["rmse"]:.4f}' if "rmse" in one else "-", f'{one["frame_time_ms"]:.0f}'] for one in view["pictures"]]
    return f"""<h3 id="view-{text(name)}">{text(title)}</h3><p>{text(what)}</p>
<div class="pictures">{"".join(shown)}</div>
<details><summary>where they are off, and by how much</summary><div class="pictures">{"".join(differences)}</div>
{table(["picture", "relative L1", "RMSE", "frame, ms"], rows)}
<p>Differences are shown four times as bright. Times are for one frame on this machine.</p></details>
<details><summary>the command</summary><pre>{text(step["command"])}</pre></details>"""


def compare_figure(material, place, view):
    """Returns two pictures of a material, one over the other, with a slider that moves the border between them."""
    name = f"{material}-{place}"
    errors = {one["name"]: one["relative_l1"] for one in view["pictures"] if "relative_l1" in one}
    options = lambda chosen: "".join(
        f'<option value="{text(name)}_{method}.png"{" selected" if method == chosen else ""}>{label}</option>'
        for method, (label, _) in METHODS.items() if method == "reference" or method in errors)
    image = lambda side, method: (f'<img class="{side}" src="{text(name)}_{method}.png" alt="{METHODS[method][0]}" '
                                  f'width="{view["width"]}" height="{view["height"]}">')
    least = min(errors.values())
    shown = ", ".join(f"<b>{METHODS[one][0]} {percent(error)}</b>" if error == least else
                      f"{METHODS[one][0]} {percent(error)}" for one, error in errors.items())
    title = f"{MATERIALS[material]}, {'near' if place == 'near' else 'far away'}"
    return f"""<figure class="compare" data-title="{title}">
<div class="stage" style="--split:50%">{image("under", "mip")}
{image("over", "multum")}<span class="line"></span></div>
<input type="range" min="0" max="100" step="0.5" value="50" aria-label="{title}: border between both pictures">
<div class="sides"><select aria-label="{title}, left">{options("mip")}</select>
<select aria-label="{title}, right">{options("multum")}</select></div>
<figcaption>{title}. Error: {shown}</figcaption></figure>"""


def materials_section(folder, materials):
    """Returns the section that the page begins with. `materials` are views by name."""
    shown = [compare_figure(material, place, materials[f"{material}-{place}"])
             for material in MATERIALS for place in ("near", "far") if f"{material}-{place}" in materials]
    look = """<p><a href="look.html"><b>Turn these materials in this browser</b></a>: on a plane, a sphere or a ring,
under a sky or in a studio, next to the reference (WebGL 2).</p>
""" if (folder / "look.html").is_file() else ""
    if not shown:
        return look
    return f"""{look}<p>The border between two pictures follows the pointer or the slider. Errors are relative L1,
against a reference with {samples_of(materials)} samples per pixel. <i>Far away</i> means that the map repeats six times
as often, as it would on a ring six times as large and as far away.</p>
<div class="materials">{"".join(shown)}</div>
"""


def own_map(programs):
    folder = "" if programs in ("/usr/bin", "/usr/local/bin") else text(programs) + "/"
    return f"""<h2 id="own">Use your own map</h2>
<pre>{folder}multum bake bricks_normal.png -o bricks.ndf.exr
{folder}multum-view bricks.ndf.exr -o bricks.png \\
    --source bricks_normal.png --compare reference,mip,toksvig,lean-jacobian
{folder}multum look bricks.ndf.exr --source bricks_normal.png</pre>
<p>The bake prints how it read the file: OpenGL or DirectX green, unsigned or signed, normals or heights. If this is
wrong, give both programs the right options (<code>--green up</code>, <code>--bumpformat height --height-scale
8</code>). For colours, give both programs <code>--albedo bricks_colour.png</code>. For more accuracy, use
<code>--lobes 6</code>; for less time, <code>--lobes 2 --passes 1</code>. <code>multum bake --help</code> lists all
options.</p>"""


def make_page(folder, programs, steps, bakes, views, materials):
    methods = [m for m in METHODS if m != "reference"]
    summary = []
    for name, view in views.items():
        error = {one["name"]: one["relative_l1"] for one in view["pictures"] if "relative_l1" in one}
        summary.append([VIEWS.get(name, (name,))[0], *[
            (percent(error[m]), "best" if error[m] == min(error.values()) else "") if m in error else "-"
            for m in methods]])
    total = [[f"{s['kind']} {s['name']}", f"{s['seconds']:.1f}"] for s in steps]
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>multum: the demo</title><style>{STYLE}{COMPARE_STYLE}</style></head><body>
<h1>multum: textures that look right at every distance</h1>
<p>A pixel of a distant wall covers thousands of normals. Averaging them, as mip-mapping does, draws a smooth wall.
multum stores the distribution of the normals instead.</p>
{materials_section(folder, materials)}
<h2>Test maps</h2>
<p>These maps are hard on purpose; the terrain is measured. Click a picture for its full size.</p>
<h3>Errors</h3>
<p>Relative L1 error is the sum of absolute differences from the reference, divided by the sum of the reference, over
the whole picture.</p>
{table(["view", *[METHODS[m][0] for m in methods]], summary)}
<h3>Pictures</h3>
<p class="soft">The reference takes {samples_of(views)} samples per pixel of the finest map. All
pictures of a view have the same camera, light, material and texture filter.</p>
{"".join(view_section(folder, name, view, step_of(steps, "view", name)) for name, view in views.items())}
<h2>Bakes</h2>
<p>Each bake measures its error before it writes the file. It compares the rounded values with a sum over every normal
of a texel, at random texels, for 12 fixed half vectors (4 lights for lambert). blinn-phong:500 is a sharp highlight,
lambert is matt.</p>
{"".join(bake_section(name, bake, step_of(steps, "bake", name)) for name, bake in bakes.items())}
<h2>Time</h2>
<p>The table has the seconds of each command on the machine below. A first run also compiles the kernels.</p>
{table(["command", "seconds"], total)}
{machine({b["device"] for b in bakes.values()}, {v["context"] for v in views.values()},
         {v["software"].split()[-1] for v in views.values()})}
{own_map(programs)}
<script>{COMPARE_SCRIPT}</script></body></html>
"""


def samples_of(views):
    return " or ".join(map(str, sorted({one["samples"] for view in views.values() for one in view["pictures"]
                                        if "samples" in one})))


def step_of(steps, kind, name):
    return next(s for s in steps if s["kind"] == kind and s["name"] == name)


def read_folder(folder):
    steps = []
    for line in (folder / "steps.tsv").read_text().splitlines():
        kind, name, milliseconds, command = line.split("\t")
        steps.append({"kind": kind, "name": name, "seconds": int(milliseconds) / 1000, "command": command})
    read = lambda kind, file: {s["name"]: json.loads((folder / f"{s['name']}.{file}.json").read_text())
                               for s in steps if s["kind"] == kind}
    return steps, read("bake", "bake"), read("view", "view"), read("material", "view")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--programs", default="build/release/bin",
                        help="folder of the programs, for the page's commands")
    options = parser.parse_args()
    folder = options.folder
    try:
        page = make_page(folder, options.programs, *read_folder(folder))
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"{folder}: {type(error).__name__}: {error}; expected a folder that tools/demo has filled")
    target = folder / "index.html"
    partial = folder / "index.html.tmp"
    partial.write_text(page, encoding="utf-8")
    partial.replace(target)


if __name__ == "__main__":
    main()
