# SPDX-License-Identifier: Apache-2.0
"""Contains pictures as numbers, and code for PNG (W3C PNG): a writer for every colour type, depth, filter and
interlacing, and a separate decoder. Writer and decoder share only the tables of the standard."""
import struct
import zlib
from dataclasses import dataclass, field


@dataclass
class Picture:
    """Holds numbers as in a file: interleaved, with rows from the top."""
    width: int
    height: int
    channels: int
    kind: str  # "uint", "int" or "float"
    bits: int
    samples: list = field(repr=False)
    colours: int = 0  # the number of leading channels that are not alpha; 0 means all channels

    def values(self):
        """Returns unsigned integers as 0..1, signed ones as -1..1, and floats unchanged."""
        if self.kind == "float":
            return list(self.samples)
        largest = 2**(self.bits if self.kind == "uint" else self.bits - 1) - 1
        return [sample / largest for sample in self.samples]

    def texels(self, count=None):
        """Returns [texel][channel] of the first `count` channels; by default, of all channels except alpha."""
        values, n = self.values(), self.channels
        count = count or self.colours or n
        return [values[i:i + count] for i in range(0, len(values), n)]


def pack_bits(samples, bits):
    """Packs one row, with the first sample in the highest bits. Samples of 16 and more bits are big-endian."""
    number = 0
    for sample in samples:
        number = number << bits | sample
    missing = -len(samples) * bits % 8
    return (number << missing).to_bytes((len(samples) * bits + missing) // 8, "big")


def unpack_bits(data, bits, count):
    number = int.from_bytes(data, "big") >> (len(data) * 8 - bits * count)
    return [number >> bits * (count - 1 - i) & (1 << bits) - 1 for i in range(count)]


SIGNATURE = b"\x89PNG\r\n\x1a\n"
PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}


def png_chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def paeth(a, b, c):
    """Returns the Paeth predictor (W3C PNG, 9.4): the neighbour that is closest to a + b - c. If there is a tie, left
    is preferred to above, and above to upper left."""
    p = a + b - c
    return min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]


def predicted(kind, row, above, i, step):
    left, up = (row[i - step] if i >= step else 0), above[i]
    return (0, left, up, (left + up) // 2, paeth(left, up, above[i - step] if i >= step else 0))[kind]


def filtered_rows(rows, step, random):
    above, out = bytes(len(rows[0])), b""
    for row in rows:
        kind = random.randrange(5)
        out += bytes([kind]) + bytes(row[i] - predicted(kind, row, above, i, step) & 255 for i in range(len(row)))
        above = row
    return out


def passes_of(width, height, is_interlaced):
    """Yields the columns and rows of each pass."""
    passes = PASSES if is_interlaced else ((0, 0, 1, 1),)
    for x, y, dx, dy in passes:
        columns, rows = range(x, width, dx), range(y, height, dy)
        if columns and rows:
            yield columns, rows


def write_png(width, height, colour_type, depth, samples, random, palette=None, transparent=None, chunks=(),
              interlace=False):
    """`samples` are interleaved codes, or indices for palettes. `chunks` are pairs (kind, body), which are written
    between the header and the palette."""
    n = CHANNELS[colour_type]
    data = b""
    for columns, rows in passes_of(width, height, interlace):
        lines = [pack_bits([samples[(y * width + x) * n + c] for x in columns for c in range(n)], depth) for y in rows]
        data += filtered_rows(lines, max(1, n * depth // 8), random)
    png = SIGNATURE + png_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour_type, 0, 0, interlace))
    png += b"".join(png_chunk(*chunk) for chunk in chunks)
    if palette is not None:
        png += png_chunk(b"PLTE", bytes(code for entry in palette for code in entry))
    if transparent is not None:
        png += png_chunk(b"tRNS", transparent)
    packed = zlib.compress(data)
    cut = random.randrange(1, len(packed))  # the data may be split into several chunks
    return png + png_chunk(b"IDAT", packed[:cut]) + png_chunk(b"IDAT", packed[cut:]) + png_chunk(b"IEND", b"")


def read_png(data):
    """Returns the picture with palettes looked up. tRNS transparency is ignored; an alpha channel is kept."""
    assert data[:8] == SIGNATURE
    position, chunks = 8, {}
    while position < len(data):
        length, kind = struct.unpack_from(">I4s", data, position)
        chunks[kind] = chunks.get(kind, b"") + data[position + 8:position + 8 + length]
        position += 12 + length
    width, height, depth, colour_type, _, _, interlace = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    n = CHANNELS[colour_type]
    step, raw, position = max(1, n * depth // 8), zlib.decompress(chunks[b"IDAT"]), 0
    samples = [0] * (width * height * n)
    for columns, rows in passes_of(width, height, interlace):
        length = (len(columns) * n * depth + 7) // 8
        above = bytes(length)
        for y in rows:
            kind, row = raw[position], bytearray(raw[position + 1:position + 1 + length])
            position += 1 + length
            for i in range(length):
                row[i] = row[i] + predicted(kind, row, above, i, step) & 255
            codes = unpack_bits(bytes(row), depth, len(columns) * n)
            for i, x in enumerate(columns):
                samples[(y * width + x) * n:(y * width + x + 1) * n] = codes[i * n:(i + 1) * n]
            above = row
    if colour_type == 3:
        table = chunks[b"PLTE"]
        samples, n, depth = [code for i in samples for code in table[3 * i:3 * i + 3]], 3, 8
    return Picture(width, height, n, "uint", depth, samples, n - (colour_type in (4, 6)))
