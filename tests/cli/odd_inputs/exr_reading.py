# SPDX-License-Identifier: Apache-2.0
"""Reads OpenEXR files and baked files as the OpenEXR file layout and docs/reference/file_format.md say, with only
Python's standard library. Supports scan lines, tiles, several parts and several levels, which are uncompressed or
compressed with RLE, ZIPS or ZIP. Does not support deep data or subsampling."""
import hashlib
import math
import struct
import zlib

LINES = {0: 1, 1: 1, 2: 1, 3: 16}  # scan lines per chunk, by compression
PIXEL_TYPES = {0: ("I", 4), 1: ("e", 2), 2: ("f", 4)}


def text_at(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def read_header(data, at):
    """Returns {name: (type, bytes)} and the end offset of the header."""
    attributes = {}
    while data[at]:
        name, at = text_at(data, at)
        kind, at = text_at(data, at)
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = (kind, data[at + 4:at + 4 + size])
        at += 4 + size
    return attributes, at + 1


def run_lengths_decoded(data):
    out, i = b"", 0
    while i < len(data):
        count = struct.unpack_from("b", data, i)[0]
        if count < 0:
            out += data[i + 1:i + 1 - count]
            i += 1 - count
        else:
            out += data[i + 1:i + 2] * (count + 1)
            i += 2
    return out


def expanded(data, compression, size):
    """Returns a chunk's bytes. Compressed chunks store differences of bytes, first the even bytes and then the odd
    ones. Chunks that do not get smaller are stored unchanged."""
    if compression == 0 or len(data) == size:
        return data
    packed = bytearray(run_lengths_decoded(data) if compression == 1 else zlib.decompress(data))
    for i in range(1, len(packed)):
        packed[i] = packed[i - 1] + packed[i] - 128 & 255
    half = (len(packed) + 1) // 2
    out = bytearray(len(packed))
    out[0::2], out[1::2] = packed[:half], packed[half:]
    return bytes(out)


class Part:
    def __init__(self, attributes):
        self.attributes = attributes
        box = struct.unpack("<4i", attributes["dataWindow"][1])
        self.left, self.top = box[:2]
        self.width, self.height = box[2] - box[0] + 1, box[3] - box[1] + 1
        self.compression = attributes["compression"][1][0]
        # (name, type) of each channel, in the order within a row.
        self.channels, at, listed = [], 0, attributes["channels"][1]
        while listed[at]:
            name, at = text_at(listed, at)
            self.channels.append((name, struct.unpack_from("<i", listed, at)[0]))
            at += 16
        self.tile, self.level_count = None, 1
        if "tiles" in attributes:
            tile_width, tile_height, mode = struct.unpack("<IIB", attributes["tiles"][1])
            self.tile = tile_width, tile_height
            assert mode in (0, 1), "neither one level nor mip levels that are rounded down"
            self.level_count = 1 + int(math.log2(max(self.width, self.height))) if mode == 1 else 1
        self.levels = [{name: [0.0] * (w * h) for name, _ in self.channels} for w, h in map(self.size, self.all())]

    def all(self):
        return range(self.level_count)

    def size(self, level):
        return max(1, self.width >> level), max(1, self.height >> level)

    def chunk_count(self):
        if self.tile is None:
            return -(-self.height // LINES[self.compression])
        return sum(-(-w // self.tile[0]) * -(-h // self.tile[1]) for w, h in map(self.size, self.all()))

    def text(self, name):
        return self.attributes[name][1].decode()

    def number(self, name):
        kind, data = self.attributes[name]
        return struct.unpack("<i" if kind == "int" else "<f", data)[0]

    def add_chunk(self, data, at):
        """Reads the part of a chunk that follows its part number."""
        if self.tile is None:
            level, left = 0, 0
            top = struct.unpack_from("<i", data, at)[0] - self.top
            size, at = struct.unpack_from("<i", data, at + 4)[0], at + 8
            width, height = self.width, min(LINES[self.compression], self.height - top)
        else:
            column, row, level, _, size = struct.unpack_from("<5i", data, at)
            at += 20
            left, top = column * self.tile[0], row * self.tile[1]
            w, h = self.size(level)
            width, height = min(self.tile[0], w - left), min(self.tile[1], h - top)
        row_bytes = sum(PIXEL_TYPES[kind][1] for _, kind in self.channels) * width
        values, position = expanded(data[at:at + size], self.compression, row_bytes * height), 0
        for y in range(top, top + height):
            for name, kind in self.channels:
                letter, length = PIXEL_TYPES[kind]
                begin = y * self.size(level)[0] + left
                numbers = struct.unpack_from(f"<{width}{letter}", values, position)
                self.levels[level][name][begin:begin + width] = numbers
                position += length * width


def read_exr(data):
    """Returns the parts of a file with all their levels."""
    magic, version = struct.unpack_from("<II", data)
    assert magic == 20000630 and version & 255 == 2, "no OpenEXR file"
    parts, at, is_multi_part = [], 8, version & 0x1000 != 0
    while True:
        attributes, at = read_header(data, at)
        parts.append(Part(attributes))
        if not is_multi_part:
            break
        if data[at] == 0:
            at += 1
            break
    for part in parts:
        for _ in range(part.chunk_count()):
            chunk = struct.unpack_from("<Q", data, at)[0]
            at += 8
            if is_multi_part:
                parts[struct.unpack_from("<i", data, chunk)[0]].add_chunk(data, chunk + 4)
            else:
                part.add_chunk(data, chunk)
    return parts


# The following functions read baked files.

ORDER = "RGBAXYZ"


def in_order(part):
    """Returns the part's channels in the order of docs/reference/file_format.md's table: R, G, B, A or X, Y, Z per
    layer."""
    def place(name):
        if part.text("name") == "finest":
            passes = ("albedo", "lobe", "normalX", "normalY", "normalZ", "square", "weights")
            return passes.index(name.split(".")[1]), ORDER.index(name[-1])
        return (0, ORDER.index(name[-1])) if "." in name else (0, name)

    return sorted((name for name, _ in part.channels), key=place)


def content_hash(parts):
    digests = ""
    for part in parts:
        for level in part.levels:
            planes = [level[name] for name in in_order(part)]
            values = [value for texel in zip(*planes) for value in texel]
            digests += hashlib.sha256(struct.pack(f"<{len(values)}f", *values)).hexdigest()
    return hashlib.sha256(digests.encode()).hexdigest()


def finest_z(x, y, encoding):
    """Implements docs/reference/file_format.md, "The finest level"."""
    if encoding == "snorm16":
        i, j = round(x * 32767), round(y * 32767)
        square = max(0, 32767**2 - i * i - j * j)
        root = math.isqrt(square)
        return (root + (root * root < square)) / 32767
    return math.sqrt(max(0.0, 1.0 - x * x - y * y))


class Baked:
    """Reads level 0 of a baked file: `normals` [texel][3], `colours`, and `weights`. With roughness, normals are
    shorter than 1."""

    def __init__(self, data):
        parts = {part.text("name"): part for part in read_exr(data)}
        first = next(iter(parts.values()))
        representation = first.text("multum:representation")
        assert first.text("multum:contentHash") == content_hash(list(parts.values())), "the content hash differs"
        assert first.number("multum:firstLevel") == 0
        self.width, self.height = first.number("multum:mapWidth"), first.number("multum:mapHeight")
        assert (first.width, first.height) == (self.width, self.height)
        has_colours = first.number("multum:hasColours") != 0
        weights = first.number("multum:weightCount") if "multum:weightCount" in first.attributes else 0
        if representation == "moments":
            self.normals = self.of(parts["normal"], "normal.mean", "XYZ")
            self.colours = self.of(parts["colour"], "colour.albedo", "RGB") if has_colours else None
            self.weights = self.of(parts["weights"], "weights.blend", "RGBA"[:weights]) if weights else None
        else:
            assert representation == "movmf"
            finest = parts["finest"]
            layer = finest.levels[0]
            x, y = layer["finest.normalX.X"], layer["finest.normalY.X"]
            z = layer.get("finest.normalZ.X") or [
                finest_z(*xy, first.text("multum:encoding")) for xy in zip(x, y)]
            self.normals = list(zip(x, y, z))
            self.colours = self.of(finest, "finest.albedo", "RGB") if has_colours else None
            self.weights = self.of(finest, "finest.weights", "RGBA"[:weights]) if weights else None

    @staticmethod
    def of(part, layer, names):
        return list(zip(*(part.levels[0][f"{layer}.{name}"] for name in names)))
