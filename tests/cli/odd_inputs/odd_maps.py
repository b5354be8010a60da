# SPDX-License-Identifier: Apache-2.0
"""Makes the contents of the odd maps. Converts normals of surfaces and heights to numbers of any type, and back to
unit normals as docs/reference/input_maps.md says. Does not share any formula with the program."""
import math
import struct
from dataclasses import dataclass

from odd_images import Picture

HORIZON_Z = 1 / 512
FLAT = (0.0, 0.0, 1.0)


def unit(v):
    length = math.sqrt(sum(c * c for c in v))
    return tuple(c / length for c in v)


def heights(width, height, random):
    """Returns the heights (0 to 1) of a smooth periodic surface without symmetries."""
    modes = [(kx, ky, random.uniform(0.5, 1.0) / math.hypot(kx, ky), random.uniform(0, 2 * math.pi))
             for kx, ky in ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1))]
    rows = [[sum(a * math.cos(2 * math.pi * (kx * x / width + ky * y / height) + phase) for kx, ky, a, phase in modes)
             for x in range(width)] for y in range(height)]
    low, high = min(map(min, rows)), max(map(max, rows))
    return [(value - low) / (high - low) if high > low else 0.3 for row in rows for value in row]


def surface(width, height, random, steepness=0.4):
    """Returns the unit normals of such a surface with this rms slope and with +Y up. Single rows and texels get
    slightly tilted normals."""
    if min(width, height) < 3:
        tilts = [(random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25)) for _ in range(width * height)]
        return [unit((x, y, 1.0)) for x, y in tilts]
    modes = [(kx, ky, random.uniform(0.5, 1.0) / math.hypot(kx, ky), random.uniform(0, 2 * math.pi))
             for kx, ky in ((1, 0), (0, 1), (1, 1), (1, -1))]
    slopes = []
    for y in range(height):
        for x in range(width):
            sines = [(a * math.sin(2 * math.pi * (kx * x / width + ky * y / height) + phase), kx / width, ky / height)
                     for kx, ky, a, phase in modes]
            slopes.append((sum(s * u for s, u, _ in sines), -sum(s * v for s, _, v in sines)))
    rms = math.sqrt(sum(u * u + v * v for u, v in slopes) / len(slopes))
    return [unit((u * steepness / rms, v * steepness / rms, 1.0)) for u, v in slopes]


def rounded(value, kind, bits):
    """Converts a value of 0..1 or -1..1 to a file's number."""
    if kind == "float":
        return struct.unpack({16: "<e", 32: "<f", 64: "<d"}[bits], struct.pack({16: "<e", 32: "<f", 64: "<d"}[bits],
                                                                              value))[0]
    return math.floor(value * (2**(bits if kind == "uint" else bits - 1) - 1) + 0.5)


def picture_of(vectors, width, height, kind, bits, is_signed):
    """Converts vectors to numbers, 0..1 unless signed."""
    samples = [rounded(c if is_signed else c / 2 + 0.5, kind, bits) for v in vectors for c in v]
    return Picture(width, height, len(vectors[0]), kind, bits, samples)


def scalar_picture(values, width, height, kind, bits):
    return Picture(width, height, 1, kind, bits, [rounded(v, kind, bits) for v in values])


@dataclass
class Meaning:
    """Decodes numbers by docs/reference/input_maps.md."""
    height_scale: float = 0.0  # above 0: heights
    is_signed: bool = False
    is_two_channel: bool = False
    green: int = 1
    normal_scale: float = 1.0
    wrap: tuple = ("periodic", "periodic")  # of heights
    fixnan: str = "box3"


def is_number(v):
    return abs(v) <= 1e9  # false for NaN


def around(width, height, texel):
    x, y = texel % width, texel // width
    return [j * width + i for j in range(max(0, y - 1), min(height, y + 2))
            for i in range(max(0, x - 1), min(width, x + 2)) if (i, j) != (x, y)]


def above_horizon(v):
    v = unit(v)
    if v[2] >= HORIZON_Z:
        return v
    side = math.hypot(v[0], v[1])
    if side == 0.0:
        return FLAT
    return tuple(c / side * math.sqrt(1 - HORIZON_Z**2) for c in v[:2]) + (HORIZON_Z,)


def normals_of(picture, meaning):
    """Returns the map's normals, [texel] of (x, y, z)."""
    return heights_to_normals(picture, meaning) if meaning.height_scale else vectors_to_normals(picture, meaning)


def vectors_to_normals(picture, meaning):
    is_8_bit = (picture.kind, picture.bits <= 8) == ("uint", True)
    shortest = 1e-6
    if picture.kind == "uint":
        shortest = {8: 0.007, 16: 0.007 / 257}.get(8 if is_8_bit else picture.bits, 1e-6)
    normals, holes = [], []
    for i, texel in enumerate(picture.texels()):
        texel = (texel + [0.0])[:3]
        normals.append(FLAT)
        if not all(map(is_number, texel)):
            holes.append((i, meaning.fixnan == "box3"))
            continue
        if not meaning.is_signed and all(0.0 <= c <= 4.5 / 255 for c in texel):
            holes.append((i, False))  # never written
            continue
        x, y, z = texel if meaning.is_signed else (2 * c - 1 for c in texel)
        if is_8_bit and max(abs(x), abs(y)) < 1.01 / 255:
            x = y = 0.0
        if meaning.is_two_channel:
            z = math.sqrt(max(0.0, 1 - x * x - y * y))
        if math.sqrt(x * x + y * y + z * z) < shortest:
            holes.append((i, True))
            continue
        normals[i] = above_horizon((x * meaning.normal_scale, meaning.green * y * meaning.normal_scale, z))
    bad = {i for i, _ in holes}
    mended = list(normals)
    for i, takes_mean in holes:
        good = [normals[j] for j in around(picture.width, picture.height, i) if j not in bad]
        if takes_mean and good:
            mended[i] = above_horizon(tuple(sum(v[c] for v in good) for c in range(3)))
    return mended


def heights_to_normals(picture, meaning):
    width, height = picture.width, picture.height
    found = [sum(texel) / len(texel) for texel in picture.texels()]
    values = list(found)
    for i, v in enumerate(found):
        if not math.isfinite(v):
            near = [found[j] for j in around(width, height, i) if math.isfinite(found[j])]
            values[i] = sum(near) / len(near) if near and meaning.fixnan == "box3" else 0.0

    def beyond(place, size, mode):
        """Returns the position of a neighbour. Returns None beyond the end of the surface (clamp, mirror), and "black"
        where the value is 0."""
        if 0 <= place < size:
            return place
        return {"periodic": place % size, "black": "black"}.get(mode)

    def slope(i, place, size, mode, step):
        """Returns the slope from the two neighbours along one direction, or from the only one that exists."""
        def height(other):
            found = beyond(other, size, mode)
            if found is None:
                return None
            return 0.0 if found == "black" else values[i + (found - place) * step]

        before, after = height(place - 1), height(place + 1)
        if before is not None and after is not None:
            return (after - before) / 2
        if after is not None:
            return after - values[i]
        return values[i] - before if before is not None else 0.0

    scale = meaning.height_scale
    return [above_horizon((-scale * slope(y * width + x, x, width, meaning.wrap[0], 1),
                           scale * slope(y * width + x, y, height, meaning.wrap[1], width), 1.0))
            for y in range(height) for x in range(width)]


def linear_from_srgb(v):
    return v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055)**2.4


def colours_of(picture, transfer):
    """Returns the linear (r, g, b) of each texel. Values that are not a reflectance become 0."""
    def linear(v):
        return transfer(v) if math.isfinite(v) and v >= 0.0 else 0.0

    return [tuple(linear(c) for c in (texel * 3)[:3]) if len(texel) == 1 else tuple(map(linear, texel))
            for texel in picture.texels()]


def mean_cosine(roughness):
    """Computes how much the roughness of a texel shortens its normal (docs/reference/file_format.md, "Roughness and
    weights")."""
    return 1.0 - roughness**4 / 2
