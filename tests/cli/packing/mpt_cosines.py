# SPDX-License-Identifier: Apache-2.0
"""Decodes images of cosines by docs/reference/packed_fields.md, "The stream of cosines"."""
import numpy as np

from mpt_symbols import SymbolDecoder, quotient

SINGLE = np.float32


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
            band.sort(key=lambda at: at // side + at % side)  # a stable sort
        self.group_columns = -(-self.columns // 4)
        self.groups = [[] for _ in range(self.group_columns * -(-self.rows // 4))]
        for number in range(self.columns * self.rows):
            row, column = divmod(number, self.columns)
            self.groups[row // 4 * self.group_columns + column // 4].append(number)
        self.before = None  # the most recently decoded image

    def image(self, parent, level):
        """Returns [plane]{block number: values}. Blocks of zeros are left out."""
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
        """Returns None if the stream is empty."""
        left, up, parent, luma = around
        chroma, level = min(plane, 1), min(level, 3)
        above = 2 if not has_parent else 0 if parent is None else 1
        beside = (left is not None) + (up is not None)
        values = [0] * self.side**2
        if not is_only and not self.coder.mixed([("coded a", chroma, beside, above),
                                                 ("coded b", plane, level, 0 if luma is None else 1),
                                                 ("coded c", chroma, level, beside)], ("coded", chroma)):
            return None
        had, before = 0, 0  # the counts in the previous band and in all earlier bands
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
