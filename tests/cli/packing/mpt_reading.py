# SPDX-License-Identifier: Apache-2.0
"""Reads packed fields, NAME.mpt, as docs/reference/packed_fields.md, "Packed fields", says. Uses only Python and
numpy.

As a program it writes 32-bit floats one after another:
    mpt_reading.py FILE OUTPUT           the texture of every sample of every chunk, in the index's order, gamma-coded,
                                         [height][width][3]; prints a line of JSON about the chunks
    mpt_reading.py --field FILE OUTPUT   radiance with all mip levels, finest first, of every layer and every sample of
                                         the description that has a texture
"""
import json
import struct
import sys
import zlib

import numpy as np

from mpt_cosines import CosineStream, band_of, cosine_samples
from mpt_wavelets import WaveletStream, wavelet_bands, wavelet_samples

SINGLE = np.float32


class ByteReader:
    """Reads numbers from bytes, and refuses to read beyond their end."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def bytes(self, count):
        if count > len(self.data) - self.at:
            raise ValueError("cut short")
        self.at += count
        return self.data[self.at - count:self.at]

    def fixed(self, form):
        return struct.unpack("<" + form, self.bytes(struct.calcsize("<" + form)))[0]

    def number(self):
        value = 0
        for shift in range(0, 63, 7):
            byte = self.fixed("B")
            value |= (byte & 127) << shift
            if byte < 128:
                return value
        raise ValueError("a number of more than nine bytes")


def crc64_table():
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0xc96c5795d7870f42 if value & 1 else 0)
        table.append(value)
    return table


CRC64 = crc64_table()


def checksum(data):
    value = (1 << 64) - 1
    for byte in data:
        value = value >> 8 ^ CRC64[(value ^ byte) & 255]
    return ~value & 0xffffffff


class Section:
    def __init__(self, kind, layer, block, length, checksum_):
        self.kind, self.layer, self.block, self.length, self.checksum = kind, layer, block, length, checksum_
        self.offset = 0


class PackedField:
    """Holds `sections` and a `description`. `chunk()` decodes one chunk."""

    def __init__(self, data):
        self.data, reader = data, ByteReader(data)
        if reader.bytes(4) != b"MPTF" or reader.fixed("B") != 2:
            raise ValueError("no packed field of version 2")
        index_end = 9 + reader.fixed("I")
        index = ByteReader(reader.bytes(index_end - 9))
        if reader.fixed("I") != checksum(data[:index_end]):
            raise ValueError("the index is damaged")
        self.sections, offset = [], reader.at
        for _ in range(index.number()):
            section = Section(*(index.number() for _ in range(4)), index.fixed("I"))
            section.offset = offset
            offset += section.length
            self.sections.append(section)
        if index.at != len(index.data) or offset != len(data):
            raise ValueError("the file or its index is longer or shorter than its sections")
        found = [section for section in self.sections if section.kind == 0]
        self.description = self.inflated(self.bytes_of(found[0])) if found else None

    @staticmethod
    def inflated(data):
        reader = ByteReader(data)
        length = reader.number()
        text = zlib.decompress(data[reader.at:])
        if len(text) != length:
            raise ValueError("the description is of another length than it says")
        return json.loads(text)

    def bytes_of(self, section):
        data = self.data[section.offset:section.offset + section.length]
        if checksum(data) != section.checksum:
            raise ValueError("a section is damaged")
        return data

    def layers(self):
        """Returns (object, layer) of the description, numbered as in sections."""
        return [(item, layer) for item in self.description["objects"] for layer in item["layers"]]

    def chunk(self, layer, block):
        """Returns the chunk of a block, or None if no sample of the block has a texture."""
        for section in self.sections:
            if (section.kind, section.layer, section.block) == (1, layer, block):
                return TextureChunk(self.bytes_of(section))
        return None

    def place_of(self, layer, sample):
        """Returns (block, texture of the block's chunk) for a sample, which is an index into the description. Returns
        None if the sample has no texture."""
        described = self.layers()[layer][1]
        if sample in described["unseen"]:
            return None
        at = self.description["samples"][sample][1]
        for number, (begin, size, varying) in enumerate(described["blocks"]):
            if all(b <= a < b + s for a, b, s in zip(at, begin, size)):
                texture = 0
                for d in varying:
                    texture = texture * size[d] + at[d] - begin[d]
                return number, texture
        raise ValueError("a layer's blocks leave a sample out")


# Chunks.

class TextureChunk:
    """Holds `width`, `height` and `sizes` of the block. texture() returns the texture of a sample."""

    def __init__(self, data):
        reader = ByteReader(data)
        flags = reader.fixed("B")
        if flags > 5:
            raise ValueError("an unknown coder, or unknown flags")
        self.is_wavelet, self.is_linear, has_basis = flags & 1 != 0, flags & 2 != 0, flags & 4 != 0
        self.width, self.height = reader.number(), reader.number()
        dimensions, levels = reader.fixed("B"), reader.fixed("B")
        self.sizes = [reader.number() for _ in range(dimensions)]
        self.count = int(np.prod(self.sizes))
        halvings, basis, scales = [], [], []
        for _ in range(levels):
            if has_basis:
                basis.append(struct.unpack(f"{self.count}b", reader.bytes(self.count)))
            else:
                halvings.append(list(reader.bytes(dimensions)))
            scales.append(eighths(reader.fixed("B") - 64))
        self.side = 0 if self.is_wavelet else reader.fixed("B")
        self.rotation = rotation_rows([reader.fixed("h") for _ in range(4)])
        self.offsets = [reader.fixed("h") for _ in range(3)]
        classes = band_of(self.side)
        codes = reader.bytes(len(wavelet_bands(self.width, self.height)) if self.is_wavelet else 2 * classes)
        if self.is_wavelet:
            self.steps = [eighths(code) for code in codes]
        else:
            self.steps = np.array([eighths(codes[band_of(u)] + codes[classes + band_of(v)])
                                   for v in range(self.side) for u in range(self.side)], SINGLE)
        self.scales, self.levels, parents = [], [], []
        self.terms = [[] for _ in range(self.count)]  # a list of (image, weight) for each sample
        if has_basis:
            self.plan_basis(basis, parents)
        else:
            self.plan_pyramid(halvings, parents)
        self.scales = [scales[level] for level in self.levels]
        stream = (WaveletStream(self.width, self.height, data[reader.at:]) if self.is_wavelet else
                  CosineStream(self.width, self.height, self.side, data[reader.at:]))
        self.images = []
        for level, parent in zip(self.levels, parents):
            self.images.append(stream.image(None if parent is None else self.images[parent], level))

    def plan_basis(self, basis, parents):
        for image, weights in enumerate(basis):
            self.levels.append(image)
            parents.append(None if image == 0 else 0)
            for sample, weight in enumerate(weights):
                if weight:
                    self.terms[sample].append((image, SINGLE(weight) / SINGLE(127)))

    def plan_pyramid(self, halvings, parents):
        first = [0]
        for times in halvings:
            first.append(first[-1] + int(np.prod([self.cells(d, t) for d, t in enumerate(times)])))
        for level, times in enumerate(halvings):
            for number in range(first[level + 1] - first[level]):
                self.levels.append(level)
                if level == 0:
                    parents.append(None)
                    continue
                at = np.unravel_index(number, [self.cells(d, t) for d, t in enumerate(times)])
                inside = [int(i) << t for i, t in zip(at, times)]  # a sample that is in the cell of this image
                parents.append(first[level - 1] + self.image_at(halvings[level - 1], inside))
            for sample in range(self.count):
                at = [int(i) for i in np.unravel_index(sample, self.sizes)]
                terms = self.between(times, at) if self.is_linear else [(self.image_at(times, at), SINGLE(1))]
                self.terms[sample] += [(first[level] + image, weight) for image, weight in terms]

    def cells(self, dimension, times):
        return (self.sizes[dimension] - 1 >> times) + 1

    def image_at(self, times, at):
        number = 0
        for d, t in enumerate(times):
            number = number * self.cells(d, t) + (at[d] >> t)
        return number

    def between(self, times, at):
        """Returns the two images of a level whose cell centres enclose the sample."""
        terms = [(0, SINGLE(1))]
        for d, t in enumerate(times):
            count = self.cells(d, t)

            def middle(cell):
                return SINGLE((cell << t) + min(self.sizes[d], cell + 1 << t) - 1) / SINGLE(2)

            low = at[d] >> t
            if low > 0 and SINGLE(at[d]) < middle(low):
                low -= 1
            high, share = min(low + 1, count - 1), SINGLE(0)
            if high != low:
                share = (SINGLE(at[d]) - middle(low)) / (middle(high) - middle(low))
                share = min(max(share, SINGLE(0)), SINGLE(1))
            terms = [(image * count + cell, weight * part) for image, weight in terms
                     for cell, part in ((low, SINGLE(1) - share), (high, share)) if part > 0]
        return terms

    def texture(self, sample):
        """Returns [height][width][3], gamma-coded, with 255 for a radiance of 1."""
        colours = np.zeros((self.height, self.width, 3), SINGLE)
        for p in range(3):
            samples = np.full((self.height, self.width), SINGLE(self.offsets[p]) / SINGLE(64))
            for image, weight in self.terms[sample]:
                scale = weight * self.scales[image]
                if not self.is_wavelet:
                    samples += cosine_samples(self.images[image], p, self.width, self.height, self.side, self.steps,
                                              scale)
                elif self.images[image][p] is not None:
                    samples += wavelet_samples(self.images[image][p], self.width, self.height, self.steps, scale)
            for c in range(3):
                colours[:, :, c] += self.rotation[p][c] * samples
        return colours


def eighths(code):
    return SINGLE(2.0 ** (code / 8.0))


def rotation_rows(quaternion):
    length = np.sqrt(float(sum(part * part for part in quaternion)))
    w, x, y, z = (part / length for part in quaternion) if length > 0 else (1.0, 0.0, 0.0, 0.0)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]).astype(SINGLE)


def radiance(texture):
    return (np.maximum(texture.astype(np.float64), 0.0) / 255.0) ** 2.2


def box_weights(fine):
    """Returns the weights of fine texels in each coarse texel along an axis, as [floor(fine / 2)][fine]."""
    coarse = max(1, fine // 2)
    weights = np.zeros((coarse, fine))
    for i in range(coarse):
        begin, end = i * fine / coarse, (i + 1) * fine / coarse
        for k in range(fine):
            weights[i, k] = max(0.0, min(end, k + 1) - max(begin, k)) / (end - begin)
    return weights


def mip_levels(finest):
    """Returns [height][width][3] for every level of radiance, finest first."""
    levels = [finest]
    while levels[-1].shape[:2] != (1, 1):
        height, width = levels[-1].shape[:2]
        levels.append(np.einsum("ij,jkc,lk->ilc", box_weights(height), levels[-1], box_weights(width)))
    return levels


def write_chunks(field, out):
    chunks = []
    for section in field.sections:
        if section.kind == 1:
            chunk = field.chunk(section.layer, section.block)
            for sample in range(chunk.count):
                out.write(chunk.texture(sample).astype("<f4").tobytes())
            chunks.append([section.layer, section.block, chunk.width, chunk.height, chunk.count])
    print(json.dumps({"chunks": chunks}))


def write_field(field, out):
    chunks, textures = {}, {}
    for layer in range(len(field.layers())):
        for sample in range(len(field.description["samples"])):
            place = field.place_of(layer, sample)
            if place is None:
                continue
            block, texture = place
            if (layer, block) not in chunks:
                chunks[layer, block] = field.chunk(layer, block)
            if (layer, block, texture) not in textures:
                levels = mip_levels(radiance(chunks[layer, block].texture(texture)))
                textures[layer, block, texture] = b"".join(level.astype("<f4").tobytes() for level in levels)
            out.write(textures[layer, block, texture])


def main():
    *options, path, output = sys.argv[1:]
    with open(path, "rb") as file:
        field = PackedField(file.read())
    with open(output, "wb") as out:
        (write_field if options == ["--field"] else write_chunks)(field, out)


if __name__ == "__main__":
    main()
