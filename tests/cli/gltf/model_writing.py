# SPDX-License-Identifier: Apache-2.0
"""Writes glTF models for tests, and reads GLB files and RGBA KTX2 files. Uses only Python's standard library."""
import base64
import json
import math
import random
import struct
import zlib

FLOAT, UNSIGNED_SHORT = 5126, 5123


def png(width, height, texel):
    """Returns an 8-bit RGB PNG. `texel(x, y)` returns three codes."""
    rows = b"".join(b"\0" + bytes(code for x in range(width) for code in texel(x, y)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def code(component):
    return round(255 * (0.5 + 0.5 * component))


def bumps(width, height, steepness=0.6, seed=1):
    """Returns a normal map whose slopes vary from texel to texel."""
    rng = random.Random(seed)
    slopes = [[(rng.gauss(0, steepness), rng.gauss(0, steepness)) for _ in range(width)] for _ in range(height)]

    def texel(x, y):
        a, b = slopes[y][x]
        length = math.sqrt(a * a + b * b + 1)
        return code(a / length), code(b / length), code(1 / length)

    return png(width, height, texel)


class Model:
    """A model that is built piece by piece. All bytes are in buffer 0, except for images with a URI."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "meshes": [], "accessors": [], "bufferViews": [], "materials": []}
        self.bytes = b""

    def view(self, data, **more):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data), **more})
        self.bytes += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, kind, rows, component=FLOAT, **more):
        form = {FLOAT: "f", UNSIGNED_SHORT: "H"}[component]
        flat = [value for row in rows for value in row]
        data = struct.pack(f"<{len(flat)}{form}", *flat)
        self.json["accessors"].append({"bufferView": self.view(data), "componentType": component, "count": len(rows),
                                       "type": kind, **more})
        return len(self.json["accessors"]) - 1

    def square(self, material=0, sets=1, repeats=1.0):
        """Adds a square of two triangles, with tangents."""
        corners = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
        coordinates = [(0.5 * repeats * (x + 1), 0.5 * repeats * (1 - y)) for x, y, _ in corners]
        attributes = {"POSITION": self.accessor("VEC3", corners, min=[-1, -1, 0], max=[1, 1, 0]),
                      "NORMAL": self.accessor("VEC3", [(0.0, 0.0, 1.0)] * 4),
                      "TANGENT": self.accessor("VEC4", [(1.0, 0.0, 0.0, 1.0)] * 4)}
        for number in range(sets):
            attributes[f"TEXCOORD_{number}"] = self.accessor("VEC2", coordinates)
        indices = self.accessor("SCALAR", [(i,) for i in (0, 1, 2, 0, 2, 3)], UNSIGNED_SHORT)
        primitive = {"attributes": attributes, "indices": indices, "material": material}
        self.json["meshes"].append({"primitives": [primitive]})
        return primitive

    def _added(self, name, value):
        self.json.setdefault(name, []).append(value)
        return len(self.json[name]) - 1

    def image(self, data, uri=None, **more):
        if uri is not None:
            return self._added("images", {"uri": uri, **more})
        return self._added("images", {"bufferView": self.view(data), "mimeType": "image/png", **more})

    def texture(self, image, **more):
        return self._added("textures", {"source": image, **more})

    def sampler(self, **values):
        return self._added("samplers", values)

    def material(self, **values):
        self.json["materials"].append(values)
        return len(self.json["materials"]) - 1

    def glb(self):
        self.json["buffers"] = [{"byteLength": len(self.bytes)}] + self.json.get("buffers", [])[1:]
        return glb_of(json.dumps(self.json).encode(), self.bytes)

    def gltf(self, uri=None):
        """Returns JSON with the bytes in a data URI, or in the file that `uri` names."""
        data = "data:application/octet-stream;base64," + base64.b64encode(self.bytes).decode()
        self.json["buffers"] = [{"byteLength": len(self.bytes), "uri": uri or data}]
        return json.dumps(self.json).encode()


def glb_of(text, data, length=None, json_length=None, data_length=None):
    """Returns a GLB of these chunks. If lengths are given, they replace the correct ones."""
    text += b" " * (-len(text) % 4)
    padded = data + b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text) if json_length is None else json_length, b"JSON") + text
    if data:
        chunks += struct.pack("<I4s", len(padded) if data_length is None else data_length, b"BIN\0") + padded
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks) if length is None else length) + chunks


class Glb:
    """A GLB file as another program reads it."""

    def __init__(self, data):
        assert data[:4] == b"glTF" and struct.unpack("<II", data[4:12]) == (2, len(data))
        length, kind = struct.unpack("<I4s", data[12:20])
        assert kind == b"JSON" and length % 4 == 0
        self.json = json.loads(data[20:20 + length])
        self.bytes = b""
        self.rest = data[20 + length:]
        if self.rest:
            size, kind = struct.unpack("<I4s", self.rest[:8])
            assert kind == b"BIN\0" and size % 4 == 0
            self.bytes, self.rest = self.rest[8:8 + size], self.rest[8 + size:]

    def view(self, number):
        view = self.json["bufferViews"][number]
        buffer = self.json["buffers"][view["buffer"]]
        data = base64.b64decode(buffer["uri"].split(",")[1]) if "uri" in buffer else self.bytes
        begin = view.get("byteOffset", 0)
        assert begin + view["byteLength"] <= buffer["byteLength"] <= len(data)
        return data[begin:begin + view["byteLength"]]

    def image(self, texture):
        """Returns the bytes of a texture's image."""
        texture = self.json["textures"][texture]
        basis = texture.get("extensions", {}).get("KHR_texture_basisu", {})
        return self.view(self.json["images"][basis.get("source", texture.get("source"))]["bufferView"])

    def levels(self, texture):
        return rgba_levels(self.image(texture))


class Level:
    def __init__(self, width, height, data):
        self.width, self.height, self.data = width, height, data

    def at(self, x, y):
        begin = 4 * (y * self.width + x)
        return tuple(self.data[begin:begin + 4])

    def mean(self, channel):
        values = self.data[channel::4]
        return sum(values) / len(values)


def rgba_levels(data):
    """Returns all levels of an RGBA KTX2 file with 8 bits per channel. The file must contain a full mip chain."""
    assert data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n"
    form, _, width, height, _, _, _, count, scheme = struct.unpack("<9I", data[12:48])
    assert (form, scheme) == (37, 0)
    assert count == max(width, height).bit_length()
    levels = []
    for number in range(count):
        offset, length, _ = struct.unpack("<3Q", data[80 + 24 * number:104 + 24 * number])
        w, h = max(1, width >> number), max(1, height >> number)
        assert length == 4 * w * h
        levels.append(Level(w, h, data[offset:offset + length]))
    return levels
