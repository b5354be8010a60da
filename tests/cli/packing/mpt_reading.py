# SPDX-License-Identifier: Apache-2.0
"""Reads packed fields, NAME.mpt, by docs/FORMAT.md, "Packed fields", alone: Python and numpy.

Used as a program it writes 32-bit floats one after another:
    mpt_reading.py FILE OUTPUT           of every chunk, in the index's order, the texture of every sample, gamma-coded,
                                         [height][width][3]; a line of JSON says which chunks
    mpt_reading.py --field FILE OUTPUT   of every layer and every sample of the description that has a texture of it
                                         radiance with all mip levels, the finest first
"""
import json
import struct
import sys
import zlib

import numpy as np

SINGLE = np.float32


class ByteReader:
    """Numbers from bytes; refuses to read beyond them."""

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
    """`sections`; `description`; `chunk()` decodes one."""

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
        """(object, layer) of the description, as sections number them."""
        return [(item, layer) for item in self.description["objects"] for layer in item["layers"]]

    def chunk(self, layer, block):
        """None where there is none: no sample of the block has a texture."""
        for section in self.sections:
            if (section.kind, section.layer, section.block) == (1, layer, block):
                return TextureChunk(self.bytes_of(section))
        return None

    def place_of(self, layer, sample):
        """(block, texture of its chunk) of a sample, an index into the description's; None where it has no texture."""
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


# The range coder, contexts and their mixing: integers alone.

LOGISTIC = [22, 28, 36, 47, 60, 77, 98, 126, 162, 208, 267, 342, 439, 562, 720, 922, 1179, 1506, 1921, 2446, 3108, 3938,
            4971, 6249, 7812, 9702, 11955, 14595, 17625, 21025, 24743, 28693, 32768, 36843, 40793, 44511, 47911, 50941,
            53581, 55834, 57724, 59287, 60565, 61598, 62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974, 65097,
            65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514]


def squash(odds):
    i, part = divmod(min(max(odds, -2048), 2047) + 2048, 64)
    return LOGISTIC[i] + (LOGISTIC[i + 1] - LOGISTIC[i]) * part // 64


def stretch_table():
    table, odds = [], -2048
    for i in range(4096):
        while odds < 2047 and squash(odds) < i * 16 + 8:
            odds += 1
        table.append(odds)
    return table


STRETCH = stretch_table()


def quotient(a, b):
    """Towards zero, b > 0."""
    return a // b if a >= 0 else -(-a // b)


class SymbolDecoder:
    """Contexts and mixers are made when they are first named."""

    def __init__(self, data):
        self.data, self.next, self.range, self.code = data, 0, 0xffffffff, 0
        self.contexts, self.mixers = {}, {}
        for _ in range(4):
            self.take_byte()

    def take_byte(self):
        byte = self.data[self.next] if self.next < len(self.data) else 0
        self.next += 1
        self.code = (self.code << 8 | byte) & 0xffffffff

    def symbol(self, probability):
        bound = (self.range >> 16) * probability
        bit = self.code < bound
        if bit:
            self.range = bound
        else:
            self.code -= bound
            self.range -= bound
        while self.range < 1 << 24:
            self.range <<= 8
            self.take_byte()
        return 1 if bit else 0

    def context(self, name):
        return self.contexts.setdefault(name, [32768, 32768, 0])

    @staticmethod
    def probability(context):
        return min(max((context[0] + context[1]) // 2, 32), 65504)

    @staticmethod
    def learn(context, bit):
        target = 65535 if bit else 0
        context[0] += quotient((target - context[0]) * 2, 2 * min(context[2], 20) + 3)
        context[1] += quotient((target - context[1]) * 2, 2 * min(context[2], 160) + 3)
        context[2] = min(context[2] + 1, 160)

    def bit(self, name):
        context = self.context(name)
        bit = self.symbol(self.probability(context))
        self.learn(context, bit)
        return bit

    def mixed(self, names, mixer):
        contexts = [self.context(name) for name in names]
        odds = [STRETCH[self.probability(context) // 16] for context in contexts]
        weights = self.mixers.setdefault(mixer, [26000] * 4)
        total = quotient(sum(w * x for w, x in zip(weights, odds)), 65536)
        probability = squash(total)
        bit = self.symbol(probability)
        error = (65535 if bit else 0) - probability
        for i, x in enumerate(odds):
            weights[i] = min(max(weights[i] + quotient(error * x, 1 << 15), -(1 << 15)), 1 << 19)
        for context in contexts:
            self.learn(context, bit)
        return bit

    def number(self, name):
        length = 0
        while length < 16 and self.bit((*name, length)):
            length += 1
        value = 1
        for _ in range(length):
            value = value << 1 | self.symbol(32768)
        return value - 1


# Cosines.

def band_of(index):
    return int(index).bit_length()


class CosineStream:
    def __init__(self, width, height, side, data):
        self.coder, self.side = SymbolDecoder(data), side
        self.columns, self.rows = -(-width // side), -(-height // side)
        self.bands = [[] for _ in range(band_of(side))]
        for v in range(side):
            for u in range(side):
                self.bands[band_of(max(u, v))].append(v * side + u)
        for band in self.bands:
            band.sort(key=lambda at: at // side + at % side)  # stable
        self.group_columns = -(-self.columns // 4)
        self.groups = [[] for _ in range(self.group_columns * -(-self.rows // 4))]
        for number in range(self.columns * self.rows):
            row, column = divmod(number, self.columns)
            self.groups[row // 4 * self.group_columns + column // 4].append(number)
        self.before = None  # the image decoded last

    def image(self, parent, level):
        """[plane]{block number: values}; blocks of zeros are left out."""
        planes = [{}, {}, {}]
        for p, blocks in enumerate(planes):
            if self.coder.bit(("plane",)):
                continue
            for group, numbers in enumerate(self.groups):
                has_any, any_yet = self.group(planes, parent, p, level, group), False
                for number in numbers:
                    left = blocks.get(number - 1) if number % self.columns else None
                    up = blocks.get(number - self.columns)
                    luma = planes[0].get(number) if p else None
                    around = (left, up, parent[p].get(number) if parent else None, luma)
                    values = None
                    if has_any:
                        is_only = not any_yet and number == numbers[-1]
                        values = self.block(around, parent is not None, p, level, is_only)
                    any_yet = any_yet or values is not None
                    values = values or [0] * self.side**2
                    if parent is None:
                        values[0] = min(max(values[0] + self.constant(blocks, number), -32767), 32767)
                    if any(values):
                        blocks[number] = values
        self.before = planes
        return planes

    def group(self, planes, parent, plane, level, group):
        def has(blocks, group):
            return any(number in blocks for number in self.groups[group])

        chroma, level, columns = min(plane, 1), min(level, 3), self.group_columns
        beside = (group % columns > 0 and has(planes[plane], group - 1)) + (
            group >= columns and has(planes[plane], group - columns))
        above = 2 if parent is None else int(has(parent[plane], group))
        before = int(self.before is not None and has(self.before[plane], group))
        luma = int(plane > 0 and has(planes[0], group))
        return self.coder.mixed([("group a", chroma, beside, above, before), ("group b", plane, level, luma),
                                 ("group c", chroma, level, beside)], ("group", chroma))

    def constant(self, blocks, number):
        def first(n):
            return blocks[n][0] if n in blocks else 0

        has_left, has_up = number % self.columns > 0, number >= self.columns
        if has_left and has_up:
            return quotient(first(number - 1) + first(number - self.columns), 2)
        return first(number - 1) if has_left else first(number - self.columns) if has_up else 0

    def has(self, values, band):
        return values is not None and any(values[at] for at in self.bands[band])

    def block(self, around, has_parent, plane, level, is_only):
        """None where it has nothing."""
        left, up, parent, luma = around
        chroma, level = min(plane, 1), min(level, 3)
        above = 2 if not has_parent else 0 if parent is None else 1
        beside = (left is not None) + (up is not None)
        values = [0] * self.side**2
        if not is_only and not self.coder.mixed([("coded a", chroma, beside, above),
                                                 ("coded b", plane, level, 0 if luma is None else 1),
                                                 ("coded c", chroma, level, beside)], ("coded", chroma)):
            return None
        had, before = 0, 0  # in the band before, in any before
        for k in range(len(self.bands)):
            has = 1
            if k + 1 < len(self.bands) or before:
                sides = self.has(left, k) + self.has(up, k)
                above = 2 if not has_parent else int(self.has(parent, k))
                previous = 0 if k == 0 else 2 if had else 1 if before else 0
                has = self.coder.mixed([("band a", chroma, k, previous, above), ("band b", chroma, k, sides, previous),
                                        ("band c", plane, k, int(self.has(luma, k)), level)], ("band", chroma, k))
            if has:
                self.band(values, around, chroma, level, k)
            had, before = has, before or has
        return values

    def band(self, values, around, chroma, level, k):
        side, found = self.side, 0

        def size(block, at):
            return 0 if block is None else abs(block[at])

        for at in self.bands[k]:
            u, v = at % side, at // side
            left, up, parent, luma = (size(block, at) for block in around)
            parent, luma, sides = min(parent, 2), min(luma, 2), min(left + up, 3)
            lower = ((2 * abs(values[at - 1]) if u > 0 else 0) + (2 * abs(values[at - side]) if v > 0 else 0) +
                     (abs(values[at - side - 1]) if u > 0 and v > 0 else 0) +
                     (abs(values[at - 2]) if u > 1 else 0) + (abs(values[at - 2 * side]) if v > 1 else 0))
            if found or at != self.bands[k][-1]:
                if not self.coder.mixed([("significant a", chroma, band_of(u) * 6 + band_of(v), parent),
                                         ("significant b", chroma, k, min(lower, 7), luma),
                                         ("significant c", chroma, k, sides, min(found, 3)),
                                         ("significant d", chroma, level, min(u + v, 31))], ("significant", chroma, k)):
                    continue
            found += 1
            magnitude = self.magnitude(chroma, k, min(lower // 2, 5), min(parent + sides, 4))
            values[at] = -magnitude if self.negative(chroma, around, at) else magnitude

    def magnitude(self, chroma, k, near, beside):
        for coded in range(1, 14):
            if not self.coder.mixed([("larger a", chroma, k, min(coded - 1, 3)), ("larger b", near, coded - 1),
                                     ("larger c", beside, coded - 1)], ("larger",)):
                return coded
        return min(14 + self.coder.number(("escape",)), 32767)

    def negative(self, chroma, around, at):
        if at:
            return self.coder.symbol(32768)
        left, up = (0 if block is None or block[0] == 0 else 1 if block[0] > 0 else 2 for block in around[:2])
        return self.coder.bit(("sign", chroma, left, up))


def cosine_rows(n):
    k, i = np.arange(n)[:, None], np.arange(n)[None, :]
    return (np.sqrt(np.where(k == 0, 1.0, 2.0) / n) * np.cos(np.pi * ((2 * i + 1) * k) / (2 * n))).astype(SINGLE)


def cosine_samples(image, plane, width, height, side, steps, scale):
    columns, rows = -(-width // side), -(-height // side)
    cosines, out = cosine_rows(side), np.zeros((rows * side, columns * side), SINGLE)
    for number, values in image[plane].items():
        coefficients = (SINGLE(scale) * steps * np.array(values, SINGLE)).reshape(side, side)
        half, block = np.zeros((side, side), SINGLE), np.zeros((side, side), SINGLE)
        for u in range(side):
            half += coefficients[:, u:u + 1] * cosines[u]
        for v in range(side):
            block += cosines[v][:, None] * half[v]
        y, x = number // columns * side, number % columns * side
        out[y:y + side, x:x + side] = block
    return out[:height, :width]


# Wavelets.

def halved(size, times):
    for _ in range(times):
        size = (size + 1) // 2
    return size


def wavelet_depth(width, height):
    depth, side = 0, min(width, height)
    while side >= 8 and depth < 6:
        depth, side = depth + 1, (side + 1) // 2
    return depth


def wavelet_bands(width, height):
    """(x, y, width, height, depth, kind)"""
    depth = wavelet_depth(width, height)
    bands = [(0, 0, halved(width, depth), halved(height, depth), max(depth, 1), 0)]
    for d in range(depth, 0, -1):
        all_x, all_y, low_x, low_y = halved(width, d - 1), halved(height, d - 1), halved(width, d), halved(height, d)
        for kind in (1, 2, 3):
            high_x, high_y = kind != 2, kind >= 2
            band = (low_x if high_x else 0, low_y if high_y else 0, all_x - low_x if high_x else low_x,
                    all_y - low_y if high_y else low_y, d, kind)
            if band[2] > 0 and band[3] > 0:
                bands.append(band)
    return bands


class WaveletPlane:
    """Integers of a plane, and trees[band]: levels of nodes, the finest first."""

    def __init__(self, width, height, bands):
        self.width, self.trees = width, []
        self.magnitudes, self.negative, self.known = [0] * (width * height), [0] * (width * height), {}
        for _, _, w, h, _, _ in bands:
            levels = [[[0] * w for _ in range(h)]]
            while w > 1 or h > 1:
                w, h = (w + 1) // 2, (h + 1) // 2
                levels.append([[0] * w for _ in range(h)])
            self.trees.append(levels)

    def significant(self, tree, level, x, y):
        levels = self.trees[tree]
        nodes = levels[min(level, len(levels) - 1)]
        return nodes[y][x] if 0 <= y < len(nodes) and 0 <= x < len(nodes[0]) else 0


class WaveletStream:
    def __init__(self, width, height, data):
        self.coder, self.width, self.height = SymbolDecoder(data), width, height
        self.bands = wavelet_bands(width, height)
        places = {(depth, kind): t for t, (_, _, _, _, depth, kind) in enumerate(self.bands)}
        self.coarser = [places.get((depth + 1, kind)) for _, _, _, _, depth, kind in self.bands]

    def image(self, parent, _level):
        """[plane], None without coefficients."""
        planes = [None, None, None]
        for p in range(3):
            bit_planes = min(self.coder.number(("bit planes", min(p, 1))), 20)
            if bit_planes == 0:
                continue
            plane = planes[p] = WaveletPlane(self.width, self.height, self.bands)
            around = (parent[p] if parent else None, planes[0] if p else None, parent is not None, min(p, 1))
            for bit in range(bit_planes - 1, -1, -1):
                for t, tree in enumerate(plane.trees):
                    self.find(plane, around, t, bit, min(bit_planes - 1 - bit, 5), len(tree) - 1, 0, 0, False, 0)
                self.refine(plane, around[3], bit)
        return planes

    def find(self, plane, around, t, bit, order, level, x, y, certain, found):
        nodes = plane.trees[t][level]
        is_new = not nodes[y][x]
        if is_new:
            if not certain and not self.significance(plane, around, t, order, level, x, y, found):
                return
            nodes[y][x] = 1
        if level == 0:
            if is_new:
                self.sign(plane, t, bit, x, y)
            return
        below, found_below = plane.trees[t][level - 1], 0
        children = [(cx, cy) for cy in range(2 * y, min(2 * y + 2, len(below)))
                    for cx in range(2 * x, min(2 * x + 2, len(below[0])))]
        for i, (cx, cy) in enumerate(children):
            last = is_new and i + 1 == len(children) and found_below == 0
            self.find(plane, around, t, bit, order, level - 1, cx, cy, last, found_below)
            found_below += below[cy][cx]

    def significance(self, plane, around, t, order, level, x, y, found):
        parent, luma, has_parent, chroma = around
        _, _, _, _, depth, kind = self.bands[t]

        def at(nx, ny):
            return plane.significant(t, level, nx, ny)

        def there(other):
            return 0 if other is None else other.significant(t, level, x, y)

        row, column = at(x - 1, y) + at(x + 1, y), at(x, y - 1) + at(x, y + 1)
        corners = at(x - 1, y - 1) + at(x + 1, y - 1) + at(x - 1, y + 1) + at(x + 1, y + 1)
        along, across = (column, row) if kind == 1 else (row, column)
        coarser, above = 0, self.coarser[t]
        if above is not None:
            coarser = (plane.significant(above, 0, x // 2, y // 2) if level == 0 else
                       plane.significant(above, level - 1, x, y))
        parent = there(parent) if has_parent else 2
        height = min(level, 4)
        return self.coder.mixed([("near", chroma, height, {3: 1, 0: 2}.get(kind, 0), along, across),
                                 ("other", chroma, height, coarser, parent, there(luma), min(row + column, 2)),
                                 ("place", chroma, depth, kind, height, order),
                                 ("corner", chroma, height, corners, found)], ("find", chroma, height))

    def sign(self, plane, t, bit, x, y):
        band = self.bands[t]
        at = (band[1] + y) * plane.width + band[0] + x

        def sign_at(is_there, place):
            return 0 if not is_there or not plane.magnitudes[place] else 2 if plane.negative[place] else 1

        if band[5] == 0:
            plane.negative[at] = self.coder.bit(("sign", sign_at(x > 0, at - 1), sign_at(y > 0, at - plane.width)))
        else:
            plane.negative[at] = self.coder.symbol(32768)
        plane.magnitudes[at], plane.known[at] = 1 << bit, bit

    def refine(self, plane, chroma, bit):
        for at in sorted(plane.known):
            if plane.known[at] != bit:
                length = plane.magnitudes[at].bit_length() - bit - 1
                plane.magnitudes[at] |= self.coder.bit(("refine", chroma, min(length, 4))) << bit
                plane.known[at] = bit


LIFTING = [SINGLE(factor) for factor in (-1.586134342, -0.05298011854, 0.8829110762, 0.4435068522)]
LOW_GAIN = SINGLE(1.149604398)


def inverse_lines(coefficients):
    """Along axis 0: the low half, then the high one."""
    n = len(coefficients)
    if n < 2:
        return coefficients
    low, line = (n + 1) // 2, np.empty_like(coefficients)
    line[0::2], line[1::2] = coefficients[:low] / LOW_GAIN, coefficients[low:] * LOW_GAIN
    for step in (3, 2, 1, 0):
        i = np.arange(1 if step % 2 == 0 else 0, n, 2)
        before, after = line[np.where(i > 0, i - 1, 1)], line[np.where(i + 1 < n, i + 1, n - 2)]
        line[i] += -LIFTING[step] * (before + after)
    return line


def wavelet_samples(plane, width, height, steps, scale):
    samples = np.zeros((height, width), SINGLE)
    for (x, y, w, h, _, _), step in zip(wavelet_bands(width, height), steps):
        factor = SINGLE(scale) * step
        for at, known in plane.known.items():
            cy, cx = divmod(at, width)
            if x <= cx < x + w and y <= cy < y + h:
                magnitude = SINGLE(plane.magnitudes[at]) + SINGLE(0.4) * SINGLE(1 << known)
                samples[cy, cx] = factor * (-magnitude if plane.negative[at] else magnitude)
    for d in range(wavelet_depth(width, height) - 1, -1, -1):
        w, h = halved(width, d), halved(height, d)
        samples[:h, :w] = inverse_lines(samples[:h, :w])
        samples[:h, :w] = inverse_lines(samples[:h, :w].T).T
    return samples


# Chunks.

class TextureChunk:
    """`width`, `height`, `sizes` of the block; texture() of each sample."""

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
        self.terms = [[] for _ in range(self.count)]  # (image, weight) of each sample
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
                inside = [int(i) << t for i, t in zip(at, times)]  # a sample of the image's cell
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
        """The images of a level between whose cells' middles a sample lies."""
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
        """[height][width][3], gamma-coded, 255 for a radiance of 1."""
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
    """[floor(fine / 2)][fine]: what each coarse texel takes of the fine ones along an axis."""
    coarse = max(1, fine // 2)
    weights = np.zeros((coarse, fine))
    for i in range(coarse):
        begin, end = i * fine / coarse, (i + 1) * fine / coarse
        for k in range(fine):
            weights[i, k] = max(0.0, min(end, k + 1) - max(begin, k)) / (end - begin)
    return weights


def mip_levels(finest):
    """[height][width][3] of every level of radiance, the finest first."""
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
