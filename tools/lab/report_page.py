# SPDX-License-Identifier: Apache-2.0
"""Makes parts of the pages that tools/demo and tools/lab/reproduce write. These parts are the style, tables, charts,
and a description of the machine."""
import html
import math
import os
import pathlib
import platform

import committed_tree

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
.wide { overflow-x: auto; margin: .5rem 0; background:
    no-repeat linear-gradient(to right, var(--back) 30%, #0000) 0 / 2rem 100% local,
    no-repeat linear-gradient(to left, var(--back) 30%, #0000) 100% / 2rem 100% local,
    no-repeat linear-gradient(to right, var(--line), #0000) 0 / .6rem 100%,
    no-repeat linear-gradient(to left, var(--line), #0000) 100% / .6rem 100%; }
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
    """Makes an HTML table. Rows are lists of cells. A cell is text or (text, class)."""
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
    """Returns the distance between grid lines, which is 1, 2 or 5 times a power of ten. There are four to ten grid
    lines up to `top`."""
    power = 10.0 ** math.floor(math.log10(top / 4)) if top > 0 else 1.0
    return next(power * m for m in (1, 2, 5, 10) if top / (power * m) <= 6)


def chart(title, unit, labels, series, bars=False, axis="level"):
    """Draws an SVG of lines or bars. Series are (name, values by label, with None for missing values) over labels of
    `axis`."""
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
    out.append(f'<text x="{(width + left) / 2}" y="{height - 4}" text-anchor="middle">{text(axis)}</text>')
    for s, (name, values) in enumerate(series):
        points = [(x_of(i), y_of(v), labels[i], v) for i, v in enumerate(values) if v is not None]
        marks = ""
        for x, y, label, v in points:
            tip = f"<title>{text(name)}, {text(axis)} {text(label)}: {v:.3g}</title>"
            if bars:
                bar = 0.8 * slot / len(series)
                marks += (f'<rect class="bar" x="{x - 0.4 * slot + s * bar:.1f}" y="{y:.1f}" width="{bar * 0.92:.1f}" '
                          f'height="{y_of(0) - y:.1f}">{tip}</rect>')
            else:
                marks += f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3">{tip}</circle>'
        line = "" if bars else '<polyline points="' + " ".join(f"{x:.1f},{y:.1f}" for x, y, *_ in points) + '"/>'
        out.append(f'<g class="{SERIES[s % len(SERIES)]}">{line}{marks}</g>')
    return "".join(out) + "</svg>"


def first_value(path, key):
    """Returns the value of the first line "KEY=VALUE" or "KEY : VALUE", or an empty string if there is none."""
    try:
        lines = pathlib.Path(path).read_text(errors="replace").splitlines()
    except OSError:
        return ""
    found = next((line for line in lines if line.startswith(key)), "=")
    return found.split("=" if "=" in found else ":", 1)[1].strip().strip('"')


def machine_rows(devices, contexts, versions):
    """Describes the machine and the software of a page's figures: (what, its name)."""
    commit = f"commit {committed_tree.commit_of()}"  # ends in -dirty if the sources are not committed
    rows = [["processor", first_value("/proc/cpuinfo", "model name") or platform.machine()],
            ["logical cores", len(os.sched_getaffinity(0))],
            ["system", first_value("/etc/os-release", "PRETTY_NAME") or platform.platform()],
            ["OpenCL", ", ".join(sorted(devices))],
            ["GL", ", ".join(sorted(contexts))],
            ["multum", ", ".join(sorted(versions)) +
             (f", {commit}" if commit else "")]]
    return [r for r in rows if r[1]]


def machine(devices, contexts, versions):
    return table(["", ""], machine_rows(devices, contexts, versions))


def machine_words(devices, contexts, versions):
    return "; ".join(f"{what}: {name}" for what, name in machine_rows(devices, contexts, versions))
