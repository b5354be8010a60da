# SPDX-License-Identifier: Apache-2.0
"""Makes the measured figures that README.md and the pages of docs/ quote, from docs/evidence.

A page has each figure between <!-- figures: NAME --> and <!-- /figures: NAME -->. BLOCKS makes the text of every NAME
from readme_figures.json or from a generated page of docs/evidence, so that all pages agree. README.md and
docs/explanation have no measured figures outside the marks. The check needs only the standard library: neither the
programs nor the real maps.
"""
import hashlib
import json
import os
import re
import statistics

FIGURES = "docs/evidence/readme_figures.json"
MARK = re.compile(r"<!-- figures: (\w+) -->(.*?)<!-- /figures: \1 -->", re.DOTALL)
# The names of marks that other programs fill.
FOREIGN = {"lobe_textures": "tools/lab/lobe_textures_document.py"}
# In these pages, measured figures may occur only between the marks.
MARKED_ONLY = ("README.md", "docs/explanation/")
# Matches a number with a unit that only a measurement can give. 0 % and 100 % are excluded, because pages use them to
# explain the meaning of an error.
MEASURED = re.compile(r"\d[\d.,]*(?:\s|-)?(?:%|ms\b|s\b|seconds?\b|minutes?\b|[KMG]i?B\b|bytes\b|times\b)")
COMMANDS = re.compile(r"^```.*?^```|^ {4}.*?$|`[^`\n]*`", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\((docs/[^)]*)\)")
LABELS = {"multum": "multum, 4 lobes", "lean": "LEAN", "toksvig": "Toksvig", "mip": "averaged normals"}
FILTERS = {"taps": "default filter, 4 taps",
           "points": "default filter, 4 evaluations of light per pixel for every method",
           "trilinear": "trilinear filter"}
EVALUATED = "-points"  # names of methods with this ending are shaded at as many points as multum uses evaluations


class Unreadable(Exception):
    """A page or JSON file does not contain the row or number that a figure needs."""


def percent(share):
    return f"{100 * share:.1f} %"


def roughness(exponent):
    """Returns the perceptual roughness of Blinn-Phong with this exponent: alpha^2 = 2 / (s + 2), roughness =
    sqrt(alpha)."""
    return f"{(2 / (exponent + 2)) ** 0.25:.2f}"


def table(head, *rows):
    lines = ["| " + " | ".join(row) + " |" for row in (head, *rows)]
    return "\n".join([lines[0], "|---|" + "---|" * (len(head) - 1), *lines[1:]])


def row_of(root, page, pattern):
    """Returns the groups of the only match in docs/evidence/PAGE."""
    found = re.findall(pattern, (root / "docs/evidence" / page).read_text(), re.MULTILINE)
    if len(found) != 1:
        raise Unreadable(f"docs/evidence/{page}: found {len(found)} lines '{pattern}', expected 1")
    return found[0]


def section_of(root, page, title):
    """Returns the text under a heading of docs/evidence/PAGE, up to the next heading of this or a higher level."""
    level = title.partition(" ")[0]
    return row_of(root, page, rf"(?s)^{title}[^\n]*\n(.*?)(?=^#{{1,{len(level)}}} |\Z)")


def cells_of(root, page, text, name):
    """Finds the first row of figures whose first cell matches, and returns its other cells."""
    found = re.search(rf"^\| *(?:{name}) *\| *(\d.*)\|$", text, re.MULTILINE)
    if not found:
        raise Unreadable(f"docs/evidence/{page}: found no row '{name}', expected one")
    return [cell.strip() for cell in found.group(1).split("|")]


def error_of(row, method, ending=""):
    """Returns the error of a method in one picture. For LEAN, this is the lower error of its two variants."""
    if method == "lean":
        return min(row["lean" + ending], row["lean-jacobian" + ending])
    if ending and method == "mip":
        return row["points"]
    return row[method] if method == "multum" else row[method + ending]


def best_rival(row):
    """Returns the lowest error of all rivals with an equal number of evaluations."""
    return min(error_of(row, "lean", EVALUATED), error_of(row, "toksvig", EVALUATED), row["points"])


# ---- the picture


def picture(figures, _root):
    made_of = figures["picture"]
    source, errors = made_of["map"], made_of["errors"]

    def errors_of(name):
        row = errors[name]
        cells = [f"{percent(error_of(row, m))} ({percent(error_of(row, m, EVALUATED))})" for m in ("lean", "toksvig")]
        return [name, percent(row["multum"]), *cells]
    rows = table(["relative L1 error", "4 lobes", "LEAN", "Toksvig"], errors_of("near"), errors_of("far"))
    return f"""
![A {source["name"]}, near in the top row and far in the bottom row. From left to right: the reference; multum, whose
far highlight is nearly as narrow and bright; Toksvig, whose far highlight is wide and dull]({made_of["image"]})

{rows}

*All methods have the same material, light and filter: roughness {roughness(100)} (Blinn-Phong, s = 100) and 4 taps.
Brackets contain the error of the same method with as many evaluations of light per pixel as lobes need. The reference
has {made_of["samples"]} samples per pixel. The noise of the reference is {percent(made_of["noise"])}. Normal map:
{source["author"]}, from {source["origin"]}, [{source["licence"]}]({source["licence_text"]}).*
"""


# ---- highlights of texels, by roughness

# Forms that a shader can draw. For each form, the entry names the row of docs/evidence/EXPORT.md with its error. Only
# lobes need a new shader.
DRAWN = (("averaged normals", r"averaged normals\b[^|]*"), ("Unreal's rule", r"Unreal\b[^|]*"),
         ("Unity HDRP's rule", r"Unity HDRP\b[^|]*"), ("`multum export`", r"\*\*`?multum export`?\*\*"),
         ("four lobes of `multum bake`", r"(?:four )?lobes of `multum bake`[^|]*"))
ROUGHNESSES = ("0.1", "0.25", "0.5")


def by_roughness(_figures, root):
    """Makes a table of highlight errors on levels 2, 4 and 6, as medians over the maps."""
    text = (root / "docs/evidence/EXPORT.md").read_text()
    maps = row_of(root, "EXPORT.md", r"\b(\d+) (?:real |normal )?maps (?:of|in|from) `?shared/data/normal")
    rows = []
    for label, name in DRAWN:
        cells = cells_of(root, "EXPORT.md", text, name)[::2]
        rows.append([label, *(cell.partition(" ")[0].replace("/", " / ") + " %" for cell in cells)])
    head = [f"error of the highlight on mip levels 2 / 4 / 6, median of {maps} real maps",
            *(f"roughness {one}" for one in ROUGHNESSES)]
    return "\n" + table(head, *rows) + "\n"


def by_lobes(_figures, root):
    """Makes a table of texel errors by the number of lobes, as medians over maps and levels."""
    text = section_of(root, "ACCURACY.md", "### By channels")
    exponents = re.search(r"s = (\d+) .*s = (\d+) .*s = (\d+) ", text).groups()
    rows = []
    for label, name in (("averaged normals", "mip|averaged normals"), ("Toksvig", "Toksvig"),
                        ("LEAN with its Jacobian", "LEAN with (?:its )?Jacobian"), ("1 lobe", "1 lobe"),
                        ("2 lobes", "2 lobes"), ("4 lobes", "4 lobes"), ("6 lobes", "6 lobes")):
        channels, *errors = cells_of(root, "ACCURACY.md", text, name)
        rows.append([label, channels, *(error.partition(" ")[0] + " %" for error in reversed(errors))])
    head = ["data per texel", "channels", *(f"roughness {roughness(int(s))} (s = {s})" for s in reversed(exponents))]
    return "\n" + table(head, *rows) + "\n"


# ---- pictures of all maps


def quartiles(values):
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return f"{percent(middle)} ({100 * low:.1f} to {100 * high:.1f})"


def maps(figures, _root):
    errors = figures["maps"]["errors"]
    head = [f"median error of pictures (quartiles), {len(errors['taps'])} real maps, roughness {roughness(100)}",
            *LABELS.values()]
    rows = []
    for name, words in FILTERS.items():
        ending = EVALUATED if name == "points" else ""
        found = errors["taps" if ending else name].values()
        rows.append([words, *(quartiles([error_of(row, method, ending) for row in found]) for method in LABELS)])
    return "\n" + table(head, *rows) + "\n"


def default_errors(figures):
    return figures["maps"]["errors"]["taps"]


def equal_evaluations(figures, _root):
    """Makes a table of median errors of all methods with an equal number of evaluations of light."""
    rows = default_errors(figures).values()
    median = {m: percent(statistics.median(error_of(row, m, EVALUATED) for row in rows)) for m in LABELS}
    return (f"{median['multum']} with four lobes, {median['lean']} with LEAN, {median['toksvig']} with Toksvig's rule "
            f"and {median['mip']} with averaged normals")


def closest_of(figures, _root):
    rows = default_errors(figures).values()
    closest = sum(row["multum"] < best_rival(row) for row in rows)
    return f"{closest} of {len(rows)} maps"


def little_gain(figures, _root):
    """Counts maps on which the best rival is better than multum or within two points, with an equal number of
    evaluations."""
    rows = default_errors(figures).values()
    few = sum(best_rival(row) - row["multum"] < 0.02 for row in rows)
    return f"{few} of {len(rows)} maps"


# ---- whole models

# The titles of sections in docs/evidence/GLTF_MODELS.md, with the kind of objects in each section.
MODEL_SETS = (("## All models", "models made by other people"), ("## All surfaces", "spheres and planes with bumps"))
# Forms that three.js draws. Each entry contains the number of evaluations of light per pixel, and the row of the form.
MODEL_ROWS = (("plain mips", "plain mips"), ("textures of `multum gltf`, shader unchanged", "one lobe"),
              ("plain mips at 4 points per pixel", "points, 4"), ("lobes, 4 evaluations per pixel", "lobes, 4"))


def models(_figures, root):
    """Makes a table of (error - floor) / (error of plain mips - floor), as medians over views from 5 m and farther."""
    head, columns = ["drawn by three.js"], []
    for title, words in MODEL_SETS:
        text = section_of(root, "GLTF_MODELS.md", title)
        cells = [cells_of(root, "GLTF_MODELS.md", text, name) for _, name in MODEL_ROWS]
        head.append(f"{words}, {cells[0][-1]} views")
        columns.append([cell[0] for cell in cells])
    return "\n" + table(head, *([label, *row] for (label, _), *row in zip(MODEL_ROWS, *columns))) + "\n"


# ---- costs


def default_mib(side, bytes_per_texel):
    """Returns the MiB of a square texture with all of its levels."""
    texels, level = 0, side
    while level >= 1:
        texels, level = texels + level * level, level // 2
    return texels * bytes_per_texel / 2**20


def gpu_frames(root, row):
    """Returns the milliseconds of a frame in docs/evidence/GPU.md, trilinear and 16 x anisotropic."""
    return " / ".join(row_of(root, "GPU.md", rf"^\| {row} +\| {anisotropy} +\| [\d.]+ +\| ([\d.]+)")
                      for anisotropy in (1, 16))


def block_mib(side, root):
    """Returns the MiB of four lobes in BC5 with all levels, plus level 0 of the BC5 normal map that they need."""
    share = float(row_of(root, "LOBE_TEXTURES.md", r"^\| 4 \| BC5 \| ([\d.]+) "))
    return share * default_mib(side, 1.5) + side * side / 2**20


def costs(figures, root):
    side = 1024
    sizes = [one["baked_bytes"] / 2**20 for one in figures["maps"]["files"].values()
             if (one["width"], one["height"]) == (side, side)]
    gpu = figures["frames"]["gpu_mib"]
    rows = [("4 lobes, 16 bits", f"{gpu['multum']:.1f}", f"{statistics.median(sizes):.1f} (1)",
             gpu_frames(root, "4 lobes")),
            ("4 lobes, BC5 blocks (2)", f"{block_mib(side, root):.1f}", "", ""),
            ("LEAN", f"{gpu['lean-jacobian']:.1f}", "", gpu_frames(root, r"moments \(LEAN\)")),
            ("Toksvig, BC5 normal and BC4 roughness", f"{default_mib(side, 1.5):.1f}", f"{default_mib(side, 1.5):.1f}",
             gpu_frames(root, "averaged normals, Toksvig") + " (3)"),
            ("an RGBA8 normal map", f"{default_mib(side, 4):.1f}", f"{default_mib(side, 4):.1f}", "")]
    head = [f"{side} x {side} texels, all levels", "GPU memory, MiB", "file, MiB",
            "frame on an NVIDIA H100, trilinear / 16 x anisotropic, ms"]
    return "\n" + table(head, *rows) + f"""

*Frames have 1920 x 1080 pixels. (1) The file size is the median of {len(sizes)} maps. (2) The memory includes the
normal map's finest level in BC5. (3) These frames read RGBA32F textures, although BC5 and BC4 textures are faster to
draw.*
"""


def software_times(figures, _root):
    times = figures["frames"]["llvmpipe_ms"]
    rows = [[label, *(f"{statistics.median(times[name][method]):.0f}" for name in ("trilinear", "default"))]
            for label, method in (("multum, 4 lobes", "multum"), ("LEAN", "lean-jacobian"), ("Toksvig", "toksvig"))]
    ratios = [a / b for one in times.values() for a, b in zip(one["multum"], one["toksvig"])]
    head = ["frame of 1920 x 1080 in software", "trilinear, ms", "default filter, ms"]
    return "\n" + table(head, *rows) + f"""

*The table lists medians of {figures["frames"]["runs"]} runs, while other programs ran. multum takes
{min(ratios):.1f} to {max(ratios):.1f} times as long as Toksvig, which is drawn from RGBA32F textures.*
"""


def texel_bytes(figures, _root):
    bytes_per_texel = figures["frames"]["gpu_mib"]["multum"] / default_mib(1024, 1)
    return f"{bytes_per_texel:.0f} bytes"


def whole_bakes(root):
    """Returns the seconds and the MiB of multum bake and maketx in docs/evidence/BENCHMARKS.md, and the number of
    cores."""
    title = "A whole bake compared with maketx, 4096 x 4096"
    section = row_of(root, "BENCHMARKS.md", rf"(?s)^## {title}\n(.*?)(?=^## |\Z)")
    programs = [re.search(rf"^\| {name} +\| ([\d.]+)[^|]*\| [^|]*\| (\d+)", section, re.MULTILINE)
                for name in ("multum bake", "maketx")]
    cores = re.search(r", (\d+) cores,", section)
    if not cores or not all(programs):
        raise Unreadable(f"docs/evidence/BENCHMARKS.md: cores or a row are missing under '{title}', expected cores and "
                         "rows of multum bake and maketx")
    return [one.groups() for one in programs], cores.group(1)


def bake_costs(_figures, root):
    gpu, cores = row_of(root, "GPU.md", r"^- A whole bake of 4096 x 4096 texels, from file to file, takes ([\d.]+) s "
                                        r"if the kernels run on the GPU, and ([\d.]+) s if they run on the "
                                        r"processor\.")
    device, count = row_of(root, "GPU.md", r"^Device: (NVIDIA [^.]+)\..*?, (\d+) cores")
    ((seconds, mib), (other_seconds, other_mib)), few = whole_bakes(root)
    return (f"A whole bake of a 4096 x 4096 map takes {gpu} s with an {device} and {cores} s on the {count} cores of\n"
            f"its host. On {few} cores, the bake takes {seconds} s and {mib} MiB of memory. `maketx --bumpslopes`, "
            f"which averages slopes,\ntakes {other_seconds} s and {other_mib} MiB on the same {few} cores.")


def worst_levels(_figures, root):
    """Makes a table of the error of each map's worst level with 4 lobes, by roughness."""
    section = row_of(root, "ACCURACY.md", r"(?s)^### 4 lobes: (.*?)(?=^### )")
    worst = {}
    for name, exponent, cells in re.findall(r"^\| (\S+) \| (\d+) \| (.*) \|$", section, re.MULTILINE):
        errors = [float(cell.split("/")[0].strip("*")) for cell in cells.split(" | ")]
        worst.setdefault(int(exponent), {})[name] = max(errors)
    exponents = sorted(worst, reverse=True)
    sharpest = worst[exponents[0]]
    name = max(sharpest, key=sharpest.get)
    head = ["error of a map's worst level, with 4 lobes", *(f"roughness {roughness(s)} (s = {s})" for s in exponents)]
    medians = [f"median of {len(sharpest)} real maps",
               *(f"{statistics.median(worst[s].values()):.1f} %" for s in exponents)]
    return "\n" + table(head, medians, [f"worst map, `{name}`", *(f"{worst[s][name]:.1f} %" for s in exponents)]) + "\n"


def made(figures, _root):
    how = figures["made"]
    return (f"{how['software']}, commit {how['commit']}; {how['processor']}, {how['cores']} cores; {how['system']}; "
            f"{how['gl']};\nPoCL {how['pocl']}")


BLOCKS = {one.__name__: one for one in (picture, by_roughness, by_lobes, maps, equal_evaluations, closest_of,
                                        little_gain, models, costs, software_times, texel_bytes, bake_costs,
                                        worst_levels, made)}


# ---- pages


def read_figures(root):
    return json.loads((root / FIGURES).read_text())


def marked_pages(root):
    """Yields the path and the text of README.md, of every page with marks, and of every page that must use marks."""
    for path in [root / "README.md", *sorted((root / "docs").rglob("*.md"))]:
        text = path.read_text()
        page = str(path.relative_to(root))
        if MARK.search(text) or page.startswith(MARKED_ONLY):
            yield page, text


def filled(root, page, text, blocks):
    """Fills all marks of a page and lists their names. Links in the text are made relative to the page."""
    names = []

    def fill_mark(mark):
        name = mark.group(1)
        if name in FOREIGN:
            return mark.group()
        if name not in BLOCKS:
            raise Unreadable(f"{page}: found the mark '{name}', expected one of {', '.join(BLOCKS)}")
        names.append(name)
        if name not in blocks:
            blocks[name] = BLOCKS[name](blocks["figures"], root)
        folder = os.path.dirname(page) or "."
        block = LINK.sub(lambda link: f"]({os.path.relpath(link.group(1), folder)})", blocks[name])
        return f"<!-- figures: {name} -->{block}<!-- /figures: {name} -->"
    return MARK.sub(fill_mark, text), names


def fill(root):
    blocks = {"figures": read_figures(root)}
    for page, text in list(marked_pages(root)):
        (root / page).write_text(filled(root, page, text, blocks)[0])


def first_difference(page, found, expected):
    for number, (a, b) in enumerate(zip(found.splitlines(), expected.splitlines()), start=1):
        if a != b:
            return f"{page}:{number}: found '{a}', expected '{b}'"
    return f"{page}: found {len(found.splitlines())} lines, expected {len(expected.splitlines())}"


def measured_outside(page, text):
    """Lists measured figures of a page that are outside the marks. Numbers in commands are allowed."""
    prose = COMMANDS.sub("", MARK.sub("", text))
    for measured in MEASURED.finditer(prose):
        found = " ".join(measured.group().split())
        if found in ("0 %", "100 %"):
            continue
        yield f"{page}: found '{found}' outside the marks, expected measured figures inside them"


def problems(root):
    """Lists each text that differs from the figures. The list is empty if all pages agree with them."""
    found, used, blocks = [], set(), {"figures": read_figures(root)}
    for page, text in marked_pages(root):
        try:
            expected, names = filled(root, page, text, blocks)
        except Unreadable as wrong:
            return [str(wrong)]
        used.update(names)
        if text != expected:
            found.append(first_difference(page, text, expected) + ". Run tools/lab/readme_figures --fill")
        if page.startswith(MARKED_ONLY):
            found += measured_outside(page, text)
    found += [f"no page has the mark '{name}', expected at least one" for name in BLOCKS if name not in used]
    shown = blocks["figures"]["picture"]
    if hashlib.sha256((root / shown["image"]).read_bytes()).hexdigest() != shown["sha256"]:
        found.append(f"{shown['image']}: differs from the picture whose errors were measured")
    return found
