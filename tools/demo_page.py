#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes index.html into a folder that tools/demo has filled: pictures, errors, times. Standard library only.

Reads steps.tsv (kind, name, milliseconds, command: one line a step), NAME.bake.json of each bake and NAME.view.json of
each view; a view's pictures are NAME_truth.png, NAME_multum.png and so on. The page refers to nothing outside the
folder.

  tools/demo_page.py FOLDER
"""
import argparse
import html
import json
import math
import os
import pathlib
import platform
import subprocess
import sys

METHODS = {
    "truth": ("truth", "the finest map, sampled many times a pixel: slow, and what the others aim at"),
    "multum": ("multum", "the baked distribution of normals"),
    "mip": ("averages", "averaged normals: the plain mip pyramid of most engines"),
    "toksvig": ("Toksvig", "averaged normals with a wider highlight where they disagree"),
    "lean-jacobian": ("LEAN", "one Gaussian of slopes a texel"),
}
BAKES = {
    "white": "the four-quarter map (spheres, rings, grooves, noise)",
    "coloured": "the same with its colours, one a lobe",
    "terrain": "measured terrain: the Jacksboro fault, heights four times exaggerated",
}
VIEWS = {
    "plain": ("A plain to the horizon", "Each side of a groove has its own colour; seen from one side, only that one "
              "should show. Averaging mixes them before anyone looks."),
    "ring": ("A ring, seen from all angles", "Highlights that split into arcs and stars have more than one direction: "
             "one Gaussian, or one average, cannot say so."),
    "near": ("Closer, without colour, sharp highlights", "Near the viewer all filtered pictures lose something to the "
             "smooth magnification of texels, which the truth does not do."),
    "terrain": ("Measured terrain", "Rough ground without a pattern: the hardest of these maps for four lobes a "
                "texel."),
}
SERIES = ["c1", "c2", "c3", "c4"]

STYLE = """
:root { color-scheme: light dark; --back: #fdfdfb; --text: #1d2329; --soft: #5b6670; --line: #d5d9dc; --box: #f1f3f2;
  --c1: #1b6ca8; --c2: #b35900; --c3: #287d3c; --c4: #8a3fa0; --link: #1b5e96; }
@media (prefers-color-scheme: dark) {
  :root { --back: #15191d; --text: #e3e7ea; --soft: #a0abb4; --line: #39424a; --box: #1f252b;
    --c1: #6db6ee; --c2: #f0a35a; --c3: #78c98a; --c4: #cf95e2; --link: #8cc5f2; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 76rem; padding: 1rem 1.2rem 3rem; background: var(--back); color: var(--text);
  font: 1rem/1.5 system-ui, sans-serif; }
h1 { margin: .3em 0; font-size: 1.7rem; } h2 { margin: 2.2rem 0 .4rem; } h3 { margin: 1.4rem 0 .3rem; }
p { max-width: 46rem; margin: .4rem 0; } a { color: var(--link); } .soft, figcaption { color: var(--soft); }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(13.5rem, 100%), 1fr)); gap: .7rem; }
.pictures.first { grid-template-columns: repeat(auto-fit, minmax(min(18rem, 100%), 1fr)); }
figure { margin: 0; min-width: 0; } figure img { display: block; width: 100%; height: auto; background: #000; }
figcaption { font-size: .88rem; margin-top: .2rem; } figcaption b { color: var(--text); }
.wide { overflow-x: auto; margin: .5rem 0; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .92rem; }
th, td { padding: .22rem .7rem; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; white-space: normal; }
@media (max-width: 40rem) { th, td { padding: .22rem .3rem; font-size: .85rem; } }
th { color: var(--soft); font-weight: 600; } td.best { font-weight: 700; }
pre { white-space: pre-wrap; overflow-wrap: anywhere; background: var(--box); padding: .7rem .9rem;
  border-radius: 4px; font-size: .87rem; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(25rem, 100%), 1fr)); gap: 1rem; }
svg { display: block; width: 100%; height: auto; } svg text { fill: var(--soft); font: 12px system-ui, sans-serif; }
svg .axis { stroke: var(--line); } details { margin: .4rem 0; } summary { cursor: pointer; color: var(--link); }
.c1 { --c: var(--c1); } .c2 { --c: var(--c2); } .c3 { --c: var(--c3); } .c4 { --c: var(--c4); }
svg polyline { fill: none; stroke: var(--c); stroke-width: 2; } svg circle, svg rect.bar { fill: var(--c); }
.key span { display: inline-block; margin-right: 1.1rem; } .key i { display: inline-block; width: .8rem; height: .8rem;
  margin-right: .35rem; background: var(--c); }
"""


def text(value):
    return html.escape(str(value), quote=True)


def percent(value):
    return f"{100 * value:.1f} %" if value >= 0.0995 else f"{100 * value:.2g} %"


def table(head, rows):
    """Rows are lists of cells; a cell is text, or (text, class)."""
    def cell(one):
        content, kind = one if isinstance(one, tuple) else (one, "")
        return f'<td class="{kind}">{text(content)}</td>' if kind else f"<td>{text(content)}</td>"
    lines = ["<tr>" + "".join(f"<th>{text(h)}</th>" for h in head) + "</tr>"]
    lines += ["<tr>" + "".join(map(cell, row)) + "</tr>" for row in rows]
    return '<div class="wide"><table>' + "\n".join(lines) + "</table></div>"


def key(names):
    return ('<p class="key">' + "".join(f'<span class="{colour}"><i></i>{text(name)}</span>'
                                         for colour, name in zip(SERIES, names)) + "</p>")


def nice_step(top):
    """The 1, 2 or 5 times a power of ten that gives four to ten grid lines up to `top`."""
    power = 10.0 ** math.floor(math.log10(top / 4)) if top > 0 else 1.0
    return next(power * m for m in (1, 2, 5, 10) if top / (power * m) <= 6)


def chart(title, unit, labels, series, bars=False):
    """An SVG of series (name, values by label; None where there is none) over labels: lines, or grouped bars."""
    width, height, left, right, top, bottom = 480, 250, 46, 8, 22, 36
    peak = max([v for _, values in series for v in values if v is not None] + [1e-6])
    step = nice_step(peak)
    span = step * math.ceil(peak / step - 1e-9)
    slot = (width - left - right) / max(1, len(labels))
    x_of = lambda i: left + slot * (i + 0.5)
    y_of = lambda v: top + (height - top - bottom) * (1 - v / span)
    out = [f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="{text(title)}"><title>{text(title)}</title>',
           f'<text x="2" y="12">{text(unit)}</text>']
    for i in range(round(span / step) + 1):
        y = y_of(i * step)
        out.append(f'<line class="axis" x1="{left}" x2="{width - right}" y1="{y:.1f}" y2="{y:.1f}"/>'
                   f'<text x="{left - 5}" y="{y + 4:.1f}" text-anchor="end">{i * step:.4g}</text>')
    out += [f'<text x="{x_of(i):.1f}" y="{height - 19}" text-anchor="middle">{text(label)}</text>'
            for i, label in enumerate(labels)]
    out.append(f'<text x="{(width + left) / 2}" y="{height - 4}" text-anchor="middle">level</text>')
    for s, (name, values) in enumerate(series):
        points = [(x_of(i), y_of(v), labels[i], v) for i, v in enumerate(values) if v is not None]
        marks = ""
        for x, y, label, v in points:
            tip = f"<title>{text(name)}, level {text(label)}: {v:.3g}</title>"
            if bars:
                bar = 0.8 * slot / len(series)
                marks += (f'<rect class="bar" x="{x - 0.4 * slot + s * bar:.1f}" y="{y:.1f}" width="{bar * 0.92:.1f}" '
                          f'height="{y_of(0) - y:.1f}">{tip}</rect>')
            else:
                marks += f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3">{tip}</circle>'
        line = "" if bars else '<polyline points="' + " ".join(f"{x:.1f},{y:.1f}" for x, y, *_ in points) + '"/>'
        out.append(f'<g class="{SERIES[s % len(SERIES)]}">{line}{marks}</g>')
    return "".join(out) + "</svg>"


def machine(bakes, views):
    def first_line(path, start):
        try:
            lines = pathlib.Path(path).read_text(errors="replace").splitlines()
        except OSError:
            return ""
        found = next((line for line in lines if line.startswith(start)), "=")
        return found.split("=" if "=" in found else ":", 1)[1].strip().strip('"')
    commit = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True, check=False,
                            cwd=pathlib.Path(__file__).parent) if has_program("git") else None
    rows = [["processor", first_line("/proc/cpuinfo", "model name") or platform.machine()],
            ["logical cores", len(os.sched_getaffinity(0))],
            ["system", first_line("/etc/os-release", "PRETTY_NAME") or platform.platform()],
            ["OpenCL", ", ".join(sorted({b["device"] for b in bakes.values()}))],
            ["GL", ", ".join(sorted({v["context"] for v in views.values()}))],
            ["multum", ", ".join(sorted({v["software"].split()[-1] for v in views.values()})) +
             (f", commit {commit.stdout.strip()}" if commit and commit.returncode == 0 else "")]]
    return table(["", ""], [r for r in rows if r[1]])


def has_program(name):
    return any(os.access(os.path.join(folder, name), os.X_OK) for folder in os.get_exec_path())


def errors_by_level(bake, brdf, points):
    """The worst error of the points, by level; the 1 x 1 level has no neighbours to be midway between."""
    found = {}
    for one in bake["measured_error"]:
        if one["brdf"] == brdf and one["point"] in points and one["samples"] > 0:
            found[one["level"]] = max(found.get(one["level"], 0.0), one["relative_l1"])
    return found


def bake_section(name, bake, step):
    brdfs = list(dict.fromkeys(e["brdf"] for e in bake["measured_error"]))
    # The lobes of a coloured bake are those of the white one: its colours are what is new.
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
    stages = ", ".join(f"{s['name']} {s['seconds']:.2f}" for s in bake["stages"])
    counts = bake["counts"]
    percent_series = [(n, [100 * centre[b][l] if l in centre[b] else None for l in labels])
                      for n, b in zip(names, brdfs)]
    errors = chart(f"{name}: {what} by level, in percent", f"{what} at texel centres, %", labels, percent_series)
    seconds = [("fit", [level["seconds"] for level in bake["levels"]])]
    return f"""<h3 id="bake-{text(name)}">{text(BAKES.get(name, name))}</h3>
<p>Seconds: {text(stages)}; the whole command took {step["seconds"]:.1f}. {counts["lobes"]} lobes fitted,
{counts["nonfinite"]} of them not finite, {counts["kappa_clamped"]} sharper than the cap, {counts["dead_lobes"]}
without normals.</p>
<p class="soft">Found: {text(bake["input"]["encoding"])}.</p>
<div class="charts">
<figure>{errors}
{key(names)}</figure>
<figure>{chart(f"{name}: seconds by level", "fit, seconds", labels, seconds, bars=True)}</figure></div>
<details><summary>the numbers</summary>
<p>The {what}, relative L1, at texel centres | midway between texels (the worse of x and y), and seconds of the
fit.</p>
{table(["level", *names, "seconds"], rows)}</details>"""


def picture(folder, name, method, caption, kind):
    file = f"{name}_{method}{kind}.png"
    if not (folder / file).is_file():
        return ""
    label = METHODS[method][0]
    alt = f"{VIEWS.get(name, (name,))[0]}: {label}"
    if kind:
        alt += ", difference from the truth, four times as bright"
    return (f'<figure><a href="{text(file)}"><img src="{text(file)}" alt="{text(alt)}" loading="lazy"></a>'
            f"<figcaption>{caption}</figcaption></figure>")


def view_section(folder, name, view, step):
    title, what = VIEWS.get(name, (name, ""))
    shown, differences = [], []
    for one in view["pictures"]:
        method = one["name"]
        error = f', <b>{percent(one["relative_l1"])}</b> off' if "relative_l1" in one else ""
        label = text(METHODS[method][0])
        shown.append(picture(folder, name, method, f"<b>{label}</b>{error}", ""))
        if error:
            differences.append(picture(folder, name, method, f"{label}{error}", "_difference"))
    errors = [one["relative_l1"] for one in view["pictures"] if "relative_l1" in one]
    rows = [[METHODS[one["name"]][0],
             (percent(one["relative_l1"]), "best" if one["relative_l1"] == min(errors) else "")
             if "relative_l1" in one else "-",
             f'{one["rmse"]:.4f}' if "rmse" in one else "-", f'{one["frame_time_ms"]:.0f}'] for one in view["pictures"]]
    return f"""<h3 id="view-{text(name)}">{text(title)}</h3><p>{text(what)}</p>
<div class="pictures">{"".join(shown)}</div>
<details><summary>where they are off, and by how much</summary><div class="pictures">{"".join(differences)}</div>
{table(["picture", "relative L1", "RMSE", "frame, ms"], rows)}
<p>Differences are four times as bright as they are. Times are this machine's, one frame each.</p></details>
<details><summary>the command</summary><pre>{text(step["command"])}</pre></details>"""


def own_map():
    return """<h2 id="own">The same with your own map</h2>
<pre>build/release/bin/multum bake bricks_normal.png -o bricks.ndf.exr
build/release/bin/multum-view bricks.ndf.exr -o bricks.png \\
    --source bricks_normal.png --compare truth,mip,toksvig,lean-jacobian</pre>
<p>The bake prints what it took the file for: OpenGL or DirectX green, unsigned or signed, normals or heights. If it is
wrong, say so (<code>--green up</code>, <code>--bumpformat height --height-scale 8</code>), to both programs. With
colours: <code>--albedo bricks_colour.png</code>, to both as well. More accuracy: <code>--lobes 6</code>; less time:
<code>--lobes 2 --sweeps 1</code>. <code>multum bake --help</code> lists the rest.</p>"""


def make_page(folder, steps, bakes, views):
    first = next(iter(views), None)
    hero = ""
    if first:
        shown = {one["name"]: one for one in views[first]["pictures"]}
        hero = '<div class="pictures first">' + "".join(
            picture(folder, first, m, f'<b>{text(METHODS[m][0])}</b>: {text(METHODS[m][1])}', "")
            for m in ("truth", "multum", "mip") if m in shown) + "</div>"
    methods = [m for m in METHODS if m != "truth"]
    summary = []
    for name, view in views.items():
        error = {one["name"]: one["relative_l1"] for one in view["pictures"] if "relative_l1" in one}
        summary.append([VIEWS.get(name, (name,))[0], *[
            (percent(error[m]), "best" if error[m] == min(error.values()) else "") if m in error else "-"
            for m in methods]])
    total = [[{"bake": "bake ", "view": "view "}.get(s["kind"], "") + s["name"], f"{s['seconds']:.1f}"] for s in steps]
    samples = sorted({view["truth_samples"] for view in views.values()})
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>multum: the demo</title><style>{STYLE}</style></head><body>
<h1>multum: textures that look right at every distance</h1>
<p>A pixel of a distant wall covers thousands of normals. Averaging them, as mip-mapping does, draws a smooth wall.
multum stores how they are distributed instead. Click a picture for its full size.</p>
{hero}
<h2>How far off, in short</h2>
<p>Relative L1: the sum of absolute differences from the truth, divided by the truth's sum, over the whole picture.</p>
{table(["view", *[METHODS[m][0] for m in methods]], summary)}
<h2>Pictures</h2>
<p class="soft">The truth takes {text(" or ".join(map(str, samples)))} samples a pixel of the finest map. All
pictures of a view have the same camera, light, material and texture filter.</p>
{"".join(view_section(folder, name, view, step_of(steps, "view", name)) for name, view in views.items())}
<h2>Bakes</h2>
<p>The error of a bake is measured before it is written, on the rounded values, at random texels, for 12 fixed half
vectors (4 lights for lambert), against a sum over every normal that the texel covers. blinn-phong:500 is a sharp
highlight, lambert is matt.</p>
{"".join(bake_section(name, bake, step_of(steps, "bake", name)) for name, bake in bakes.items())}
<h2>Time</h2>
<p>Seconds of each command, from start to end, on the machine below; a first run also compiles the kernels.</p>
{table(["command", "seconds"], total)}
{machine(bakes, views)}
{own_map()}
</body></html>
"""


def step_of(steps, kind, name):
    return next(s for s in steps if s["kind"] == kind and s["name"] == name)


def read_folder(folder):
    steps = []
    for line in (folder / "steps.tsv").read_text().splitlines():
        kind, name, milliseconds, command = line.split("\t")
        steps.append({"kind": kind, "name": name, "seconds": int(milliseconds) / 1000, "command": command})
    read = lambda kind: {s["name"]: json.loads((folder / f"{s['name']}.{kind}.json").read_text())
                         for s in steps if s["kind"] == kind}
    return steps, read("bake"), read("view")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    folder = parser.parse_args().folder
    try:
        page = make_page(folder, *read_folder(folder))
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"{folder}: {type(error).__name__}: {error}; expected what tools/demo leaves there")
    target = folder / "index.html"
    partial = folder / "index.html.tmp"
    partial.write_text(page, encoding="utf-8")
    partial.replace(target)


if __name__ == "__main__":
    main()
