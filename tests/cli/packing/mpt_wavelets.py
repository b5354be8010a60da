# SPDX-License-Identifier: Apache-2.0
"""Decodes images of wavelets by docs/reference/packed_fields.md, "The stream of wavelets"."""
import numpy as np

from mpt_symbols import SymbolDecoder

SINGLE = np.float32


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
    """Returns (x, y, width, height, depth, kind) for each band."""
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
    """Holds the integers of a plane, and for each band trees[band], which are the levels of nodes with the finest
    level first."""

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
        """Returns one item per plane. The item is None if the plane has no coefficients."""
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
    """Inverts the transform along axis 0, where the low half comes first and then the high half."""
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
