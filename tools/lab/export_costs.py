# SPDX-License-Identifier: Apache-2.0
"""Compares the time and memory for exporting a large map with those of Filament's roughness-prefilter, and writes the
section of docs/evidence/EXPORT.md about them."""
import pathlib
import shutil
import statistics

import numpy
import OpenImageIO

from measured_run import succeed

SIDE = 4096
ROUNDS = 5
ROUGHNESS = 0.25
PREFILTER = "roughness-prefilter"  # from Debian's package libfilament-tools
# Each row contains the name of the runs in the file of --state, a title, and options of `multum export`.
WAYS = (("KTX2, `--format ktx2`", "KTX2, `--format ktx2`", ["--format", "ktx2"]),
        ("the same, `--fast`", "KTX2, `--fast`", ["--format", "ktx2", "--fast"]),
        ("PNG, an image a level", "PNG, one image per level", ["--format", "png"]))
FORMATS = ("exr", "ktx", "png")  # formats of roughness-prefilter; ratios are relative to the fastest format

HEAD = """## Time and memory

The input is `{map}`, repeated to {side} x {side} texels, as a PNG with 8 bits per channel. `multum export` writes
normals, occlusion, roughness and metalness for all levels, and does not measure errors. roughness-prefilter
({version}) writes only roughness. All programs ran alternately in {rounds} rounds. The table lists medians, with
ranges in brackets. Each ratio compares a run with the fastest format of roughness-prefilter in the same round.

| | processor time, s | ratio | memory, MiB |
|---|---|---|---|
"""


def write_repeated(source, output):
    """Writes a map of SIDE x SIDE texels that repeats the source map."""
    texels = OpenImageIO.ImageBuf(str(source)).get_pixels(OpenImageIO.UINT8)[:, :, :3]
    counts = [-(-SIDE // size) for size in texels.shape[:2]]
    texels = numpy.ascontiguousarray(numpy.tile(texels, (*counts, 1))[:SIDE, :SIDE])
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(SIDE, SIDE, 3, OpenImageIO.UINT8))
    image.set_pixels(OpenImageIO.ROI(0, SIDE, 0, SIDE, 0, 1, 0, 3), texels)
    if not image.write(str(output)):
        raise OSError(f"{output}: {image.geterror()}")


def measure(multum, source, folder):
    """Returns the processor seconds and the bytes of memory of each round, by name. Returns None if Filament's tool is
    not installed."""
    if shutil.which(PREFILTER) is None:
        return None
    folder = pathlib.Path(folder)
    large = folder / "large.png"
    write_repeated(source, large)
    commands = {name: [multum, "export", large, "-o", folder / "large", "--base-roughness", ROUGHNESS, "--no-measure",
                       "--quiet", *options] for name, _, options in WAYS}
    for kind in FORMATS:
        commands[kind] = [PREFILTER, "-r", ROUGHNESS, "-f", kind, large, folder / f"filament.{kind}"]
    runs = {name: [] for name in commands}
    for _ in range(ROUNDS):
        for name, command in commands.items():
            shutil.rmtree(folder / "large", ignore_errors=True)
            run = succeed(command)
            runs[name].append([run.processor_seconds, run.memory_bytes])
            print(f"{name}: {run.processor_seconds:.2f} s, {run.memory_bytes >> 20} MiB", flush=True)
    version = succeed(["dpkg-query", "-W", "-f", "${Package} ${Version}", "libfilament-tools"]).text
    return {"map": source.name, "version": version, "runs": runs}


def shown(values, form):
    return f"{form} ({form} to {form})".format(statistics.median(values), min(values), max(values))


def section(costs):
    runs = costs["runs"]
    seconds = {name: [run[0] for run in rounds] for name, rounds in runs.items()}
    quickest = min(FORMATS, key=lambda kind: statistics.median(seconds[kind]))
    names = {**{name: f"`multum export`, {title}" for name, title, _ in WAYS},
             quickest: f"Filament's roughness-prefilter, {quickest.upper()}"}
    lines = []
    for name, title in names.items():
        ratios = [one / other for one, other in zip(seconds[name], seconds[quickest])]
        ratio = "1" if name == quickest else shown(ratios, "{:.2f}")
        memory = statistics.median(run[1] for run in runs[name]) / 2**20
        lines.append(f"| {title} | {shown(seconds[name], '{:.1f}')} | {ratio} | {memory:.0f} |\n")
    return HEAD.format(side=SIDE, map=costs["map"], version=costs["version"],
                       rounds=len(runs[quickest])) + "".join(lines)
