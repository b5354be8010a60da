# SPDX-License-Identifier: Apache-2.0
"""Measures how a packed field plays: seek times compared with AV1, frames per second, block borders, memory, and the
speed in a browser. `multum-view play` draws. Everything except the browser runs on one core.

Writes rows of kind "playing". Stop other work on the machine, because it makes times longer and more variable.
"""
import itertools
import json
import math
import os
import pathlib
import random
import re
import shutil
import statistics
import subprocess
import tempfile

import numpy as np
from fields import mse
from measured_run import run, succeed
from video_seeks import VideoSeeks

ROUNDS = 5  # rounds in which both programs run alternately
SEED = 26
MEMORIES = ("256M", "128M", "64M", "48M", "40M", "32M")
SIDES = (1, 2, 4)  # sub-pixels along each side of a pixel
BLOCKED = {"blocks of 4": ("--block", "4"), "blocks of 4, staggered": ("--block", "4", "--stagger", "yes")}
BROWSERS = ("chromium-headless-shell", "chromium")
ROOT = pathlib.Path(__file__).resolve().parents[3]


def quantile(values, p):
    """Returns the quantile by the nearest rank."""
    ordered = sorted(values)
    return ordered[max(0, math.ceil(p * len(ordered)) - 1)]


def diagonals(counts):
    """Lists every cell of the grid once, one diagonal after another. Each frame is one step further along all
    parameters."""
    places = {}
    for begin in itertools.product(*map(range, counts)):
        for step in range(max(counts)):
            places[tuple((at + step) % count for at, count in zip(begin, counts))] = None
    return list(places)


class Player:
    """Plays one packed file along places, one per frame, on one core."""

    def __init__(self, programs, file, parameters, scratch):
        self.programs, self.file, self.parameters, self.scratch = programs, file, parameters, scratch
        self.core = min(os.sched_getaffinity(0))

    def play(self, places, *options):
        """Returns the frames of statistics.json, and the whole file. Draws the first cell twice, and drops the
        first frame, which compiles shaders."""
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir()
        path = self.scratch / "path.json"
        all_places = [places[0], *places]
        positions = [[number, *place] for number, place in enumerate([*all_places, all_places[-1]])]
        path.write_text(json.dumps({"multumPath": 1, "parameters": self.parameters, "positions": positions}))
        succeed(["taskset", "-c", f"{self.core}", self.programs.viewer, "play", self.file, "--path", path, "--rate",
                 "1", "-o", self.scratch, "--context", self.programs.context, *map(str, options)])
        whole = json.loads((self.scratch / "statistics.json").read_text())
        return whole["frames"][1:], whole

    def pictures(self, count):
        import OpenImageIO as oiio
        files = [self.scratch / f"frame_{number + 1:04}.png" for number in range(count)]
        return np.stack([np.asarray(oiio.ImageBuf(str(file)).get_pixels(oiio.UINT8))[:, :, :3] for file in files])


def seek_rows(player, streams, counts):
    """Returns p50 and p99 of each round. Both programs seek the same random samples alternately."""
    chooser = random.Random(SEED)
    rounds = []
    for _ in range(ROUNDS):
        places = [tuple(chooser.randrange(count) for count in counts) for _ in range(math.prod(counts))]
        frames, _ = player.play(places, "--cold", "--ahead", "0", "--threads", "1", "--supersampling", "1")
        drawn = [one["prepare_ms"] + one["draw_ms"] for one in frames]
        line = {"multum": [one["decoding_processor_ms"] for one in frames], "multum, drawn": drawn}
        images = max(one["images_decoded"] for one in frames)
        for stream in streams:
            numbers = [serpentine_number(place, counts) for place in places]
            affinity = os.sched_getaffinity(0)
            os.sched_setaffinity(0, {player.core})
            seeks = [stream.seek(number) for number in numbers]
            os.sched_setaffinity(0, affinity)
            line[stream.codec.name] = [1e3 * worked for _, worked, _ in seeks]
        rounds.append({name: {"p50": quantile(ms, 0.5), "p99": quantile(ms, 0.99),
                              "mean": statistics.fmean(ms)} for name, ms in line.items()})
    return {"rounds": rounds, "textures_most": images, "chunks_most": max(one["chunks_decoded"] for one in frames),
            "frames_most": {stream.codec.name: stream.codec.key_distance for stream in streams},
            "stream_bytes": {stream.codec.name: sum(map(len, stream.units)) for stream in streams}}


def serpentine_number(place, counts):
    number = 0
    for d, count in enumerate(counts):
        here = place[d] if number % 2 == 0 else count - 1 - place[d]
        number = number * count + here
    return number


def frame_times(frames):
    ms = [one["prepare_ms"] + one["draw_ms"] for one in frames]
    return {"frames": len(ms), "per_second": 1e3 * len(ms) / sum(ms), "worst_ms": max(ms),
            "prepare_ms": statistics.fmean(one["prepare_ms"] for one in frames),
            "draw_ms": statistics.fmean(one["draw_ms"] for one in frames),
            "upload_ms": statistics.fmean(one["upload_ms"] for one in frames),
            "decoding_ms": max(0.0, statistics.fmean(one["decoding_processor_ms"] for one in frames)),
            "decoding_worst_ms": max(one["decoding_processor_ms"] for one in frames),
            "chunks_most": max(one["chunks_decoded"] for one in frames)}


def measure_playing(measurement, video_codecs, quality_of):
    """`measurement` is a FieldMeasurement. `quality_of(codec)` returns the -crf whose error is most similar to that of
    the packed file."""
    field, programs = measurement.field, measurement.programs

    def packed(label, options):
        file = measurement.scratch / (re.sub(r"\W+", "_", label) + ".mpt")
        if not file.exists() and programs.pack(measurement.inferred, file, [*measurement.main, *options]).code != 0:
            raise SystemExit(f"multum pack cannot write {file}")
        return file

    def player_of(label, options=()):
        return Player(programs, packed(label, options), field.parameters, measurement.scratch / "played")

    def row(name, measure):
        measurement.rows.measured(measurement.name, "playing", name, measure)

    def seeks():
        streams = [VideoSeeks(codec, quality_of(codec), measurement.traced)
                   for codec in video_codecs.CODECS if codec.name.startswith("AV1")]
        return {"decoder": f"dav1d {streams[0].decoder.version}",
                **seek_rows(player_of("playing"), streams, field.counts)}

    row("seeks", seeks)
    still, every = [(0.0,) * len(field.counts)] * 30, diagonals(field.counts)
    for side in SIDES:
        row(f"cached, {side} x {side}", lambda: frame_times(
            player_of("playing").play([(0.01 * n, *still[0][1:]) for n in range(30)], "--supersampling", side)[0]))
        row(f"diagonal, {side} x {side}", lambda: frame_times(
            player_of("playing").play(every, "--supersampling", side)[0]))
    for label, options in BLOCKED.items():
        for ahead in (0, 8):
            row(f"borders, {label}, {ahead} ahead", lambda: {"ahead": ahead, **frame_times(
                player_of(label, options).play(every, "--supersampling", 1, "--ahead", ahead, "--lifetime", 4,
                                               "--threads", 1)[0])})
        row(f"error, {label}", lambda: {"mse": mse(programs.unpacked_frames(
            packed(label, options), field, measurement.scratch / "unpacked"), measurement.traced),
            "bytes": packed(label, options).stat().st_size})

    def memory(size):
        player = player_of("playing")
        if not measurement_fits(player, every, size):
            return {"fits": False}
        frames, whole = player.play(every, "--no-wait", "--memory", size, "--supersampling", 1)
        shown = player.pictures(len(frames))
        player.play(every, "--supersampling", 1)
        return {"fits": True, "bytes_most": whole["bytes_most"], "mse": mse(shown, player.pictures(len(frames))),
                "missing": sum(one["images_missing"] for one in frames) / sum(one["images_needed"] for one in frames),
                **frame_times(frames)}

    for size in MEMORIES:
        row(f"memory, {size}", lambda: memory(size))
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    modules = ROOT / "tests/service/web" / "node_modules" / "playwright-core"
    if browser and shutil.which("node") and modules.exists():
        row("browser", lambda: in_browser(programs, packed("playing", ()), browser))


def measurement_fits(player, places, size):
    """Tests whether a frame's textures fit into this much memory."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["play", player.file, "--path", f"{player.parameters[0]}=0", "--frames", "1", "--no-wait", "--memory",
                 size, "-o", folder, "--context", player.programs.context, "--supersampling", "1"]
        return run([player.programs.viewer, *words]).code == 0


def in_browser(programs, file, browser):
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "page.html"
        succeed([programs.multum, "player", file, "-o", page])
        done = subprocess.run(["node", str(ROOT / "tools/lab/playback/browser_speed.mjs"), browser, str(page)],
                              capture_output=True, text=True, check=False, timeout=600)
        if done.returncode:
            raise SystemExit(f"browser_speed.mjs: {done.stderr[-2000:]}")
        return json.loads(done.stdout)


# ---- the page

def spoken(codec):
    """Returns the name of a codec for use in a sentence."""
    return f"{codec.replace(', a key', ' with a key')} frames" if ", a key frame every" in codec else codec


def spread(values, digits=1):
    return f"{statistics.median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def seek_section(row, table):
    names = list(row["rounds"][0])
    videos = list(row["frames_most"])
    lines = []
    for name in names:
        most = row["frames_most"].get(name)
        decoded = f"{most} frames" if most else f"{row['textures_most']} textures of {row['chunks_most']} chunks"
        ratios = ["1" if name == "multum" else spread([one[name][key] / one["multum"][key] for one in row["rounds"]], 2)
                  for key in ("p50", "p99")]
        shown = {"multum": "decoded to textures, processor ms",
                 "multum, drawn": "decoded, uploaded and drawn on one core, elapsed ms"}
        lines.append([shown.get(name, f"{name}, dav1d, processor ms"),
                      spread([one[name]["p50"] for one in row["rounds"]]),
                      spread([one[name]["p99"] for one in row["rounds"]]), *ratios, decoded])
    verdict = []
    for name in videos:
        ratio = statistics.median(one["multum"]["p50"] / one[name]["p50"] for one in row["rounds"])
        verdict.append(f"{ratio:.1f} times as long as the median seek in {spoken(name)}")
    return ["#### Seeks to random samples from a cold cache",
            table(["ms", "p50", "p99", "p50 / p50 of the first row", "p99 / p99 of the first row",
                   "most textures decoded"], lines),
            f"All programs looked up random samples alternately in {len(row['rounds'])} rounds, with one thread "
            "on one core. The table lists medians of the rounds, with ranges in brackets. Ratios compare programs "
            "within a round. AV1 "
            "uses the quality setting whose error is most similar to the error of the packed file. "
            f"lib{row['decoder']} decodes all frames from the key frame to the requested frame, without colour "
            f"conversion. The median seek takes {', and '.join(verdict)}. To decode any texture of a block, the "
            "decoder must read the coefficients of all samples of the block. The textures of a block cover "
            "everything that is visible in any view of the block. A block therefore contains several times as many "
            "texels as one frame needs."]


def rate_section(found, table):
    lines = []
    for name in ("cached", "diagonal"):
        for side in SIDES:
            row = found.get(f"{name}, {side} x {side}")
            if row:
                lines.append([name, f"{side} x {side}", f"{row['per_second']:.1f}", f"{row['worst_ms']:.0f}",
                              *[f"{row[key]:.1f}" for key in ("decoding_ms", "upload_ms", "prepare_ms", "draw_ms")]])
    return ["#### Frames per second", table(
        ["path", "sub-pixels", "frames per second", "slowest frame, ms", "decoding, processor ms per frame",
         "upload, ms", "preparing, ms", "drawing, ms"], lines),
        "`multum-view play` draws with Mesa's software renderer and decodes on the same core. On the *cached* path, "
        "the view moves between two neighbouring samples, whose textures are already decoded. On the *diagonal* "
        "path, each frame moves one sample further along all parameters, until all samples have been shown. Each "
        "frame waits for "
        "the textures of its sample. For a diagonal path on hardware of 1999, at 640 x 480 pixels, the paper "
        "reports averages of 2.4 (full size) and 8.8 frames per second (reduced textures) with cosines, and of 0.39 "
        "and 2.6 with wavelets. For a cached path, the paper reports 34 frames per second."] if lines else []


def border_section(found, table):
    lines = []
    for label, options in BLOCKED.items():
        error = found.get(f"error, {label}")
        for ahead in (0, 8):
            row = found.get(f"borders, {label}, {ahead} ahead")
            if row and error:
                lines.append([f"`{' '.join(options)}`", f"{error['bytes']:,}", f"{error['mse']:.1f}", ahead,
                              f"{row['per_second']:.1f}", f"{row['worst_ms']:.0f}", f"{row['decoding_worst_ms']:.1f}",
                              row["chunks_most"]])
    return ["#### Playback across block borders", table(
        ["options", "bytes", "MSE", "frames decoded ahead", "frames per second", "slowest frame, ms",
         "most decoding in a frame, processor ms", "most chunks in a frame"], lines),
        "The path is the diagonal with 1 x 1 sub-pixels. Textures that are not used for 4 frames are dropped. With "
        "`--stagger`, the blocks of the objects begin at different samples, so fewer blocks are decoded in one frame, "
        "and the blocks at the ends are smaller. If no frames are decoded ahead, every run decodes the same "
        "blocks in the same frames. Frame times still vary, because other programs run on the "
        "machine."] if lines else []


def memory_section(found, table):
    lines = []
    for size in MEMORIES:
        row = found.get(f"memory, {size}")
        if row and not row["fits"]:
            lines.append([size, "-", "-", "-",
                          "multum-view stops with an error, because one frame does not fit into this memory"])
        elif row:
            lines.append([size, f"{row['bytes_most'] / 2 ** 20:.1f}", f"{row['mse']:.2f}",
                          f"{100 * row['missing']:.0f}", f"{row['per_second']:.1f} frames per second"])
    return ["#### Memory and quality", table(
        ["`--memory`", "peak, MiB", "MSE compared with frames that wait", "late images, %", ""], lines),
        "The path is the diagonal. With `--no-wait`, the player draws each frame with the textures that have "
        "been decoded by then."] if lines else []


def browser_section(row, found, table):
    if not row:
        return []
    lines = []
    for one in row["draw"]:
        own = found.get(f"cached, {one['side']} x {one['side']}")
        lines.append([f"only drawing, {'blended' if one['isSmooth'] else 'nearest'}", f"{one['side']} x {one['side']}",
                      f"{one['perSecond']:.1f}", f"{one['p50Ms']:.1f}", f"{one['p99Ms']:.1f}",
                      f"{own['per_second']:.1f}" if own and not one["isSmooth"] else ""])
    for one in row["cached"]:
        lines.append([f"cached, shown, {'blended' if one['isSmooth'] else 'nearest'}", f"{one['side']} x {one['side']}",
                      f"{one['perSecond']:.1f}", "", "", ""])
    for one in row["diagonal"]:
        own = found.get(f"diagonal, {one['side']} x {one['side']}")
        lines.append(["diagonal", f"{one['side']} x {one['side']}", f"{one['perSecond']:.1f}", f"{one['p50Ms']:.1f}",
                      f"{one['p99Ms']:.1f}", f"{own['per_second']:.1f}" if own else ""])
    diagonal, profile = row["diagonal"][0], row["profile"]
    return ["#### In the browser", table(
        ["path", "sub-pixels", "frames per second", "p50, ms", "p99, ms",
         "frames per second of `multum-view play`"], lines),
        f"The browser is headless Chromium {row['browser']} with SwiftShader, {row['width']} x {row['height']} pixels, "
        "on all cores. In rows with *only drawing*, the page waits until each frame is finished. In rows with *shown*, "
        "the view moves, and the page chooses the number of sub-pixels.",
        f"On the diagonal, each frame waits {diagonal['waitingMs']:.0f} ms for textures from {diagonal['workers']} "
        f"worker, and needs {diagonal['drawingMs']:.0f} ms for uploading and drawing. Drawing is the slowest part. A "
        f"picture with one sub-pixel per pixel takes {profile['wholeMs']:.1f} ms: {profile['withoutObjectsMs']:.1f} ms "
        f"for a picture without objects (mean and sRGB), {profile['smallMs']:.1f} ms for a picture with 16 x 12 pixels "
        "(triangle vertices), and the rest for two lookups per pixel in half-float textures. While the view moves on a "
        "slow device, the page reads one mip level. At rest, the page reads two mip levels, and a picture takes "
        f"{profile['twoLevelsMs']:.1f} ms.",
        "The page increases the number of sub-pixels as long as frames take less than 45 ms. It therefore shows "
        "fewer pictures per second than it could draw, but in higher quality. The first frame of the diagonal is the "
        "slowest, because all chunks for this frame must be decoded."]


def playing_section(rows, name, table):
    found = {row["name"]: row for row in rows.of(name, "playing")}
    parts = []
    if "seeks" in found:
        parts += seek_section(found["seeks"], table)
    parts += [*rate_section(found, table), *border_section(found, table), *memory_section(found, table),
              *browser_section(found.get("browser"), found, table)]
    return ["### Playing", *parts] if parts else []
