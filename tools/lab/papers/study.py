# SPDX-License-Identifier: Apache-2.0
"""Makes the comparisons of one paper. Runs multum and multum-view, keeps their pictures as arrays, and writes a page.

Pictures are linear RGB, float32 [height, width, 3], as multum-view writes them to EXR files. The page has PNGs of the
same numbers. Every figure of the page comes from a file next to the page.
"""
import json
import pathlib
import shlex
import subprocess
import sys
import textwrap
import time

import numpy as np
import OpenImageIO as oiio

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from report_page import STYLE, machine, machine_words, table, text  # noqa: E402

# multum-view's name of the reference picture, which has many samples of the finest normals per pixel.
REFERENCE = "reference"
# A filter with elongated footprints, for every method that supports one.
ELONGATED_FILTER = ("--taps", "8")
ROUND_FILTER = ("--taps", "1", "--level-bias", "0")  # a plain trilinear filter


class StepFailed(Exception):
    """A program failed: its command, exit code and last output."""


def read_picture(path, subimage=0, miplevel=0):
    """Reads all channels as float32 [height, width, channels]."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise StepFailed(f"cannot read {path}: {oiio.geterror()}")
    if not source.seek_subimage(subimage, miplevel):
        raise StepFailed(f"{path}: has no part {subimage}, level {miplevel}")
    pixels = source.read_image(subimage, miplevel, 0, source.spec().nchannels, oiio.FLOAT)
    source.close()
    return np.asarray(pixels, dtype=np.float32)


def srgb(linear):
    """Returns displayed values, 0..1."""
    c = np.clip(linear, 0.0, 1.0)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)


def write_picture(path, pixels, kind=oiio.UINT8):
    """Writes `pixels` in the range of the file, which is 0..1 for integers."""
    height, width, channels = pixels.shape
    output = oiio.ImageOutput.create(str(path))
    if output is None or not output.open(str(path), oiio.ImageSpec(width, height, channels, kind)):
        raise StepFailed(f"cannot write {path}: {oiio.geterror()}")
    output.write_image(np.ascontiguousarray(pixels, dtype=np.float32))
    output.close()


def write_sky(path, width=256):
    """Writes a generated linear latitude-longitude environment with sky, ground, a sun of five degrees, and three
    bright windows."""
    height = width // 2
    polar = (np.arange(height) + 0.5)[:, None] / height * np.pi
    azimuth = (np.arange(width) + 0.5)[None, :] / width * 2 * np.pi
    up = np.cos(polar) * np.ones_like(azimuth)
    colour = lambda r, g, b: np.array([r, g, b], dtype=np.float32)
    sky = np.where(up[:, :, None] > 0, colour(0.9, 0.95, 1.0) + up[:, :, None] * (colour(0.25, 0.45, 0.9) - 0.9),
                   colour(0.22, 0.17, 0.12))
    towards = np.dstack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), up])
    sky[towards @ (np.array([0.5, 0.4, 0.768]) / np.linalg.norm([0.5, 0.4, 0.768])) > np.cos(np.radians(5))] = 120.0
    for middle in (2.6, 3.6, 4.6):
        sky[(np.abs(azimuth - middle) < 0.25) & (np.abs(polar - 1.2) < 0.3)] = colour(6.0, 5.0, 3.5)
    write_picture(path, sky, oiio.FLOAT)


def relative_l1(picture, reference):
    """Returns sum |picture - reference| / sum reference in linear light, as in reports of multum-view and of bakes."""
    return float(np.abs(picture - reference).sum() / reference.sum())


def box_reduced(picture, factor):
    """Returns the means of factor x factor pixels."""
    height, width, channels = picture.shape
    return picture.reshape(height // factor, factor, width // factor, factor, channels).mean(axis=(1, 3))


def colour_distance(picture, reference):
    """Tan et al.'s "normalized Euclidean color error per pixel". The paper does not define it. Here it is the distance
    between displayed (sRGB, clamped) colours, divided by the distance between black and white, averaged over the pixels
    that the object covers."""
    covered = reference.max(axis=2) > 0
    return float((np.linalg.norm(srgb(picture) - srgb(reference), axis=2) / np.sqrt(3))[covered].mean())


def flicker(frames, references):
    """Returns the mean over neighbouring frames of sum |(f' - f) - (r' - r)| / sum r, the change between frames that
    does not occur in the reference. If it is 0, frames are as steady as the reference."""
    changes = [np.abs((frames[i + 1] - frames[i]) - (references[i + 1] - references[i])).sum() / references[i].sum()
               for i in range(len(frames) - 1)]
    return float(np.mean(changes))


class View:
    """The result of one run of multum-view: pictures by name (REFERENCE, "multum", "toksvig", ...), and its report."""

    def __init__(self, pictures, report):
        self.pictures, self.report = pictures, report
        self.frame_ms = {one["name"]: one["frame_time_ms"] for one in report["pictures"]}

    def __getitem__(self, name):
        return self.pictures[name]


class Study:
    def __init__(self, title, folder, programs, data, size, samples):
        """`programs` is the folder of multum and multum-view. `data` is the folder of shared real data, or None. `size`
        is the number of texels per side of generated maps. `samples` is the number per pixel of the reference."""
        self.title, self.folder, self.programs, self.data = title, folder, programs, data
        self.size, self.samples, self.picture_count = size, samples, 0
        self.has_made_maps = True
        self.parts, self.commands, self.devices, self.contexts, self.versions = [], [], set(), set(), set()
        self.strips = []  # (file of the folder, its name in docs/evidence/images)
        self.markdown = []  # headings, paragraphs, tables and strips for docs/evidence/PAPERS.md
        folder.mkdir(parents=True, exist_ok=True)

    # ---- steps

    def run(self, program, *arguments):
        """Runs a program until it ends and records its command. Returns seconds."""
        command = [str(self.programs / program), *map(str, arguments)]
        shown = " ".join([program, *(shlex.quote(str(a).replace(f"{self.folder}/", "")) for a in arguments)])
        print(f"  {shown[:150]}", flush=True)
        begin = time.monotonic()
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
        seconds = time.monotonic() - begin
        self.commands.append((shown, seconds))
        if done.returncode != 0:
            last = "\n".join((done.stdout + done.stderr).splitlines()[-20:])
            raise StepFailed(f"exit code {done.returncode}: {shown}\n{last}")
        return seconds

    def path(self, name):
        return self.folder / name

    def testmap(self, name, *options, size=None):
        """Makes NAME_normal.png and NAME_albedo.png with options of `multum testmap`. Returns the path of the normal
        map."""
        normal = self.path(f"{name}_normal.png")
        self.run("multum", "testmap", self.path(name), "--size", size or self.size, *options)
        return normal

    def torus(self):
        """Makes a mesh that shows all angles, and returns its path."""
        mesh = self.path("torus.obj")
        if not mesh.is_file():
            subprocess.run([sys.executable, pathlib.Path(__file__).resolve().parents[2] / "torus_mesh.py", mesh],
                           check=True)
        return mesh

    def bake(self, name, source, *options):
        """Bakes NAME.ndf.exr. Returns the report."""
        report = self.path(f"{name}.bake.json")
        self.run("multum", "bake", source, "-o", self.path(f"{name}.ndf.exr"), "--report", report, "--quiet", "--force",
                 *options)
        loaded = json.loads(report.read_text())
        self.devices.add(loaded["device"])
        return loaded

    def view(self, name, baked, *options, compare=(), samples=None):
        """Draws BAKED.ndf.exr as NAME_*.exr: "multum" and the methods in `compare`. `samples` is the number of samples
        per pixel of the reference."""
        report = self.path(f"{name}.view.json")
        command = [self.path(f"{baked}.ndf.exr"), "-o", self.path(f"{name}.exr"), "--pictures", self.path(name),
                   "--report", report, *options]
        if samples or self.samples:
            command += ["--samples", samples or self.samples]
        if compare:
            command += ["--compare", ",".join(compare)]
        self.run("multum-view", *command)
        loaded = json.loads(report.read_text())
        self.contexts.add(loaded["context"])
        self.versions.add(loaded["software"].split()[-1])
        names = [one["name"] for one in loaded["pictures"]]
        return View({n: read_picture(self.path(f"{name}_{n}.exr"))[:, :, :3] for n in names}, loaded)

    # ---- the page

    def heading(self, words, level=2):
        self.parts.append(f"<h{level}>{text(words)}</h{level}>")
        self.markdown.append(f"{'#' * (level + 1)} {words}")

    def paragraph(self, *words):
        self.parts.append(f"<p>{text(' '.join(words))}</p>")
        self.markdown.append(textwrap.fill(" ".join(words), 150, break_long_words=False, break_on_hyphens=False))

    def table(self, head, rows):
        self.parts.append(table(head, rows))
        plain = lambda cell: str(cell[0] if isinstance(cell, tuple) else cell).replace("|", "\\|")
        lines = [head, ["---"] * len(head), *rows]
        self.markdown.append("\n".join("| " + " | ".join(map(plain, line)) + " |" for line in lines))

    def html(self, markup):
        self.parts.append(markup)

    def figures(self, shown, exposure=1.0, name="figure", small=False):
        """Puts pictures next to each other. `shown` lists (linear picture, caption)."""
        files = []
        for picture, caption in shown:
            self.picture_count += 1
            files.append((f"page_{self.picture_count:02d}_{name}.png", caption))
            write_picture(self.path(files[-1][0]), srgb(exposure * picture))
        self.picture_files(files, small)

    def picture_files(self, files, small=False):
        """Puts pictures of the folder, given as (file, caption), next to each other. If `small`, they are no larger
        than a tile."""
        cells = [f'<figure><a href="{text(file)}"><img src="{text(file)}" alt="{text(caption)}"></a>'
                 f"<figcaption>{text(caption)}</figcaption></figure>" for file, caption in files]
        self.parts.append(f'<div class="pictures{"" if small else " first"}">' + "".join(cells) + "</div>")

    def strip(self, name, shown, zoom=1, crop=None, kind="png"):
        """Writes one picture, NAME.png, of several pictures next to each other. `shown`: (displayed values 0..1,
        caption), enlarged to squares of `zoom` x `zoom`. `crop`: slices of rows and columns. In docs/evidence/images,
        the picture is NAME.KIND."""
        parts = [picture[crop] if crop else picture for picture, _ in shown]
        enlarged = [part.repeat(zoom, 0).repeat(zoom, 1) for part in parts]
        write_picture(self.path(f"{name}.png"), np.concatenate(enlarged, axis=1))
        captions = "; ".join(caption for _, caption in shown)
        self.picture_files([(f"{name}.png", captions)])
        self.strips.append((f"{name}.png", f"{name}.{kind}"))
        self.markdown.append(f"![{captions}](images/{name}.{kind})")

    def write_page(self):
        rows = [[command, f"{seconds:.1f}"] for command, seconds in self.commands]
        page = f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>multum: {text(self.title)}</title><style>{STYLE}</style></head><body>
<h1>{text(self.title)}</h1>
{"".join(self.parts)}
<h2>How it was made</h2>
{machine(self.devices, self.contexts, self.versions)}
<details><summary>every command, and its seconds</summary>{table(["command", "seconds"], rows)}</details>
</body></html>
"""
        partial = self.path("index.html.tmp")
        partial.write_text(page, encoding="utf-8")
        partial.replace(self.path("index.html"))

    def section(self):
        """Returns the section of docs/evidence/PAPERS.md for this page."""
        of_maps = f"Generated maps have {self.size} x {self.size} texels. " if self.has_made_maps else ""
        # Omits paragraphs that introduce a picture of the HTML page.
        parts = [part for part, behind in zip(self.markdown, [*self.markdown[1:], ""])
                 if not part.endswith(":") or behind.startswith(("|", "!"))]
        return "\n\n".join([f"## {self.title}", of_maps + "Measured on this system (" +
                            machine_words(self.devices, self.contexts, self.versions) + ").",
                            *parts]) + "\n"

    def write_document_pictures(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        for file, name in self.strips:
            write_picture(folder / name, read_picture(self.path(file))[:, :, :3])
