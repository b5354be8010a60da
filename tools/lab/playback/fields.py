# SPDX-License-Identifier: Apache-2.0
"""Reads fields of ray-traced frames from jobs of `multum infer`: the frames in the order of a video, in 8-bit values as
on a screen, and their errors compared with other frames."""
import json
import pathlib
import sys
import tomllib

import numpy as np
import OpenImageIO as oiio

GAMMA = 2.2
WHOLE = 1 - 1 / 512  # a pixel with at least this coverage counts as covered by only one object


def read_channels(path, names):
    """Reads float32 [height, width, len(names)], and the file's attributes."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        sys.exit(f"cannot read {path}: {oiio.geterror()}")
    spec = source.spec()
    missing = [name for name in names if name not in spec.channelnames]
    if missing:
        sys.exit(f"{path}: found the channels {', '.join(spec.channelnames)}, expected also {', '.join(missing)}")
    pixels = np.asarray(source.read_image(oiio.FLOAT), dtype=np.float32)
    attributes = {one.name: one.value for one in spec.extra_attribs}
    source.close()
    return np.stack([pixels[:, :, spec.channelindex(name)] for name in names], axis=2), attributes


def eight_bit(linear):
    """Converts linear radiance for a screen of gamma 2.2: uint8, 255 for 1 and above, 0 for NaN."""
    return np.rint(255 * np.clip(np.nan_to_num(linear, nan=0.0), 0, 1) ** (1 / GAMMA)).astype(np.uint8)


def squared_errors(frames, others):
    """Returns the mean over red, green and blue for each pixel, as float32 [frame, height, width]."""
    return np.stack([((a.astype(np.int32) - b) ** 2).mean(axis=2, dtype=np.float32) for a, b in zip(frames, others)])


def mse(frames, others):
    """Returns the mean squared error over all values of all frames."""
    return float(squared_errors(frames, others).mean(dtype=np.float64))


class Field:
    """A job's samples along a path through the parameters. The last parameter changes fastest, forwards and backwards,
    so that neighbours differ by one step."""

    def __init__(self, job):
        self.path = pathlib.Path(job)
        self.job = tomllib.loads(self.path.read_text())
        self.width, self.height = self.job["width"], self.job["height"]
        self.counts = [one["count"] for one in self.job["parameter"]]
        self.parameters = [one["name"] for one in self.job["parameter"]]
        by_place = {tuple(one["at"]): one for one in self.job["sample"]}
        self.samples = [by_place[place] for place in serpentine(self.counts)]
        self.geometry = self.path.parent / self.job["geometry"]
        self.raw_bytes = 3 * self.width * self.height * len(self.samples)

    def file(self, sample, key):
        return self.path.parent / sample[key]

    def traced_frames(self):
        """Returns uint8 [frame, height, width, 3]."""
        white = self.job.get("radiance_max", 1)
        return np.stack([eight_bit(read_channels(self.file(one, "radiance"), "RGB")[0] / white)
                         for one in self.samples])

    def object_numbers(self):
        """Returns the number of the job's object that covers most of each pixel, from 1, or 0 for none, as uint8
        [frame, height, width]."""
        known, frames = {}, []
        for one in self.samples:
            path = self.file(one, "object_index" if "object_index" in one else "geometry")
            if path not in known:
                known[path] = (self.indexed if "object_index" in one else self.cryptomatte)(path)
            frames.append(known[path])
        return np.stack(frames)

    def indexed(self, path):
        """Reads numbers from an object-index picture."""
        source = oiio.ImageInput.open(str(path))
        values = np.asarray(source.read_image(oiio.UINT8)).reshape(self.height, self.width)
        source.close()
        numbers = np.zeros_like(values)
        for number, one in enumerate(self.job["object"], start=1):
            numbers[values == one["index"]] = number
        return numbers

    def cryptomatte(self, path):
        """Reads numbers from the first rank of a Cryptomatte with its manifest in the file."""
        prefix = self.job.get("cryptomatte", "CryptoObject")
        planes, attributes = read_channels(path, [f"{prefix}00.r"])
        manifests = [json.loads(value) for name, value in attributes.items()
                     if name.startswith("cryptomatte/") and name.endswith("/manifest")]
        hashes = {name: int(value, 16) for manifest in manifests for name, value in manifest.items()}
        found = np.ascontiguousarray(planes[:, :, 0]).view(np.uint32)
        numbers = np.zeros(found.shape, np.uint8)
        for number, one in enumerate(self.job["object"], start=1):
            if one["cryptomatte"] in hashes:
                numbers[found == hashes[one["cryptomatte"]]] = number
        return numbers


def serpentine(counts):
    """Lists the cells of a grid. The last dimension changes fastest, and each line runs in the opposite direction of
    the previous line."""
    if not counts:
        return [()]
    path, rest = [], serpentine(counts[1:])
    for first in range(counts[0]):
        path += [(first, *place) for place in (rest if first % 2 == 0 else reversed(rest))]
    return path


def silhouettes(numbers):
    """Finds pixels with another object next to them, also diagonally. Returns bool, in the shape of `numbers`."""
    edges = np.zeros(numbers.shape, bool)
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        there = (slice(None), slice(dy, None), slice(max(dx, 0), numbers.shape[2] + min(dx, 0)))
        here = (slice(None), slice(0, numbers.shape[1] - dy),
                slice(max(-dx, 0), numbers.shape[2] - max(dx, 0)))
        differs = numbers[there] != numbers[here]
        edges[there] |= differs
        edges[here] |= differs
    return edges


def error_places(errors, numbers, names):
    """Divides squared errors by object and position. Returns rows (object or "", "silhouette" or "interior", share of
    pixels, their MSE, their part of the whole MSE). "" stands for pixels without an object."""
    edges, rows = silhouettes(numbers), []
    for number, name in enumerate(["", *names]):
        for kind, where in (("interior", ~edges), ("silhouette", edges)):
            chosen = errors[(numbers == number) & where]
            if chosen.size:
                total = float(chosen.sum(dtype=np.float64))
                rows.append({"object": name, "place": kind, "pixels": chosen.size / errors.size,
                             "mse": total / chosen.size, "part": total / errors.size})
    return rows
