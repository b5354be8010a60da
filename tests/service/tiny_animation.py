# SPDX-License-Identifier: Apache-2.0
"""Makes the smallest job of inference, which has one square in one picture of one colour. Uses only the standard
library."""
import os
import random
import struct
import zlib

SIDE = 16  # pixels
QUAD = ("o quad\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
        "f 1/1/1 2/2/1 3/3/1 4/4/1\n")
ANIMATION = '''geometry = "quad.obj"
width = SIDE
height = SIDE
[[parameter]]
name = "time"
count = 1
[[layer]]
name = "all"
passes = [""]
depends_on = ["time"]
[[object]]
name = "quad"
index = 1
[[camera]]
name = "one"
world_to_camera = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -3], [0, 0, 0, 1]]
projection = [[2.5, 0, 0, 0], [0, 2.5, 0, 0], [0, 0, -1.1, -1.1], [0, 0, -1, 0]]
[[sample]]
at = [0]
radiance = "radiance.exr"
object_index = "index.png"
camera = "one"
'''


def write_exr(path, value, side=SIDE, noise=0):
    """Writes the same R, G and B for every pixel, as uncompressed floats."""
    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    channels = b"".join(name + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<4i", 0, 0, side - 1, side - 1)
    header = b"\x76\x2f\x31\x01" + struct.pack("<i", 2)
    for one in (("channels", "chlist", channels), ("compression", "compression", b"\0"),
                ("dataWindow", "box2i", window), ("displayWindow", "box2i", window), ("lineOrder", "lineOrder", b"\0"),
                ("pixelAspectRatio", "float", struct.pack("<f", 1)), ("screenWindowCenter", "v2f", bytes(8)),
                ("screenWindowWidth", "float", struct.pack("<f", 1))):
        header += attribute(*one)
    header += b"\0"
    some = random.Random(1)
    first, size = len(header) + 8 * side, 12 * side
    offsets = b"".join(struct.pack("<q", first + y * (8 + size)) for y in range(side))
    lines = b"".join(struct.pack("<ii", y, size) +
                     struct.pack(f"<{3 * side}f", *(value + noise * some.random() for _ in range(3 * side)))
                     for y in range(side))
    with open(path, "wb") as file:
        file.write(header + offsets + lines)


def write_index(path, side=SIDE):
    """Writes a grey PNG of object indices: every pixel shows the first object."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + b"\1" * side for _ in range(side))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_animation(folder, value, side=SIDE, noise=0):
    """Writes quad.obj, radiance.exr, index.png, and animation.toml, which names them."""
    write_exr(os.path.join(folder, "radiance.exr"), value, side, noise)
    write_index(os.path.join(folder, "index.png"), side)
    animation = ANIMATION.replace("SIDE", str(side))
    for name, text in (("quad.obj", QUAD), ("animation.toml", animation)):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(text)
