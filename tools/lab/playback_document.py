#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes docs/evidence/PLAYBACK.md: size, error and costs of packed animations, compared with video codecs.

    tools/lab/playback_document.py FIELD... --work DIR --rows docs/evidence/playback_rows.json
        -o docs/evidence/PLAYBACK.md [--bin DIR] [--parts PART...] [--again PART...] [--measure-nothing]

FIELD is a folder of ray-traced frames that `multum animation` can read (docs/reference/animation_jobs.md). Each field
gets a section. --split FIELD PARAMETER=NAME:COUNT,NAME:COUNT splits one parameter into several parameters.

Textures are inferred once, into DIR. Every figure is immediately stored in the file of rows, with its commit. Existing
rows are not measured again unless --again names their part: videos of traced frames, for example, do not depend on
multum. --measure-nothing makes the page only from the rows. Videos need Debian's ffmpeg, and playing needs dav1d's
library. Without a browser, the browser's figures are missing.
"""
import argparse
import datetime
import json
import math
import pathlib
import re
import shutil
import sys
import zlib

import committed_tree
from debian_python import use_a_python_with

PARTS = {"field": "field", "curves": "pack", "video": "video", "coder": "coder", "inference": "inference",
         "costs": "cost", "dimensions": "dimension", "playing": "playing"}  # parts, and kinds of rows
RATIOS = (192, 384, 768)  # ratios that tables list; parts of the coder are compared at the middle ratio
GROWTH_RATIOS = (96, 192)  # ratios at which fields with more and more parameters are compared
# Each row contains a name, options of `multum pack`, and the colour and the dash pattern of the curve.
PACKINGS = (("multum pack", (), 0, 0), ("multum pack --coder dct", ("--coder", "dct"), 0, 1),
            ("multum pack --coder wavelet", ("--coder", "wavelet"), 0, 2))
# Each of these options switches off one part of the encoder. The names are keys of rows.
CODER_SETS = (("as it is", ()), ("cosines alone", ("--coder", "dct")), ("wavelets alone", ("--coder", "wavelet")),
              ("a plain pyramid over the parameters", ("--pyramid", "plain")),
              ("the paper's search for levels, no learnt basis", ("--pyramid", "greedy")),
              ("open loop", ("--loop", "open")), ("no object above 1.25 times the mean", ("--alpha", "1.25")),
              ("blocks of 4 samples a parameter", ("--block", "4")), ("every sample by itself", ("--pyramid", "none")))
# Changes of the job's `[texture]`, and options of `multum infer`. The names are keys of rows.
INFERENCES = (("as it is", {}, ()), ("textures with 1.5 times the side length", {"resolution_scale": 1.5}, ()),
              ("ten times the regularisation", {"pyramid_weight": 1}, ()),
              ("textures of twice the side", {"resolution_scale": 2}, ()),
              ("a tenth of the regularisation", {"pyramid_weight": 0.01}, ()),
              ("solved ten times nearer", {}, ("--tolerance", "1e-4")))
# Names of rows as the page shows them.
SHOWN = {"as it is": "defaults", "cosines alone": "only cosines", "wavelets alone": "only wavelets",
         "the paper's search for levels, no learnt basis":
             "the paper's method of searching for levels, without a learnt basis",
         "no object above 1.25 times the mean": "the error of each object is at most 1.25 times the mean error",
         "blocks of 4 samples a parameter": "blocks of 4 samples per parameter",
         "every sample by itself": "each sample is packed separately",
         "solved ten times nearer": "a tenth of the solver's tolerance"}


def shown(name):
    return SHOWN.get(name, name).replace("each frame by itself", "each frame separately")


class Rows:
    """Keeps measurements, in one row per field, kind and name. Each row is written at once."""

    def __init__(self, path, commit):
        self.path, self.commit = path, commit
        self.all = json.loads(path.read_text()) if path.exists() else []

    def find(self, field, kind, name):
        return next((row for row in self.all if (row["field"], row["kind"], row["name"]) == (field, kind, name)), None)

    def of(self, field, kind):
        return [row for row in self.all if (row["field"], row["kind"]) == (field, kind)]

    def forget(self, fields, kinds):
        """Drops rows that are to be measured again."""
        self.all = [row for row in self.all if row["field"] not in fields or row["kind"] not in kinds]

    def measured(self, field, kind, name, measure):
        """Returns the existing row, or adds the result of `measure`."""
        row = self.find(field, kind, name)
        if row is None:
            begin = datetime.datetime.now()
            row = {"field": field, "kind": kind, "name": name, "commit": self.commit, **measure()}
            self.all.append(row)
            partial = self.path.with_suffix(".tmp")
            partial.write_text(json.dumps(self.all, indent=1))
            partial.replace(self.path)
            shown = ", ".join(f"{k} {v:.6g}" for k, v in row.items() if isinstance(v, (int, float)))
            print(f"{field}: {kind}, {name}: {shown} ({(datetime.datetime.now() - begin).seconds} s)", flush=True)
        return row


class FieldMeasurement:
    """Measures one field: its traced frames, and frames drawn from inferred textures."""

    def __init__(self, name, job, inferred, programs, rows, stated):
        """`stated` are the ratios that tables list."""
        from fields import Field
        self.name, self.inferred, self.programs, self.rows = name, inferred, programs, rows
        self.stated, self.main = stated, ["--ratio", f"{stated[len(stated) // 2]:g}"]
        self.field, self.scratch = Field(job), inferred.parent
        self.traced = self.field.traced_frames()
        self.own = programs.drawn_frames(inferred, self.field)

    def packed(self, options, inferred=None):
        """Returns bytes, errors and costs of `multum pack` with these options, or the reason of a refusal."""
        from fields import mse
        unknown = self.programs.unknown_option(options)
        if unknown:
            return {"refused": f"there is no {unknown}"}
        file = self.scratch / "packed.mpt"
        done = self.programs.pack(inferred or self.inferred, file, options)
        if done.code != 0:
            return {"refused": done.text.strip().splitlines()[-1]}
        frames = self.programs.unpacked_frames(file, self.field, self.scratch / "unpacked")
        size = file.stat().st_size
        file.unlink()
        return {"bytes": size, "ratio": self.field.raw_bytes / size, "mse": mse(frames, self.traced),
                "mse_beside_inferred": mse(frames, self.own), "seconds": done.seconds,
                "processor_seconds": done.processor_seconds, "memory_bytes": done.memory_bytes}

    def packed_at_main(self, options):
        """Returns packed() at the main ratio. Uses the row of a curve if there is one."""
        curve = next((name for name, theirs, *_ in PACKINGS if theirs == tuple(options)), None)
        row = self.rows.find(self.name, "pack", f"{curve}, {self.main[1]}:1")
        if row:
            return {key: value for key, value in row.items() if key not in ("field", "kind", "name", "commit", "curve")}
        return self.packed([*self.main, *options])

    def measure_curves(self, ratios, coders):
        for name, options, *_ in PACKINGS:
            if (options[-1] if options else "auto") not in coders:
                continue
            for ratio in sorted(ratios, key=lambda r: (r not in self.stated, r)):  # ratios of tables come first
                self.rows.measured(self.name, "pack", f"{name}, {ratio:g}:1",
                                   lambda: {"curve": name, "asked": ratio,
                                            **self.packed(["--ratio", f"{ratio:g}", *options])})

    def measure_videos(self, video_codecs, beginnings):
        """`beginnings` are prefixes of codec names, or None for all codecs."""
        from fields import mse
        for codec in video_codecs.CODECS:
            if beginnings and not codec.name.startswith(tuple(beginnings)):
                continue
            for quality in codec.qualities:
                def measure():
                    size, frames = video_codecs.coded(codec, quality, self.traced)
                    return {"curve": codec.name, "quality": quality, "bytes": size,
                            "ratio": self.field.raw_bytes / size, "mse": mse(frames, self.traced),
                            "encoder": video_codecs.version()}
                self.rows.measured(self.name, "video", f"{codec.name}, crf {quality}", measure)

    def measure_coder_sets(self):
        for name, options in CODER_SETS:
            row = self.rows.find(self.name, "coder", name)
            if row and "refused" in row and self.programs.unknown_option(options) is None:
                self.rows.all.remove(row)  # an older binary did not support this row
            self.rows.measured(self.name, "coder", name, lambda: {
                "options": " ".join(options), **self.packed_at_main(options)})

    def measure_costs(self):
        for threads in (1, 2):
            self.rows.measured(self.name, "cost", f"{threads} threads", lambda: {
                "threads": threads, **self.packed([*self.main, "--threads", f"{threads}"])})

    def measure_dimensions(self, video_codecs, ratios):
        """Measures the field with only its first two parameters, at the middle samples of the others, and then with one
        more parameter each time."""
        from parameter_grid import with_leading_parameters
        names = self.field.parameters
        for kept in range(2, len(names) + 1):
            def measure():
                part = self
                if kept < len(names):
                    job, inferred = self.scratch / f"leading{kept}.toml", self.scratch / f"leading{kept}"
                    job.write_text(with_leading_parameters(self.field.path.read_text(), kept))
                    shutil.rmtree(inferred, ignore_errors=True)
                    self.programs.infer(job, inferred)
                    part = FieldMeasurement(self.name, job, inferred, self.programs, self.rows, self.stated)
                return {"counts": part.field.counts, "raw_bytes": part.field.raw_bytes,
                        **part.errors_of_growth(video_codecs, ratios)}
            self.rows.measured(self.name, "dimension", ", ".join(names[:kept]), measure)

    def errors_of_growth(self, video_codecs, ratios):
        """Returns `at`: for each ratio, the total error of the packed field, its error against inferred textures, and
        the error of a video."""
        from fields import mse
        points = []
        for ratio in ratios:
            size, frames = video_codecs.best_within(video_codecs.CODECS[0], self.field.raw_bytes / ratio, self.traced)
            packed = self.packed(["--ratio", f"{ratio:g}"])
            points.append({"ratio": ratio, "pack": packed.get("mse"), "beside": packed.get("mse_beside_inferred"),
                           "video": mse(frames, self.traced), "video_ratio": self.field.raw_bytes / size})
        return {"own": mse(self.own, self.traced), "at": points}

    def stated_errors(self, inferred):
        """Returns the MSE at each stated ratio, and the processor seconds of packing at the main ratio. Uses rows of a
        curve if there are any."""
        result = {}
        for ratio in self.stated:
            row = self.rows.find(self.name, "pack", f"{PACKINGS[0][0]}, {ratio:g}:1") if inferred is None else None
            packed = row or self.packed(["--ratio", f"{ratio:g}"], inferred)
            result[f"mse_{ratio:g}"] = packed.get("mse")
            if self.main[1] == f"{ratio:g}":
                result["pack_seconds"] = packed.get("processor_seconds")
        return result

    def measure_playing(self, video_codecs):
        from playing import measure_playing
        packed = self.rows.find(self.name, "pack", f"{PACKINGS[0][0]}, {self.main[1]}:1")

        def quality_of(codec):
            known = [row for row in self.rows.of(self.name, "video") if row["curve"] == codec.name]
            if packed is None or not known:
                sys.exit("playing is compared at equal error, but rows of curves or videos are missing; measure the "
                         "parts curves and video first")
            return min(known, key=lambda row: abs(math.log(row["mse"] / packed["mse"])))["quality"]

        measure_playing(self, video_codecs, quality_of)

    def measure_inference(self, keeps, ways):
        """`keeps` tells whether the inferred textures stay in the work folder. `ways` is the number of INFERENCES to
        use."""
        from fields import error_places, mse, squared_errors
        numbers, names = self.field.object_numbers(), [one["name"] for one in self.field.job["object"]]
        places = lambda frames: error_places(squared_errors(frames, self.traced), numbers, names)
        for name, changes, options in INFERENCES[:ways]:
            def measure():
                if not changes and not options:
                    row = self.rows.find(self.name, "field", "inferred")
                    return {"own": mse(self.own, self.traced), "places": places(self.own),
                            "infer_seconds": row["processor_seconds"], **self.stated_errors(None)}
                job = self.field.path.with_name("changed.toml")
                job.write_text(with_texture_settings(self.field.path.read_text(), changes))
                inferred = self.scratch / "changed"
                shutil.rmtree(inferred, ignore_errors=True)
                done = self.programs.infer(job, inferred, options)
                frames = self.programs.drawn_frames(inferred, self.field)
                errors = self.stated_errors(inferred)
                if not keeps:
                    shutil.rmtree(inferred)
                return {"own": mse(frames, self.traced), "places": places(frames),
                        "infer_seconds": done.processor_seconds, **errors}
            self.rows.measured(self.name, "inference", name, measure)


def with_texture_settings(job, changes):
    """Returns the text of a job with other values for existing keys of `[texture]`."""
    head, texture, rest = re.split(r"^(\[texture\]\n(?:(?!\[).*\n)*)", job, maxsplit=1, flags=re.MULTILINE)
    for key, value in changes.items():
        texture, count = re.subn(rf"^{key} = [^\s#]+", f"{key} = {value}", texture, flags=re.MULTILINE)
        if count != 1:
            sys.exit(f"the job has no {key} in [texture]")
    return head + texture + rest


def prepared(folder, work, programs, rows, split):
    """Makes the job and infers the textures if they are missing. Returns name, job and folder of textures. `split` is
    None, or the parameter to divide and its parts, as for with_split_parameter()."""
    from fields import Field, mse
    from parameter_grid import with_split_parameter
    name = folder.name
    own = work / name
    job, inferred = own / "animation.toml", own / "inferred"
    own.mkdir(parents=True, exist_ok=True)
    if not job.exists():
        programs.job(folder, job)
        if split:
            job.write_text(with_split_parameter(job.read_text(), *split))

    def measure():
        if not (inferred / "inferred.json").exists():
            shutil.rmtree(inferred, ignore_errors=True)  # these textures are from an interrupted run, whose times are
                                                         # wrong
        done = programs.infer(job, inferred)
        field = Field(job)
        geometry = field.geometry.read_bytes()
        return {"width": field.width, "height": field.height, "counts": field.counts, "parameters": field.parameters,
                "objects": [one["name"] for one in field.job["object"]], "raw_bytes": field.raw_bytes,
                "geometry": field.geometry.name, "geometry_bytes": len(geometry),
                "geometry_deflated_bytes": len(zlib.compress(geometry, 9)),
                "own": mse(programs.drawn_frames(inferred, field), field.traced_frames()),
                "processor_seconds": done.processor_seconds, "seconds": done.seconds,
                "memory_bytes": done.memory_bytes}

    if rows.find(name, "field", "inferred") is None:
        shutil.rmtree(inferred, ignore_errors=True)  # otherwise the time would not be for a whole run
    rows.measured(name, "field", "inferred", measure)
    return name, job, inferred


# ---- the page

def table(head, rows):
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in [head, ["---"] * len(head), *rows])


def curve_points(rows, name, of):
    return [(row["ratio"], row["mse"]) for row in of if row.get("curve") == name and "refused" not in row]


def number(value, digits=1):
    return "-" if value is None else f"{value:.{digits}f}"


def field_words(row):
    counts = " x ".join(f"{count} values of {name}" for count, name in zip(row["counts"], row["parameters"]))
    return (f"The field has {math.prod(row['counts'])} samples ({counts}) of {row['width']} x {row['height']} pixels. "
            f"Its objects are {', '.join(row['objects'])}. The raw 24-bit frames need {row['raw_bytes']:,} bytes.")


def curves_of(rows, name, codec_names):
    """Returns (name, colour, dash, points) of all measured curves of a field."""
    packs, videos = rows.of(name, "pack"), rows.of(name, "video")
    curves = [(label, colour, dash, curve_points(rows, label, packs)) for label, _, colour, dash in PACKINGS]
    looks = ((1, 0), (1, 1), (2, 0), (2, 1), (3, 0))
    return curves + [(label, *look, curve_points(rows, label, videos)) for label, look in zip(codec_names, looks)]


def at_ratios(rows, name, video_codecs, stated):
    """Returns the table at the stated ratios, and a sentence that compares multum pack with the leading codec."""
    from curves import value_at
    from playing import spoken
    curves = [one for one in curves_of(rows, name, [one.name for one in video_codecs.CODECS]) if one[3]]
    leading = {ratio: value_at(points, ratio) for label, _, _, points in curves if label == video_codecs.LEADING
               for ratio in stated}
    lines = []
    for label, _, _, points in curves:
        cells = []
        for ratio in stated:
            here, best = value_at(points, ratio), leading.get(ratio)
            cells.append(f"{here:.1f} ({here / best:.2f})" if here and best else number(here))
        lines.append([shown(label), *cells])
    head = ["MSE", *[f"{ratio:g}:1" for ratio in stated]]
    words = []
    own = next((points for label, _, _, points in curves if label == PACKINGS[0][0]), [])
    for ratio in stated:
        here, best = value_at(own, ratio), leading.get(ratio)
        if here and best:
            words.append(f"{100 * abs(1 - here / best):.0f} % {'lower' if here < best else 'higher'} at {ratio:g}:1")
    listed = ", ".join(words[:-1]) + (", and " if len(words) > 1 else "") + "".join(words[-1:])
    said = f"Compared with {spoken(video_codecs.LEADING)}, the MSE of `multum pack` is {listed}." if words else ""
    return table(head, lines), said


def curves_section(rows, name, video_codecs, stated, pictures):
    from curves import picture
    from playing import spoken
    curves = curves_of(rows, name, [one.name for one in video_codecs.CODECS])
    if not any(points for *_, points in curves):
        return []
    pictures.mkdir(parents=True, exist_ok=True)
    file = pictures / f"playback_{name}.svg"
    titled = [(shown(label), *one) for label, *one in curves]
    file.write_text(picture(f"Error over compression of {name}", titled, stated))
    at_stated, said = at_ratios(rows, name, video_codecs, stated)
    points = [[shown(row["name"]), f"{row['bytes']:,}", f"{row['ratio']:.1f}", f"{row['mse']:.2f}",
               number(row.get("mse_beside_inferred"), 2)]
              for row in sorted(rows.of(name, "pack") + rows.of(name, "video"),
                                key=lambda row: (row["kind"], row["curve"], row.get("ratio", 0)))
              if "refused" not in row]
    return [f"![MSE over compression](images/{file.name})", at_stated,
            f"Brackets contain the MSE divided by the MSE of {spoken(video_codecs.LEADING)}. The entry \"-\" means "
            f"that the "
            "curve does not reach this compression. " + said,
            "<details><summary>All points of the curves</summary>\n\n" +
            table(["encoder", "bytes", "compression", "MSE", "MSE against inferred textures"], points) +
            "\n\n</details>"]


def coder_section(rows, name, main):
    found = {row["name"]: row for row in rows.of(name, "coder")}
    done = [(label, found[label]) for label, _ in CODER_SETS if label in found and "refused" not in found[label]]
    if not done:
        return []
    base = done[0][1]["mse"]
    lines = [[shown(label), f"`{row['options']}`" if row["options"] else "", f"{row['ratio']:.1f}", f"{row['mse']:.1f}",
              f"{row['mse'] / base:.2f}", f"{row['mse_beside_inferred']:.1f}", f"{row['processor_seconds']:.0f}"]
             for label, row in done]
    left_out = [f"{shown(label)} ({found[label]['refused']})" for label, _ in CODER_SETS
                if label in found and "refused" in found[label]]
    return [f"### Effect of each part of the coder, at {main:g}:1",
            table(["", "options", "compression", "MSE", "MSE / MSE of defaults", "MSE against inferred textures",
                   "processor, s"],
                  lines), *([f"Left out: {'; '.join(left_out)}."] if left_out else [])]


def inference_section(rows, name, stated):
    found = rows.of(name, "inference")
    if not found:
        return []
    parts = [f"### Where the error of inference lies",
             "Frames are drawn from the inferred textures, without compression, and compared with the traced frames. "
             "*Silhouettes* are pixels next to a pixel of another object. *Part* is the amount that these "
             "pixels contribute to the MSE of all pixels."]
    keys = [(one["object"], one["place"]) for one in found[0]["places"]]
    lines = []
    for row in found:
        places = {(one["object"], one["place"]): one for one in row["places"]}
        silhouette = sum(one["part"] for one in row["places"] if one["place"] == "silhouette")
        lines.append([shown(row["name"]), f"{row['own']:.2f}", f"{silhouette:.2f}", f"{row['own'] - silhouette:.2f}",
                      *[number(row.get(f"mse_{ratio:g}")) for ratio in stated], f"{row['infer_seconds']:.0f}",
                      number(row.get("pack_seconds"), 0)])
    main = stated[len(stated) // 2]
    parts.append(table(["textures", "MSE", "part of silhouettes", "part of interiors",
                        *[f"MSE at {ratio:g}:1" for ratio in stated], "inference, processor s",
                        f"packing at {main:g}:1, processor s"], lines))
    lines = []
    for key in keys:
        cells = []
        for row in found:
            one = next((p for p in row["places"] if (p["object"], p["place"]) == key), None)
            cells.append(f"{one['mse']:.1f} ({one['part']:.2f})" if one else "-")
        share = next(p["pixels"] for p in found[0]["places"] if (p["object"], p["place"]) == key)
        lines.append([f"{key[0] or 'nothing'}, {key[1]}", f"{100 * share:.1f}", *cells])
    parts.append(table(["MSE of the pixels (part)", "share of pixels, %",
                        *[shown(row["name"]) for row in found]], lines))
    return parts


def costs_section(rows, name, main):
    found, field = rows.of(name, "cost"), rows.find(name, "field", "inferred")
    found = [row for row in found if "refused" not in row]
    if not found:
        return []
    samples = math.prod(field["counts"])
    line = lambda what, row: [what, f"{row['seconds']:.0f}", f"{row['processor_seconds']:.0f}",
                              f"{row['processor_seconds'] / samples:.2f}", f"{row['memory_bytes'] / 2 ** 20:.0f}"]
    return ["### Time and memory",
            table(["", "seconds", "processor, s", "processor, s per sample", "memory, MiB"],
                  [line("`multum infer` without frames and comparison", field),
                   *[line(f"`multum pack --ratio {main:g} --threads {row['threads']}`", row) for row in found]]),
            f"Packing takes {found[-1]['processor_seconds'] / field['processor_seconds']:.2f} times the processor "
            "seconds of inference. Other programs possibly ran on the machine at the same time. The memory is the peak "
            "memory of one process."]


def dimensions_section(rows, name, leading):
    from playing import spoken
    found = rows.of(name, "dimension")
    if len(found) < 2:
        return []
    lines = []
    for row in found:
        cells = [cell for at in row["at"] for cell in (
            number(at["pack"]), number(at["beside"]), f"{at['video']:.1f} ({at['video_ratio']:.0f}:1)")]
        lines.append([row["name"], math.prod(row["counts"]), f"{row['raw_bytes']:,}", number(row["own"]), *cells])
    head = ["parameters", "samples", "raw bytes", "MSE of inferred textures"]
    for at in found[0]["at"]:
        head += [f"MSE at {at['ratio']:g}:1", "against inferred textures", leading]
    before, after = found[-2]["at"][-1], found[-1]["at"][-1]
    words = ""
    if after["beside"] and before["beside"]:
        words = (f" Compared with the field without `{found[-1]['name'].split(', ')[-1]}`, packing at "
                 f"{after['ratio']:g}:1 adds "
                 f"{after['beside'] / before['beside']:.2f} times as much error, and the error of {spoken(leading)} is "
                 f"{after['video'] / before['video']:.2f} times as high.")
    return ["### Cost of another parameter",
            table(head, lines),
            "Rows with fewer parameters use the middle sample of each omitted parameter. If the compression is "
            "the same, the file size is proportional to the number of samples." + words]


def document(rows, names, video_codecs, stated, machine, pictures):
    from playing import playing_section
    main = stated[len(stated) // 2]
    parts = ["# Packed animations compared with video codecs",
             "This page compares the error and the size of packed fields with video codecs, and lists the "
             "playback speed of packed fields.",
             f"Generated by `tools/lab/playback_document.py` ({machine}). Do not edit.",
             "The section of each field lists the commits at which the field was measured. A row is measured "
             "again only after a change that affects the row.",
             "A field is a set of ray-traced frames for different values of some parameters ([animation "
             "jobs](../reference/animation_jobs.md)). `multum infer` infers textures from the frames, `multum pack` "
             "packs the textures, and `multum-view sample` unpacks and draws them.",
             "- *MSE* is the mean squared error of red, green and blue in 8-bit values at gamma 2.2, compared with "
             "the traced frames. The mean includes all pixels of all samples, including silhouettes.\n"
             "- *Compression* is the size of the raw 24-bit frames, divided by the total file size without the "
             "geometry of the scene. Each section states the size of the geometry.\n"
             "- In the videos, the last parameter changes fastest, alternately forwards and backwards, so "
             "neighbouring frames differ by one step of one parameter.\n"
             "- AV1 is encoded with `libaom-av1 -cpu-used 4`, and x265 uses `-preset slow`. Both codecs use constant "
             "quality, BT.709 4:4:4, 10 bit and full range. AVIF encodes each frame separately, with `-usage "
             "allintra`. "
             "The column *bytes* lists the size of the stream without a container.\n"
             "- If a video has a key frame every 64 frames, up to 64 frames must be decoded for a random sample. A "
             "chunk "
             "of `multum pack` can be decoded independently of other chunks.\n"
             "- Values between measured points are interpolated linearly, in the logarithm of the compression and the "
             "logarithm of the MSE."]
    for name in names:
        row = rows.find(name, "field", "inferred")
        if row is None:
            continue
        commits = ", ".join(sorted({one["commit"].removeprefix("commit ") for one in rows.all if one["field"] == name}))
        parts += [f"## {name}", f"{field_words(row)} Measured at commits {commits}.",
                  "Every packed file also needs the geometry, which is not included in the compression ratio: "
                  f"`{row['geometry']}`, {row['geometry_bytes']:,} bytes, or {row['geometry_deflated_bytes']:,} bytes "
                  "after deflation. Frames drawn from the inferred textures, without packing, have an MSE of "
                  f"{row['own']:.1f}.",
                  *curves_section(rows, name, video_codecs, stated, pictures), *coder_section(rows, name, main),
                  *inference_section(rows, name, stated), *costs_section(rows, name, main),
                  *dimensions_section(rows, name, video_codecs.LEADING),
                  *playing_section(rows, name, table)]
    return "\n\n".join(parts) + "\n"


def split_parameter(parser, text):
    """Parses PARAMETER=NAME:COUNT,... to ("PARAMETER", [("NAME", COUNT), ...])."""
    found = re.fullmatch(r"(\w+)=(\w+:[1-9]\d*(?:,\w+:[1-9]\d*)+)", text)
    if not found:
        parser.error(f"--split: '{text}' is not PARAMETER=NAME:COUNT,NAME:COUNT")
    parts = [one.split(":") for one in found.group(2).split(",")]
    return found.group(1), [(name, int(count)) for name, count in parts]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fields", nargs="+", type=pathlib.Path, metavar="FIELD")
    parser.add_argument("--bin", default="build/release/bin", type=pathlib.Path, help="folder of multum, multum-view")
    parser.add_argument("--work", required=True, type=pathlib.Path, help="folder of textures and packed files")
    parser.add_argument("--rows", type=pathlib.Path, help="file of measurements (default: WORK/rows.json)")
    parser.add_argument("--parts", nargs="+", default=[*PARTS], choices=PARTS, help="parts to measure (default: all)")
    parser.add_argument("--again", nargs="+", default=[], choices=PARTS, help="parts to measure again")
    parser.add_argument("--split", nargs=2, action="append", default=[], metavar=("FIELD", "PARAMETER=NAME:COUNT,..."),
                        help="divide a field's parameter; the last part changes fastest")
    parser.add_argument("--ratios", nargs="+", type=float, default=[48, 96, 192, 384, 768, 1000],
                        help="ratios of the curves of multum pack")
    parser.add_argument("--coders", nargs="+", default=("auto", "dct", "wavelet"),
                        help="coders of the curves of multum pack")
    parser.add_argument("--videos", nargs="+",
                        help="codecs whose names begin like this, such as 'AV1' (default: all)")
    parser.add_argument("--stated", nargs="+", type=float, default=RATIOS,
                        help="ratios that tables list (default: 192 384 768); parts of the coder are compared at the "
                             "middle ratio")
    parser.add_argument("--growth", nargs="+", type=float, default=GROWTH_RATIOS,
                        help="ratios at which numbers of parameters are compared (default: 96 192)")
    parser.add_argument("--measure-nothing", action="store_true", help="make the page only from existing rows")
    parser.add_argument("--context", default="auto", help="GL context: auto, egl, osmesa")
    parser.add_argument("--inferences", type=int, default=len(INFERENCES),
                        help="number of ways to infer; the first ways are used")
    parser.add_argument("--keep", action="store_true", help="also keep textures that were inferred in other ways")
    parser.add_argument("-o", "--output", required=True, type=pathlib.Path)
    committed_tree.add_option(parser)
    given = parser.parse_args()
    given.split = [(field, split_parameter(parser, text)) for field, text in given.split]
    return given


def main():
    given = arguments()
    commit = committed_tree.stated_commit(given.allow_dirty)
    use_a_python_with("numpy", "OpenImageIO")
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "playback"))
    import video_codecs
    from programs import Programs
    if {"video", "dimensions"} & set(given.parts) and not given.measure_nothing:
        video_codecs.require_ffmpeg()
    given.work.mkdir(parents=True, exist_ok=True)
    programs, rows = Programs(given.bin, given.context), Rows(given.rows or given.work / "rows.json", commit)
    if not given.measure_nothing:
        rows.forget([folder.name for folder in given.fields], [PARTS[part] for part in given.again])
    for folder in [] if given.measure_nothing else given.fields:
        split = next((one for name, one in given.split if name == folder.name), None)
        field = FieldMeasurement(*prepared(folder, given.work, programs, rows, split), programs, rows, given.stated)
        if "curves" in given.parts:
            field.measure_curves(given.ratios, given.coders)
        if "video" in given.parts:
            field.measure_videos(video_codecs, given.videos)
        if "coder" in given.parts:
            field.measure_coder_sets()
        if "costs" in given.parts:
            field.measure_costs()
        if "dimensions" in given.parts and len(field.field.parameters) > 2:
            field.measure_dimensions(video_codecs, given.growth)
        if "playing" in given.parts:
            field.measure_playing(video_codecs)
        if "inference" in given.parts:
            field.measure_inference(given.keep, given.inferences)
    names = [folder.name for folder in given.fields]
    used = [row for row in rows.all if row["field"] in names]
    machine = "; ".join([programs.version(), f"on {programs.devices()}",
                         *sorted({row["encoder"] for row in used if "encoder" in row})])
    given.output.parent.mkdir(parents=True, exist_ok=True)
    given.output.write_text(document(rows, names, video_codecs, given.stated, machine, given.output.parent / "images"))
    print(f"the document: {given.output}", flush=True)


if __name__ == "__main__":
    main()
