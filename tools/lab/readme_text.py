# SPDX-License-Identifier: Apache-2.0
"""What README.md says in figures: text made from docs/evidence/readme_figures.json and other generated pages of docs/.

README.md has it between <!-- figures: NAME --> and <!-- /figures: NAME -->; nothing measured stands outside them.
Standard library only, so that the check needs neither the programs nor real maps.
"""
import hashlib
import json
import re
import statistics

FIGURES = "docs/evidence/readme_figures.json"
MARK = re.compile(r"<!-- figures: (\w+) -->(.*?)<!-- /figures: \1 -->", re.DOTALL)
# A number with a unit that only a measurement gives.
MEASURED = re.compile(r"\d[\d.,]*(?:\s|-)?(?:%|ms\b|s\b|seconds?\b|minutes?\b|[KMG]i?B\b|bytes\b|times\b)")
LABELS = {"multum": "multum, 4 lobes", "lean": "LEAN", "toksvig": "Toksvig", "mip": "averaged normals"}
FILTERS = {"taps": "default filter, 4 taps", "points": "the same, 4 evaluations per pixel for every method",
           "trilinear": "trilinear filter"}
EVALUATED = "-points"  # the ending of methods that are shaded at as many points as multum takes evaluations


class Unreadable(Exception):
    """A page or JSON file does not have what a figure is taken from."""


def percent(share):
    return f"{100 * share:.1f} %"


def row_of(root, page, pattern):
    """The groups of the one line of docs/evidence/PAGE that matches."""
    found = re.findall(pattern, (root / "docs/evidence" / page).read_text(), re.MULTILINE)
    if len(found) != 1:
        raise Unreadable(f"docs/evidence/{page}: found {len(found)} lines '{pattern}', expected 1")
    return found[0]


def error_of(row, method, ending=""):
    """LEAN is the better of its two variants, with the Jacobian and as printed, for each picture."""
    if method == "lean":
        return min(row["lean" + ending], row["lean-jacobian" + ending])
    if ending and method == "mip":
        return row["points"]
    return row[method] if method == "multum" else row[method + ending]


def best_rival(row):
    """At equal evaluations."""
    return min(error_of(row, "lean", EVALUATED), error_of(row, "toksvig", EVALUATED), row["points"])


# ---- the picture


def picture(figures, _root):
    made_of = figures["picture"]
    source, errors = made_of["map"], made_of["errors"]

    def errors_of(name):
        row = errors[name]
        found = ", ".join(f"{LABELS[m].split(',')[0]} {percent(error_of(row, m))}"
                          for m in ("multum", "lean", "toksvig"))
        lean, toksvig = (percent(error_of(row, m, EVALUATED)) for m in ("lean", "toksvig"))
        return f"{name}, {found}; with as many evaluations as multum, LEAN {lean}, Toksvig {toksvig}"
    views = "; ".join(errors_of(name) for name in ("near", "far"))
    return f"""
![A {source["name"]} near (top) and far (bottom). Left to right: the reference; multum, whose far highlight is nearly as
narrow and bright; Toksvig, whose far highlight is wide and dull]({made_of["image"]})

*Relative L1 error (sum of absolute differences from the reference, over the sum of the reference): {views}.
Same material (Blinn-Phong, s = 100), light and filter (4 taps; docs/evidence/FILTER.md) for all;
reference: {made_of["samples"]} samples per pixel, noise {percent(made_of["noise"])} of itself.
Normal map: {source["author"]}, from {source["origin"]}, [{source["licence"]}]({source["licence_text"]}).*
"""


# ---- all maps


def quartiles(values):
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return f"{percent(middle)} ({100 * low:.1f} to {100 * high:.1f})"


def maps(figures, _root):
    errors = figures["maps"]["errors"]
    lines = ["| median relative L1 error (quartiles) | real maps | " + " | ".join(LABELS.values()) + " |",
             "|---|---|" + "---|" * len(LABELS)]
    for name, words in FILTERS.items():
        ending = EVALUATED if name == "points" else ""
        rows = errors["taps" if ending else name].values()
        cells = [quartiles([error_of(row, method, ending) for row in rows]) for method in LABELS]
        lines.append(f"| {words} | {len(rows)} | " + " | ".join(cells) + " |")
    return "\n" + "\n".join(lines) + "\n"


def default_errors(figures):
    return figures["maps"]["errors"]["taps"]


def nearest_of(figures, _root):
    rows = default_errors(figures).values()
    nearest = sum(row["multum"] < best_rival(row) for row in rows)
    return f"{nearest} of {len(rows)}"


def little_gain(figures, _root):
    """On how many maps the best rival is within two points of multum, at equal evaluations."""
    rows = default_errors(figures).values()
    few = sum(best_rival(row) - row["multum"] < 0.02 for row in rows)
    return (f"on {few} of {len(rows)} real maps LEAN or Toksvig comes within 2 percentage points of multum at equal "
            "evaluations")


# ---- costs


def default_mib(side, bytes_per_texel):
    """Of a texture with all of its levels."""
    texels, level = 0, side
    while level >= 1:
        texels, level = texels + level * level, level // 2
    return texels * bytes_per_texel / 2**20


def gpu_frames(root, row):
    """Of docs/evidence/GPU.md: milliseconds, trilinear and 16 x anisotropic."""
    return " / ".join(row_of(root, "GPU.md", rf"^\| {re.escape(row)} +\| {anisotropy} +\| [\d.]+ +\| ([\d.]+)")
                      for anisotropy in (1, 16))


def software_frames(figures, method):
    times = figures["frames"]["llvmpipe_ms"]
    return " / ".join(f"{statistics.median(times[name][method]):.0f}" for name in ("trilinear", "default"))


def costs(figures, root):
    side = 1024
    sizes = [one["baked_bytes"] / 2**20 for one in figures["maps"]["files"].values()
             if (one["width"], one["height"]) == (side, side)]
    gpu = figures["frames"]["gpu_mib"]
    rows = [("multum, 4 lobes", f"{gpu['multum']:.1f}", f"{statistics.median(sizes):.1f}, median of {len(sizes)}",
             gpu_frames(root, "4 lobes"), software_frames(figures, "multum")),
            ("LEAN", f"{gpu['lean-jacobian']:.1f}", "", gpu_frames(root, "moments (LEAN)"),
             software_frames(figures, "lean-jacobian")),
            ("Toksvig, BC5 normal and BC4 roughness", f"{default_mib(side, 1.5):.1f}", f"{default_mib(side, 1.5):.1f}",
             gpu_frames(root, "averaged normals, Toksvig") + " (1)", software_frames(figures, "toksvig") + " (1)"),
            ("an RGBA8 normal map", f"{default_mib(side, 4):.1f}", f"{default_mib(side, 4):.1f}", "", "")]
    lines = [f"| {side} x {side}, all levels | GPU memory, MiB | file, MiB | frame on an NVIDIA H100, ms | "
             "frame in software, ms |", "|---|---|---|---|---|", *["| " + " | ".join(row) + " |" for row in rows]]
    how = figures["made"]
    ratios = [a / b for times in figures["frames"]["llvmpipe_ms"].values()
              for a, b in zip(times["multum"], times["toksvig"])]
    return "\n" + "\n".join(lines) + f"""

*Frames of 1920 x 1080: on the H100 trilinear / 16 x anisotropic, by its sampler; in software trilinear / by the default
filter, 4 taps that are shaded once. Software: Mesa's llvmpipe on {how["processor"]}, {how["cores"]}
cores, medians of {figures["frames"]["runs"]} runs beside other programs; multum takes {min(ratios):.1f} to
{max(ratios):.1f} times as long as Toksvig. (1) Drawn from RGBA32F textures: from BC5 and BC4 it is faster.*
"""


def texel_bytes(figures, _root):
    bytes_per_texel = figures["frames"]["gpu_mib"]["multum"] / default_mib(1024, 1)
    return f"{bytes_per_texel:.0f} bytes"


def whole_bakes(root):
    """Of docs/evidence/BENCHMARKS.md, the first comparison of whole programs: seconds and MiB by program."""
    title = "A whole bake against maketx, 4096 x 4096"
    page = (root / "docs/evidence/BENCHMARKS.md").read_text()
    section = re.search(rf"(?s)^## {title}[^\n]*\n(.*?)(?=^## |\Z)", page, re.MULTILINE)
    rows = re.findall(r"^\| (multum bake|maketx) +\| ([\d.]+)[^|]*\| [^|]*\| (\d+)",
                      section.group(1) if section else "", re.MULTILINE)
    if [row[0] for row in rows] != ["multum bake", "maketx"]:
        raise Unreadable(f"docs/evidence/BENCHMARKS.md: found {len(rows)} rows under '{title}', expected multum "
                         "bake and maketx")
    return {name: (seconds, mib) for name, seconds, mib in rows}


def bake_costs(_figures, root):
    gpu, cores = row_of(root, "GPU.md", r"^- A whole bake of 4096 x 4096, from file to file: ([\d.]+) s, on the "
                                        r"processor ([\d.]+) s;")
    device, count = row_of(root, "GPU.md", r"^(NVIDIA [^;]+?);.*?, (\d+) cores")
    programs = whole_bakes(root)
    (seconds, mib), (other_seconds, other_mib) = programs["multum bake"], programs["maketx"]
    few = re.search(r"^`multum-bench bake --size 4096 .*; ([^;]*), \d+ GiB of memory",
                    (root / "docs/evidence/BENCHMARKS.md").read_text(), re.MULTILINE).group(1)
    return (f"From file to file, a 4096 x 4096 map takes {gpu} s with an {device}, {cores} s on the {count} cores of "
            f"its\nhost, and {seconds} s and {mib} MiB of memory on {few.replace(',', ' with')}, where "
            f"`maketx --bumpslopes`, which averages\nslopes, takes {other_seconds} s and {other_mib} MiB")


def worst_levels(_figures, root):
    """Of docs/evidence/ACCURACY.md, 4 lobes: the error of a map's worst level, by the exponent."""
    section = row_of(root, "ACCURACY.md", r"(?s)^### 4 lobes: (.*?)(?=^### )")
    worst = {}
    for name, exponent, cells in re.findall(r"^\| (\S+) \| (\d+) \| (.*) \|$", section, re.MULTILINE):
        errors = [float(cell.split("/")[0].strip("*")) for cell in cells.split(" | ")]
        worst.setdefault(int(exponent), {})[name] = max(errors)
    lines = ["| relative L1 error of a map's worst level, 4 lobes | " + " | ".join(f"s = {s}" for s in worst) + " |",
             "|---|" + "---|" * len(worst),
             "| median of " + str(len(worst[500])) + " real maps | " +
             " | ".join(f"{statistics.median(maps.values()):.1f} %" for maps in worst.values()) + " |"]
    name = max(worst[500], key=worst[500].get)
    lines.append(f"| worst map, `{name}` | " + " | ".join(f"{maps[name]:.1f} %" for maps in worst.values()) + " |")
    return "\n" + "\n".join(lines) + "\n"


def made(figures, _root):
    how = figures["made"]
    return (f"{how['software']}, commit {how['commit']}; {how['processor']}, {how['cores']} cores; {how['system']}; "
            f"{how['gl']};\nPoCL {how['pocl']}")


BLOCKS = {one.__name__: one for one in (picture, maps, nearest_of, little_gain, costs, texel_bytes, bake_costs,
                                        worst_levels, made)}


# ---- README.md


def read_figures(root):
    return json.loads((root / FIGURES).read_text())


def filled(root):
    """README.md as it should be, and the names of its marks."""
    figures, names = read_figures(root), []

    def fill_mark(mark):
        name = mark.group(1)
        if name not in BLOCKS:
            raise Unreadable(f"README.md: found the mark '{name}', expected one of {', '.join(BLOCKS)}")
        names.append(name)
        return f"<!-- figures: {name} -->{BLOCKS[name](figures, root)}<!-- /figures: {name} -->"
    return MARK.sub(fill_mark, (root / "README.md").read_text()), names


def fill(root):
    text, _ = filled(root)
    (root / "README.md").write_text(text)


def first_difference(found, expected):
    for number, (a, b) in enumerate(zip(found.splitlines(), expected.splitlines()), start=1):
        if a != b:
            return f"README.md:{number}: found '{a}', expected '{b}'"
    return "README.md: found another number of lines than expected"


def problems(root):
    """What in README.md does not follow from the figures; empty when all does."""
    text = (root / "README.md").read_text()
    try:
        expected, names = filled(root)
    except Unreadable as wrong:
        return [str(wrong)]
    found = [] if text == expected else [first_difference(text, expected) + " (tools/lab/readme_figures --fill)"]
    found += [f"README.md: found no mark '{name}', expected it once" for name in BLOCKS if names.count(name) != 1]
    prose = re.sub(r"^ {4}.*$", "", MARK.sub("", text), flags=re.MULTILINE)  # without commands
    found += [f"README.md: found '{measured.group().strip()}' outside the marks, expected measured figures inside them"
              for measured in MEASURED.finditer(prose)]
    shown = read_figures(root)["picture"]
    if hashlib.sha256((root / shown["image"]).read_bytes()).hexdigest() != shown["sha256"]:
        found.append(f"{shown['image']}: is not the picture that was measured")
    return found
