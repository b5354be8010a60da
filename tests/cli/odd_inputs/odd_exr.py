# SPDX-License-Identifier: Apache-2.0
"""Writes OpenEXR files with unusual windows, channels, parts, line orders and tiles, which are uncompressed or
compressed with RLE, ZIPS or ZIP. exr_reading reads them again."""
import struct
import zlib
from dataclasses import dataclass, field

LETTERS = {"uint": (0, "I"), "half": (1, "e"), "float": (2, "f")}
LINES = {0: 1, 1: 1, 2: 1, 3: 16}


@dataclass
class ExrPart:
    width: int
    height: int
    channels: dict  # maps each name to its type and to its values, row by row
    origin: tuple = (0, 0)
    display: tuple = ()  # left, top, right, bottom; empty for the data window
    compression: int = 0
    decreasing: bool = False
    tile: int = 0
    more: list = field(default_factory=list)  # the name, type and bytes of each additional attribute


def run_lengths(data):
    out, i = b"", 0
    while i < len(data):
        run = 1
        while i + run < len(data) and run < 128 and data[i + run] == data[i]:
            run += 1
        if run >= 3:
            out += struct.pack("b", run - 1) + data[i:i + 1]
            i += run
            continue
        end = i + 1
        while end < len(data) and end - i < 127 and not data[end] == data[end - 1] == data[end - 2]:
            end += 1
        out += struct.pack("b", i - end) + data[i:end]
        i = end
    return out


def compressed(data, compression):
    if compression == 0:
        return data
    split = data[0::2] + data[1::2]
    differences = split[:1] + bytes(split[i] - split[i - 1] + 128 & 255 for i in range(1, len(split)))
    shorter = run_lengths(differences) if compression == 1 else zlib.compress(differences)
    return shorter if len(shorter) < len(data) else data


def attribute(name, kind, data):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data


def block(part, left, top, width, height):
    out = b""
    for y in range(top, top + height):
        for _, (kind, values) in sorted(part.channels.items()):
            begin = y * part.width + left
            out += struct.pack(f"<{width}{LETTERS[kind][1]}", *values[begin:begin + width])
    return compressed(out, part.compression)


def chunks_of(part):
    if part.tile:
        side = part.tile
        for row in range(-(-part.height // side)):
            for column in range(-(-part.width // side)):
                data = block(part, column * side, row * side, min(side, part.width - column * side),
                             min(side, part.height - row * side))
                yield struct.pack("<5i", column, row, 0, 0, len(data)) + data
        return
    lines = LINES[part.compression]
    for top in range(0, part.height, lines):
        data = block(part, 0, top, part.width, min(lines, part.height - top))
        yield struct.pack("<ii", part.origin[1] + top, len(data)) + data


def header_of(part, name, chunk_count):
    x, y = part.origin
    window = (x, y, x + part.width - 1, y + part.height - 1)
    listed = b"".join(channel.encode() + b"\0" + struct.pack("<iBxxxii", LETTERS[kind][0], 0, 1, 1)
                      for channel, (kind, _) in sorted(part.channels.items())) + b"\0"
    header = [("channels", "chlist", listed), ("compression", "compression", bytes([part.compression])),
              ("dataWindow", "box2i", struct.pack("<4i", *window)),
              ("displayWindow", "box2i", struct.pack("<4i", *(part.display or window))),
              ("lineOrder", "lineOrder", bytes([part.decreasing])),
              ("pixelAspectRatio", "float", struct.pack("<f", 1)), ("screenWindowCenter", "v2f", bytes(8)),
              ("screenWindowWidth", "float", struct.pack("<f", 1)), *part.more]
    if part.tile:
        header.append(("tiles", "tiledesc", struct.pack("<IIB", part.tile, part.tile, 0)))
    if name:
        header += [("name", "string", name.encode()), ("chunkCount", "int", struct.pack("<i", chunk_count)),
                   ("type", "string", b"tiledimage" if part.tile else b"scanlineimage")]
    return b"".join(attribute(*one) for one in sorted(header)) + b"\0"


def write_exr(parts):
    """Writes one part as a plain file, and several parts as a multi-part file."""
    is_multi = len(parts) > 1
    chunks = [list(chunks_of(part)) for part in parts]
    version = 2 | (0x1000 if is_multi else 0x200 if parts[0].tile else 0)
    out = struct.pack("<II", 20000630, version)
    for i, part in enumerate(parts):
        out += header_of(part, f"part{i}" if is_multi else "", len(chunks[i]))
    out += b"\0" * is_multi
    at, table, body = len(out) + 8 * sum(map(len, chunks)), b"", b""
    for i, part in enumerate(parts):
        offsets = {}
        order = reversed(range(len(chunks[i]))) if part.decreasing else range(len(chunks[i]))
        for k in order:  # The chunks are in file order; the offset table is in the order of the rows.
            offsets[k] = at + len(body)
            body += (struct.pack("<i", i) if is_multi else b"") + chunks[i][k]
        table += b"".join(struct.pack("<Q", offsets[k]) for k in sorted(offsets))
    return out + table + body
