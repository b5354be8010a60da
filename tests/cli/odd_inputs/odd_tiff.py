# SPDX-License-Identifier: Apache-2.0
"""Contains a writer and a separate decoder for TIFF of every layout (TIFF 6.0, BigTIFF, and Adobe's TIFF Technical
Note 3 for predictor 3). LZW is the only compression that both implement with their own code."""
import struct
import zlib
from dataclasses import dataclass, field

from odd_images import Picture, pack_bits, unpack_bits

NONE, LZW, DEFLATE, PACKBITS, OLD_DEFLATE = 1, 5, 8, 32773, 32946
WHITE_IS_ZERO, BLACK_IS_ZERO, RGB, PALETTE, CMYK, CIELAB = 0, 1, 2, 3, 5, 8
FLOATS = {16: "e", 32: "f", 64: "d"}
SAMPLE_FORMAT = {"uint": 1, "int": 2, "float": 3}


@dataclass
class Layout:
    order: str = "<"
    is_big: bool = False  # BigTIFF
    is_planar: bool = False
    tile: tuple = ()  # width, height
    rows_per_strip: int = 0  # 0 writes one strip; -1 omits the tag
    compression: int = NONE
    predictor: int = 1
    photometric: int = -1  # by default, the number of channels decides
    extra: tuple = ()  # 0: unspecified, 1: associated alpha, 2: unassociated alpha
    colour_map: list = field(default_factory=list)  # 16-bit words: first all red values, then all green, then all blue
    orientation: int = 0
    subfile: int = -1
    more_pages: int = 0
    left_out: int = 0  # a tag that is left out


def lzw_encoded(data):
    """Implements TIFF 6.0, section 13. Codes have 9 to 12 bits, highest bit first. The length of codes increases one
    code earlier than necessary."""
    codes, table, size, text = [(256, 9)], {bytes([i]): i for i in range(256)}, 258, b""
    width = 9
    for byte in data:
        longer = text + bytes([byte])
        if longer in table:
            text = longer
            continue
        codes.append((table[text], width))
        table[longer] = size
        size += 1
        text = bytes([byte])
        if size in (512, 1024, 2048):
            width += 1
        if size == 4095:
            codes.append((256, width))
            table, size, width = {bytes([i]): i for i in range(256)}, 258, 9
    codes.append((table[text], width))
    if size + 1 in (512, 1024, 2048):
        width += 1
    codes.append((257, width))
    number, bits = 0, 0
    for code, length in codes:
        number, bits = number << length | code, bits + length
    return (number << -bits % 8).to_bytes((bits + 7) // 8, "big")


def lzw_decoded(data):
    number, left, out = int.from_bytes(data, "big"), 8 * len(data), bytearray()
    table, width, last = [], 9, None
    while True:
        left -= width
        code = number >> left & (1 << width) - 1
        if code == 257:
            return bytes(out)
        if code == 256:
            table, width, last = [bytes([i]) for i in range(256)] + [b"", b""], 9, None
            continue
        text = table[code] if code < len(table) else last + last[:1]
        out += text
        if last is not None:
            table.append(last + text[:1])
        last = text
        width = min(12, max(9, (len(table) + 1).bit_length()))


def packbits_encoded(data):
    out, i = b"", 0
    while i < len(data):
        run = 1
        while i + run < len(data) and run < 128 and data[i + run] == data[i]:
            run += 1
        if run > 1:
            out += bytes([257 - run, data[i]])
        else:
            while i + run < len(data) and run < 128 and data[i + run] != data[i + run - 1]:
                run += 1
            out += bytes([run - 1]) + data[i:i + run]
        i += run
    return out


def packbits_decoded(data):
    out, i = b"", 0
    while i < len(data):
        if data[i] < 128:
            out += data[i + 1:i + 2 + data[i]]
            i += 2 + data[i]
        else:
            out += data[i + 1:i + 2] * (257 - data[i] if data[i] > 128 else 0)
            i += 2
    return out


def float_row(numbers, bits):
    """Returns the bits of floats as unsigned integers."""
    return [int.from_bytes(struct.pack(">" + FLOATS[bits], number), "big") for number in numbers]


def encoded_row(samples, picture, layout, step):
    """Returns the bytes of one row of a block. `step` is the number of samples per texel in the row."""
    bits = picture.bits
    codes = float_row(samples, bits) if picture.kind == "float" else [sample % (1 << bits) for sample in samples]
    if layout.predictor == 2:
        codes = [(code - (codes[i - step] if i >= step else 0)) % (1 << bits) for i, code in enumerate(codes)]
    if layout.predictor == 3:  # stores the highest bytes of all samples, then the next bytes, and so on; then stores
                               # the differences between these bytes
        planes = b"".join(bytes(code >> bits - 8 - 8 * k & 255 for code in codes) for k in range(bits // 8))
        return bytes(byte - (planes[i - step] if i >= step else 0) & 255 for i, byte in enumerate(planes))
    if bits % 8 == 0:
        return b"".join(code.to_bytes(bits // 8, "big" if layout.order == ">" else "little") for code in codes)
    return pack_bits(codes, bits)


def compressed(data, compression):
    return {NONE: bytes, LZW: lzw_encoded, DEFLATE: zlib.compress, OLD_DEFLATE: zlib.compress,
            PACKBITS: packbits_encoded}[compression](data)


def block_size(picture, layout):
    if layout.tile:
        return layout.tile
    return picture.width, layout.rows_per_strip if 0 < layout.rows_per_strip < picture.height else picture.height


def blocks_of(picture, layout):
    """Returns compressed strips or tiles, plane by plane. Beyond the edge of the picture, tiles contain arbitrary
    numbers."""
    width, height = block_size(picture, layout)
    n = picture.channels
    for plane in range(n) if layout.is_planar else (None,):
        channels = range(n) if plane is None else (plane,)
        for top in range(0, picture.height, height):
            for left in range(0, picture.width, width):
                rows = height if layout.tile else min(height, picture.height - top)
                lines = []
                for y in range(top, top + rows):
                    inside = y < picture.height
                    line = [picture.samples[(y * picture.width + x) * n + c] if inside and x < picture.width else 77
                            for x in range(left, left + width) for c in channels]
                    lines.append(encoded_row(line, picture, layout, len(channels)))
                if layout.compression == PACKBITS:  # compresses each row separately
                    yield b"".join(packbits_encoded(line) for line in lines)
                else:
                    yield compressed(b"".join(lines), layout.compression)


def write_tiff(picture, layout):
    order, word = layout.order, 8 if layout.is_big else 4
    photometric = layout.photometric if layout.photometric >= 0 else (RGB if picture.channels >= 3 else BLACK_IS_ZERO)
    mark = b"II" if order == "<" else b"MM"
    out = bytearray(mark + struct.pack(order + ("HHHQ" if layout.is_big else "HI"),
                                       *((43, 8, 0, 0) if layout.is_big else (42, 0))))
    offsets, counts = [], []
    for block in blocks_of(picture, layout):
        out += b"\0" * (len(out) % 2)
        offsets.append(len(out))
        counts.append(len(block))
        out += block
    n, offset_type = picture.channels, 16 if layout.is_big else 4
    tags = [(256, 4, [picture.width]), (257, 4, [picture.height]), (258, 3, [picture.bits] * n),
            (259, 3, [layout.compression]), (262, 3, [photometric]), (277, 3, [n]),
            (284, 3, [2 if layout.is_planar else 1]), (317, 3, [layout.predictor]),
            (339, 3, [SAMPLE_FORMAT[picture.kind]] * n)]
    if layout.tile:
        tags += [(322, 4, [layout.tile[0]]), (323, 4, [layout.tile[1]]), (324, offset_type, offsets), (325, 4, counts)]
    else:
        tags += [(273, offset_type, offsets), (279, 4, counts)]
        if layout.rows_per_strip >= 0:
            tags.append((278, 4, [layout.rows_per_strip or picture.height]))
    if layout.extra:
        tags.append((338, 3, list(layout.extra)))
    if layout.colour_map:
        tags.append((320, 3, layout.colour_map))
    if layout.orientation:
        tags.append((274, 3, [layout.orientation]))
    if layout.subfile >= 0:
        tags.append((254, 4, [layout.subfile]))
    tags = [one for one in tags if one[0] != layout.left_out]
    link = len(mark) + (6 if layout.is_big else 2)
    for page in range(1 + layout.more_pages):
        link = add_directory(out, order, word, tags, link)
        tags = [(256, 4, [1]), (257, 4, [1]), (258, 3, [8]), (259, 3, [1]), (262, 3, [1]), (277, 3, [1]), (278, 4, [1]),
                (273, offset_type, [2]), (279, 4, [1])]
    return bytes(out)


def add_directory(out, order, word, tags, link):
    """Appends a directory and points the previous link to it. Returns the position of its own link."""
    letters = {1: "B", 3: "H", 4: "I", 12: "d", 16: "Q"}
    entries = b""
    for tag, kind, numbers in sorted(tags):
        data = struct.pack(order + letters[kind] * len(numbers), *numbers)
        if len(data) > word:
            out += b"\0" * (len(out) % 2)
            place = struct.pack(order + ("Q" if word == 8 else "I"), len(out))
            out += data
        else:
            place = data.ljust(word, b"\0")
        entries += struct.pack(order + ("HHQ" if word == 8 else "HHI"), tag, kind, len(numbers)) + place
    out += b"\0" * (len(out) % 2)
    struct.pack_into(order + ("Q" if word == 8 else "I"), out, link, len(out))
    out += struct.pack(order + ("Q" if word == 8 else "H"), len(tags)) + entries
    out += bytes(word)
    return len(out) - word


def read_directory(data, order, is_big):
    sizes, letters = {1: 1, 3: 2, 4: 4, 12: 8, 16: 8}, {1: "B", 3: "H", 4: "I", 12: "d", 16: "Q"}
    at = struct.unpack_from(order + ("Q" if is_big else "I"), data, 8 if is_big else 4)[0]
    count = struct.unpack_from(order + ("Q" if is_big else "H"), data, at)[0]
    at, tags = at + (8 if is_big else 2), {}
    for _ in range(count):
        tag, kind, length = struct.unpack_from(order + ("HHQ" if is_big else "HHI"), data, at)
        place, word = at + (12 if is_big else 8), 8 if is_big else 4
        if sizes[kind] * length > word:
            place = struct.unpack_from(order + ("Q" if is_big else "I"), data, place)[0]
        tags[tag] = list(struct.unpack_from(order + letters[kind] * length, data, place))
        at += 20 if is_big else 12
    return tags


def decoded_row(data, bits, kind, order, count, predictor, step):
    if predictor == 3:
        for_bytes = bytearray(data)
        for i in range(step, len(for_bytes)):
            for_bytes[i] = for_bytes[i] + for_bytes[i - step] & 255
        codes = [int.from_bytes(bytes(for_bytes[k * count + i] for k in range(bits // 8)), "big") for i in range(count)]
    elif bits % 8:
        codes = unpack_bits(data, bits, count)
    else:
        side = "big" if order == ">" else "little"
        codes = [int.from_bytes(data[i:i + bits // 8], side) for i in range(0, count * bits // 8, bits // 8)]
    if predictor == 2:
        for i in range(step, count):
            codes[i] = (codes[i] + codes[i - step]) % (1 << bits)
    if kind == 2:
        return [code - (1 << bits) if code >> bits - 1 else code for code in codes]
    if kind == 3:
        return [struct.unpack(">" + FLOATS[bits], code.to_bytes(bits // 8, "big"))[0] for code in codes]
    return codes


def expanded(data, compression):
    return {NONE: bytes, LZW: lzw_decoded, DEFLATE: zlib.decompress, OLD_DEFLATE: zlib.decompress,
            PACKBITS: packbits_decoded}[compression](data)


def read_tiff(data):
    """Decodes the first page. Looks up colours in colour maps (v from v * 256 or v * 257), and inverts pictures in
    which 0 is white."""
    order = "<" if data[:2] == b"II" else ">"
    is_big = struct.unpack_from(order + "H", data, 2)[0] == 43
    tags = read_directory(data, order, is_big)
    width, height, bits, n = tags[256][0], tags[257][0], tags[258][0], tags[277][0]
    kind, predictor, is_planar = tags[339][0], tags[317][0], tags[284][0] == 2
    is_tiled = 322 in tags
    block_width = tags[322][0] if is_tiled else width
    block_height = tags[323][0] if is_tiled else min(height, tags.get(278, [height])[0])
    offsets, counts = tags[324 if is_tiled else 273], tags[325 if is_tiled else 279]
    samples, block = [0] * (width * height * n), 0
    for plane in range(n) if is_planar else (None,):
        channels = range(n) if plane is None else (plane,)
        for top in range(0, height, block_height):
            for left in range(0, width, block_width):
                bytes_of = expanded(data[offsets[block]:offsets[block] + counts[block]], tags[259][0])
                block += 1
                count = block_width * len(channels)
                length = (count * bits + 7) // 8
                for y in range(top, min(height, top + block_height)):
                    row = decoded_row(bytes_of[(y - top) * length:(y - top + 1) * length], bits, kind, order, count,
                                      predictor, len(channels))
                    for x in range(left, min(width, left + block_width)):
                        for k, c in enumerate(channels):
                            samples[(y * width + x) * n + c] = row[(x - left) * len(channels) + k]
    kind = {number: name for name, number in SAMPLE_FORMAT.items()}[kind]
    extra = len([e for e in tags.get(338, []) if e in (1, 2)])
    if tags[262][0] == WHITE_IS_ZERO:
        samples = [(1 << bits) - 1 - sample if i % n == 0 else sample for i, sample in enumerate(samples)]
    if tags[262][0] == PALETTE:
        words, entries = tags[320], 1 << bits
        unit = 256 if all(word % 256 == 0 for word in words) else 257
        samples = [words[c * entries + i] // unit for i in samples for c in range(3)]
        return Picture(width, height, 3, "uint", 8, samples, 3)
    return Picture(width, height, n, kind, bits, samples, n - extra)




def layout_text(data):
    """Returns the first tags of a whole file, for messages."""
    order = "<" if data[:2] == b"II" else ">"
    is_big = struct.unpack_from(order + "H", data, 2)[0] == 43
    try:
        tags = read_directory(data, order, is_big)
    except struct.error:
        return "cut"
    names = {258: "bits", 259: "compression", 262: "photometric", 278: "rows", 284: "planes", 317: "predictor",
             322: "tile", 338: "extra", 339: "format"}
    return " ".join([data[:2].decode() + "+" * is_big] + [f"{name} {tags[tag][0]}" for tag, name in names.items()
                                                         if tag in tags])
