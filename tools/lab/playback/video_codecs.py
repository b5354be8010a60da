# SPDX-License-Identifier: Apache-2.0
"""Codes frames with video and picture codecs of Debian's ffmpeg. Returns the bytes of the stream without its
container, and the decoded frames. Colours are BT.709 YCbCr, full range, 4:4:4, 10 bit. This module converts colours,
exactly and equally for all codecs.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

MISSING = ("found no ffmpeg, which codes the videos for the comparison. Install it (Debian: apt-get install "
           "ffmpeg), or leave the videos out: --parts without 'video'.")
TO_YCBCR = np.array([[0.2126, 0.7152, 0.0722],
                     [-0.2126 / 1.8556, -0.7152 / 1.8556, 0.5],
                     [0.5, -0.7152 / 1.5748, -0.0722 / 1.5748]])
OFFSET = np.array([0.0, 512.0, 512.0])


def ycbcr(frames):
    """Converts uint8 RGB [frame, height, width, 3] to uint16 [frame, 3, height, width], 0..1023."""
    planes = np.einsum("pc,fyxc->fpyx", TO_YCBCR, frames.astype(np.float64) * (1023 / 255))
    return np.clip(np.rint(planes + OFFSET[:, None, None]), 0, 1023).astype("<u2")


def rgb(planes):
    values = np.einsum("cp,fpyx->fyxc", np.linalg.inv(TO_YCBCR), planes - OFFSET[:, None, None]) * (255 / 1023)
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


class Codec:
    def __init__(self, name, kind, key_distance, qualities, options, overhead):
        """`kind` is ffmpeg's format of a bare stream. `qualities` are values of -crf, from the best to the worst
        quality. `overhead` is the number of bytes per frame that mark its beginning, as in a container."""
        self.name, self.kind, self.qualities, self.overhead = name, kind, qualities, overhead
        self.key_distance, self.options = key_distance, options


def av1(key_distance):
    return Codec(f"AV1, a key frame every {key_distance}", "obu", key_distance, (20, 28, 36, 44, 50, 55, 59, 63),
                 ["-c:v", "libaom-av1", "-cpu-used", "4", "-b:v", "0", "-row-mt", "1", "-g", str(key_distance),
                  "-keyint_min", str(key_distance)], 2)


def x265(key_distance):
    settings = f"keyint={key_distance}:min-keyint={key_distance}:scenecut=0:info=0:log-level=error"
    return Codec(f"x265, a key frame every {key_distance}", "hevc", key_distance, (16, 22, 27, 31, 35, 39, 43, 48),
                 ["-c:v", "libx265", "-preset", "slow", "-x265-params", settings], 0)


AVIF = Codec("AVIF, each frame by itself", "obu", 1, (30, 40, 48, 54, 58, 61, 63),
             ["-c:v", "libaom-av1", "-cpu-used", "4", "-b:v", "0", "-usage", "allintra", "-g", "0"], 2)
CODECS = (av1(64), av1(8), x265(64), x265(8), AVIF)
LEADING = CODECS[0].name  # the codec with which multum is compared


def require_ffmpeg():
    if shutil.which("ffmpeg") is None:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {MISSING}")


def ffmpeg(*words):
    done = subprocess.run(["ffmpeg", "-hide_banner", "-loglevel", "error", "-y", *map(str, words)],
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"ffmpeg failed: ffmpeg {' '.join(map(str, words))}\n{done.stderr[-2000:]}")


def version():
    first = subprocess.run(["ffmpeg", "-version"], capture_output=True, text=True, check=True).stdout.split("\n")[0]
    return " ".join(first.split()[:3])


def coded(codec, quality, frames):
    """Returns bytes of the stream, and the decoded frames as uint8 RGB like `frames`."""
    count, height, width, _ = frames.shape
    raw = ["-f", "rawvideo", "-pix_fmt", "yuv444p10le", "-s", f"{width}x{height}", "-r", "30"]
    with tempfile.TemporaryDirectory() as folder:
        stream, planes = os.path.join(folder, "stream"), os.path.join(folder, "planes")
        ycbcr(frames).tofile(planes)
        ffmpeg(*raw, "-i", planes, *codec.options, "-crf", quality, "-color_range", "pc", "-colorspace", "bt709",
               "-f", codec.kind, stream)
        ffmpeg("-f", codec.kind, "-i", stream, "-f", "rawvideo", "-pix_fmt", "yuv444p10le", planes)
        decoded = np.fromfile(planes, "<u2").reshape(-1, 3, height, width)
        if len(decoded) != count:
            sys.exit(f"{codec.name}: {len(decoded)} decoded frames, expected {count}")
        return os.path.getsize(stream) - codec.overhead * count, rgb(decoded.astype(np.float64))


def best_within(codec, size_max, frames):
    """Returns bytes and frames of the best stream with at most this many bytes, or of the smallest stream if none
    fits."""
    low, high = 1, 63
    best = coded(codec, high, frames)
    while low < high:  # sizes decrease as the quality number increases
        middle = (low + high) // 2
        found = coded(codec, middle, frames)
        if found[0] <= size_max:
            best, high = found, middle
        else:
            low = middle + 1
    return best
