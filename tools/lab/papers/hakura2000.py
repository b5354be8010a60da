# SPDX-License-Identifier: Apache-2.0
"""Hakura, Lengyel and Snyder 2000, "Parameterized Animation Compression": figures 10 to 12, and the paper's two demos
as pages that play.

The paper describes its scenes but does not publish them. The fields of the shared data follow the description at half
the resolution: a vase, a glass and a table in a room under a swinging light (figures 10 and 11), and the same room with
a turning knot instead of the paper's gewgaw (figure 12). ffmpeg codes views as AV1 instead of MPEG-4.
docs/evidence/PLAYBACK.md contains complete curves of size and error.
"""
import json
import pathlib
import re
import shutil
import sys

import numpy as np

TOOLS = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TOOLS), str(TOOLS / "playback")]
import video_codecs  # noqa: E402
from fields import Field, mse  # noqa: E402
from programs import Programs  # noqa: E402
from study import StepFailed, text  # noqa: E402

TITLE = "Hakura et al. 2000: parameterized animation compression"
TARGETS = (384, 768)
VIEWS, COSINES, WAVELETS = "views, AV1, one key frame per block", "textures, cosines", "textures, wavelets"
CODERS = {COSINES: ("--coder", "dct"), WAVELETS: ("--coder", "wavelet")}
# Points (ratio, MSE) of figure 10. The paper's methods are MPEG-4, Laplacian DCT and Laplacian SPIHT.
PUBLISHED = {384: {VIEWS: (355, 13.5), COSINES: (366, 11.8), WAVELETS: (379, 8.66)},
             768: {VIEWS: (570, 29.8), COSINES: (732, 18.1), WAVELETS: (751, 16.5)}}
DEMOS = {"field_demo1": "Demo 1: views of the room, and a swinging light",
         "field_demo2": "Demo 2: views of the room, and a knot that turns"}
COMBINED = '[[layer]]\nname = "radiance"\npasses = [""]\ndepends_on = [{}]\n\n'


class FieldStudy:
    """Frames of a field and its inferred textures."""

    def __init__(self, study, name):
        self.study, self.name, self.programs = study, name, Programs(study.programs)
        self.job = study.path(f"{name}.toml")
        study.run("multum", "animation", study.data / name, "-o", self.job)
        self.field = Field(self.job)
        self.traced = self.field.traced_frames()
        self.inferred = self.infer(self.job, name)

    def infer(self, job, name):
        output = self.study.path(f"{name}_inferred")
        self.study.run("multum", "infer", job, "-o", output, "--no-frames", "--no-comparison")
        report = json.loads((output / "report.json").read_text())
        self.study.devices.add(report["device"])
        if report["renderer"]:
            self.study.contexts.add(report["renderer"])
        self.study.versions.add(report["software"].split()[-1])
        return output

    def combined(self):
        """Infers textures with one layer for all light."""
        job = self.study.path(f"{self.name}_combined.toml")
        text = re.sub(r"^\[\[layer\]\]\n(?:(?!\[\[object).*\n)*", "", self.job.read_text(), flags=re.MULTILINE)
        names = ", ".join(f'"{one}"' for one in self.field.parameters)
        job.write_text(text.replace("[[object]]", COMBINED.format(names) + "[[object]]", 1))
        return self.infer(job, f"{self.name}_combined")

    def packed(self, label, ratio, options, inferred=None):
        """Packs textures and returns (ratio, MSE, frames)."""
        name = f"{self.name}_{re.sub(r'[^a-z0-9]+', '_', label)}_{ratio}"
        file, unpacked = self.study.path(f"{name}.mpt"), self.study.path(f"{name}_unpacked")
        self.study.run("multum", "pack", inferred or self.inferred, "-o", file, "--ratio", ratio, "--quiet", *options)
        frames = self.programs.unpacked_frames(file, self.field, unpacked)
        return self.field.raw_bytes / file.stat().st_size, mse(frames, self.traced), frames

    def video(self, ratio):
        """Codes the best AV1 stream whose size is at most the size of the raw frames / ratio, or the smallest if none
        fits."""
        best = video_codecs.best_within(video_codecs.CODECS[0], self.field.raw_bytes / ratio, self.traced)
        return self.field.raw_bytes / best[0], mse(best[1], self.traced), best[1]

    def page_that_plays(self):
        """Writes NAME_plays.html, which contains the player, the field at the first of TARGETS, the geometry and the
        decoder. Returns the bytes of the page and of the field."""
        packed, page = self.study.path(f"{self.name}_plays.mpt"), self.study.path(f"{self.name}_plays.html")
        self.study.run("multum", "pack", self.inferred, "-o", packed, "--ratio", TARGETS[0], "--quiet")
        self.study.run("multum", "player", packed, "-o", page)
        return page.stat().st_size, packed.stat().st_size

    def crop(self):
        """Returns the rows and columns with the objects on the table."""
        height, width = self.field.height, self.field.width
        return (slice(height // 6, 5 * height // 6), slice(width // 4, 3 * width // 4))

    def strip(self, name, shown):
        """Writes a strip with the middle sample of each entry (frames, caption) of `shown`."""
        middle = len(self.traced) // 2
        self.study.strip(name, [(frames[middle].astype(np.float32) / 255, caption) for frames, caption in shown],
                         zoom=2, crop=self.crop(), kind="jpg")


def compression(study, field):
    study.heading("Figure 10: a scene under a swinging light, 384:1 and 768:1")
    study.paragraph("Error and compression are defined as in the paper: MSE in 8-bit values over all samples of the",
                    "field, with one block of 8 x 8 samples. The size of textures includes everything that a player "
                    "needs, except for the scene file. The figures in the paper show another scene, with 640 x 480 "
                    "pixels.")
    rows = []
    for ratio in TARGETS:
        results = {VIEWS: field.video(ratio)} if shutil.which("ffmpeg") else {}
        results |= {label: field.packed(label, ratio, options) for label, options in CODERS.items()}
        field.strip(f"figure10_{ratio}", [(field.traced, "traced"), *[
            (frames, f"{label}, {reached:.0f}:1") for label, (reached, _, frames) in results.items()]])
        for label, (reached, error, _) in results.items():
            theirs = PUBLISHED[ratio][label]
            over = lambda value, base: f"{value / base:.2f}"
            rows.append([label, f"{reached:.0f}:1", f"{error:.1f}",
                         over(error, results[VIEWS][1]) if VIEWS in results else "-",
                         f"{theirs[0]}:1", f"{theirs[1]}", over(theirs[1], PUBLISHED[ratio][VIEWS][1])])
    study.table(["", "compression", "MSE", "MSE / MSE of views", "published compression", "published MSE",
                 "published MSE / MSE of views"], rows)
    if not shutil.which("ffmpeg"):
        study.paragraph("Views are left out: found no ffmpeg (Debian: apt-get install ffmpeg).")


def layers_and_pyramids(study, field):
    study.heading("Figure 11: one layer or two, plain or adaptive pyramid")
    combined, has_pyramids = field.combined(), field.programs.unknown_option(["--pyramid"]) is None
    of = lambda kind: ("--pyramid", kind) if has_pyramids else ()
    ways = [("combined, plain pyramid", combined, of("plain"), 11.52), ("combined, adaptive pyramid", combined,
                                                                       of("adaptive"), 9.64),
            ("separated, adaptive pyramid", field.inferred, of("adaptive"), 10.3)]
    if not has_pyramids:
        ways = [("combined", combined, (), 9.64), ("separated", field.inferred, (), 10.3)]
    results = [(label, theirs, *field.packed(label, TARGETS[0], (*CODERS[WAVELETS], *options), inferred))
               for label, inferred, options, theirs in ways]
    field.strip("figure11", [(field.traced, "traced"), *[(frames, label) for label, _, _, _, frames in results]])
    study.table([f"wavelets at {TARGETS[0]}:1", "compression", "MSE", "published MSE"],
                [[label, f"{reached:.0f}:1", f"{error:.1f}", f"{theirs}"]
                 for label, theirs, reached, error, _ in results])
    if not has_pyramids:
        study.paragraph("`multum pack` has no `--pyramid` here, so plain pyramids are left out.")


def moving_object(study, field):
    study.heading("Figure 12: an object that turns")
    samples = " x ".join(map(str, field.field.counts))
    study.paragraph(f"The field contains {samples} samples (views x rotation angles of a reflecting knot).",
                    "The field in the paper",
                    "contains 24 x 48 samples, and the authors divided the storage among the textures by hand.")
    results = {VIEWS: field.video(361)} if shutil.which("ffmpeg") else {}
    results["textures"] = field.packed("textures", 361, ())
    field.strip("figure12", [(field.traced, "traced"), *[
        (frames, f"{label}, {reached:.0f}:1") for label, (reached, _, frames) in results.items()]])
    study.table(["", "compression", "MSE", "published compression", "published MSE"],
                [[label, f"{reached:.0f}:1", f"{error:.1f}", "361:1", {VIEWS: "10.9", "textures": "10.3"}[label]]
                 for label, (reached, error, _) in results.items()])


def pages_that_play(study, fields):
    if not fields:
        return
    study.heading("The demos, played")
    study.paragraph("Each page contains the packed field, the geometry, the decoder and the player. The page "
                    "can be opened from disk in any browser with WebGL 2 and WebAssembly. docs/evidence/PLAYBACK.md "
                    "lists the frame rates.")
    rows = []
    for field in fields:
        try:
            page, packed = field.page_that_plays()
        except StepFailed as failure:  # this multum was built without the decoder for browsers
            study.paragraph(f"{DEMOS[field.name]}: left out. {str(failure).splitlines()[-1]}")
            continue
        file, title = f"{field.name}_plays.html", DEMOS[field.name]
        rows.append([title, f"{field.field.raw_bytes / packed:.0f}:1", f"{packed:,}", f"{page:,}"])
        study.html(f'<h3><a href="{file}">{text(title)}</a></h3><object type="text/html" data="{file}" '
                   f'aria-label="{text(title)}" style="width:100%;height:46rem;border:0"></object>')
    if rows:
        study.table(["", "compression", "bytes of the field", "bytes of the page"], rows)


def reproduce(study):
    study.has_made_maps, fields = False, []
    for name, figures in (("field_demo1", (compression, layers_and_pyramids)), ("field_demo2", (moving_object,))):
        if study.data is None or not (study.data / name / "scene.json").is_file():
            study.paragraph(f"{name} is missing in the shared data, so its figures are left out.")
            continue
        field = FieldStudy(study, name)
        fields.append(field)
        for figure in figures:
            figure(study, field)
    study.paragraph("docs/evidence/ANIMATION.md compares the errors of inferred textures with the errors of forward",
                    "mapping. This forward mapping splats pixels bilinearly, whereas the paper resamples with a",
                    "Lanczos-windowed sinc of 16 x 16 taps. This page therefore does not compare inferred "
                    "textures with the paper's forward mapping. docs/evidence/PLAYBACK.md plots error against size, "
                    "and shows the effect "
                    "of each part of the coder.")
    pages_that_play(study, fields)
