# SPDX-License-Identifier: Apache-2.0
"""Makes the odd inputs, which are about 570 small maps from a seed. For each map, also gives the result that
docs/reference/input_maps.md promises."""
import math
import struct
import zlib
from dataclasses import dataclass, field

import odd_tiff as tiff
from exr_reading import read_exr
from odd_exr import ExrPart, write_exr
from odd_images import Picture, read_png, write_png
from odd_maps import (Meaning, colours_of, heights, linear_from_srgb, picture_of, rounded, scalar_picture, surface)
from odd_tiff import Layout, read_tiff, write_tiff

SIZES = ((8, 8), (9, 13), (17, 11), (33, 17), (16, 16), (12, 20), (31, 9), (5, 7), (8, 33), (1, 1), (1, 16), (16, 1),
         (2, 3), (3, 1))
LARGE = ((17, 11), (33, 17), (16, 16), (12, 20), (31, 19), (14, 33))  # the direction of green can be recognised
NAN, INF = math.nan, math.inf


@dataclass
class Beside:
    """Describes a map that accompanies the normals: colours, roughness, gloss or weights."""
    option: str
    data: bytes
    extension: str
    expected: list  # indexed by [texel], as in the baked file
    channel: str = ""


@dataclass
class Case:
    kind: str
    data: bytes
    extension: str
    picture: Picture = None  # the values that the decoder of these tests reads; None if the file is refused
    meaning: Meaning = field(default_factory=Meaning)
    options: tuple = ()
    warns: tuple = ()  # each of these texts must be in a warning
    refused: tuple = ()  # each of these texts must be in the message
    beside: tuple = ()
    tolerance: float = 1e-5
    movmf: bool = False
    note: str = ""  # for messages

    def name_note(self):
        files = [self.data] + [beside.data for beside in self.beside]
        self.note = "; ".join(tiff.layout_text(data) for data in files if data[:2] in (b"II", b"MM"))


def exr_picture(data, names):
    """Returns the first part's channels, by name, as one picture. Channels of different types become floats."""
    part = read_exr(data)[0]
    planes = [part.levels[0][name] for name in names]
    kinds = {kind for _, kind in part.channels}
    kind, bits = {0: ("uint", 32), 1: ("float", 16), 2: ("float", 32)}[min(kinds)]
    return Picture(part.width, part.height, len(names), kind, bits, [v for texel in zip(*planes) for v in texel])


class Generator:
    def __init__(self, random):
        self.random = random
        self.cases = []
        for generate in (self.png_normals, self.png_palettes, self.png_chunks, self.two_channels, self.png_heights,
                         self.green, self.tiff_normals, self.tiff_depths, self.tiff_palettes, self.tiff_pages,
                         self.tiff_strips, self.tiff_refused, self.exr_normals, self.exr_names, self.exr_parts,
                         self.contents, self.height_settings, self.albedos, self.materials, self.lobes, self.refusals):
            generate()

    def add(self, kind, data, extension, *arguments, **keys):
        self.cases.append(Case(kind, data, extension, *arguments, **keys))
        self.cases[-1].name_note()

    def size(self, sizes=SIZES):
        return self.random.choice(sizes)

    def normals(self, kind="uint", bits=8, sizes=SIZES, is_signed=None):
        """Returns the normals of a surface as a picture, and the normals that are expected from it."""
        width, height = self.size(sizes)
        is_signed = kind == "int" if is_signed is None else is_signed
        return picture_of(surface(width, height, self.random), width, height, kind, bits, is_signed), \
            Meaning(is_signed=is_signed)

    def with_alpha(self, picture, count=1):
        """Appends random numbers to each texel."""
        n, samples = picture.channels, []
        for i in range(0, len(picture.samples), n):
            largest = 2**(picture.bits - (picture.kind == "int")) - 1
            alpha = [self.random.random() if picture.kind == "float" else self.random.randrange(largest)
                     for _ in range(count)]
            if picture.kind == "float":
                alpha = [rounded(a, "float", picture.bits) for a in alpha]
            samples += picture.samples[i:i + n] + alpha
        return Picture(picture.width, picture.height, n + count, picture.kind, picture.bits, samples, n)

    def png(self, picture, colour_type, **keys):
        return write_png(picture.width, picture.height, colour_type, picture.bits, picture.samples, self.random, **keys)

    def png_normals(self):
        for bits in (8, 16):
            for colour_type in (2, 6):
                for interlace in (False, True):
                    for _ in range(4):
                        picture, meaning = self.normals(bits=bits)
                        if colour_type == 6:
                            picture = self.with_alpha(picture)
                        data = self.png(picture, colour_type, interlace=interlace)
                        self.add("PNG normals", data, "png", read_png(data), meaning)

    def few_normals(self, count):
        """Returns `count` 8-bit normals around +Z, which are the entries of a colour map."""
        normals = surface(16, 16, self.random)
        chosen = self.random.sample(normals, count)
        return [[rounded(c / 2 + 0.5, "uint", 8) for c in v] for v in chosen]

    def png_palettes(self):
        for depth in (1, 2, 4, 8):
            for variant in range(3):
                width, height = self.size(((8, 8), (9, 13), (17, 11), (33, 17), (5, 7)))
                palette = self.few_normals(2**depth)
                indices = [self.random.randrange(len(palette)) for _ in range(width * height)]
                picture = Picture(width, height, 1, "uint", depth, indices)
                data = self.png(picture, 3, palette=palette, interlace=variant == 1,
                                transparent=bytes([0, 128]) if variant == 2 else None)
                # Facets in random order may be of only two kinds, both of which lean to the same side.
                self.add("PNG palettes", data, "png", read_png(data), options=("--bumpformat", "normal"))

    def png_chunks(self):
        gamma = struct.pack(">I", 45455)
        for bits in (8, 16):
            largest = 2**bits - 1
            for chunks in ([(b"gAMA", gamma)], [(b"gAMA", struct.pack(">I", 100000))], [(b"sRGB", b"\0")],
                           [(b"gAMA", struct.pack(">I", 220000)), (b"sRGB", b"\1")],
                           [(b"tEXt", b"Comment\0odd"), (b"pHYs", struct.pack(">IIB", 1, 3, 1))],
                           [(b"oFFs", struct.pack(">iiB", -3, 7, 0)), (b"sBIT", bytes([5, 6, 5]))],
                           [(b"cHRM", struct.pack(">8I", *range(31270, 31278))),
                            (b"iCCP", b"odd\0\0" + zlib.compress(b"no profile"))]):
                picture, meaning = self.normals(bits=bits)
                data = self.png(picture, 2, chunks=chunks)
                self.add("PNG chunks", data, "png", read_png(data), meaning)
            picture, meaning = self.normals(bits=bits)  # one colour is transparent, and another is the background
            data = self.png(picture, 2, transparent=struct.pack(">3H", *picture.samples[:3]),
                            chunks=[(b"bKGD", struct.pack(">3H", largest, 0, 0))])
            self.add("PNG chunks", data, "png", read_png(data), meaning)

    def two_channels(self):
        for bits in (8, 16):
            for blue in (0, 2**(bits - 1) - 1, 2**(bits - 1), 2**bits - 1):
                for _ in range(2):
                    width, height = self.size(LARGE)
                    picture = picture_of(surface(width, height, self.random, 0.7), width, height, "uint", bits, False)
                    picture.samples[2::3] = [blue] * (width * height)
                    data = self.png(picture, 2)
                    self.add("two channels", data, "png", read_png(data), Meaning(is_two_channel=True))
        for kind, bits in (("uint", 8), ("uint", 16), ("int", 8), ("int", 16), ("float", 16), ("float", 32)):
            for is_planar in (False, True):
                width, height = self.size(LARGE)
                vectors = [v[:2] for v in surface(width, height, self.random, 0.7)]
                picture = picture_of(vectors, width, height, kind, bits, kind != "uint")
                data = write_tiff(picture, Layout(is_planar=is_planar, photometric=tiff.BLACK_IS_ZERO, extra=(0,)))
                self.add("two channels", data, "tif", read_tiff(data),
                         Meaning(is_two_channel=True, is_signed=kind != "uint"))
        width, height = 9, 13  # this warning is printed for a map that does not store z in blue
        picture = picture_of(surface(width, height, self.random), width, height, "uint", 8, False)
        data = self.png(picture, 2)
        self.add("two channels", data, "png", read_png(data), Meaning(is_two_channel=True), ("--two-channel",))

    def png_heights(self):
        grey = ("a grey image, read as a height field",)
        for bits in (2, 4, 8, 16):
            for colour_type in (0, 4, 2) if bits >= 8 else (0,):
                for interlace in (False, True):
                    width, height = self.size(SIZES[:9])
                    picture = scalar_picture(heights(width, height, self.random), width, height, "uint", bits)
                    if colour_type == 4:
                        picture = self.with_alpha(picture)
                    if colour_type == 2:
                        picture.samples, picture.channels = [v for v in picture.samples for _ in range(3)], 3
                    data = self.png(picture, colour_type, interlace=interlace)
                    scale = self.random.choice((1, 2.5, -3))
                    self.add("PNG heights", data, "png", read_png(data), Meaning(height_scale=scale),
                             ("--height-scale", str(scale)), grey)
        entries = [[v, v, v] for v in range(0, 255, 8)]
        picture = Picture(17, 11, 1, "uint", 8, [self.random.randrange(len(entries)) for _ in range(17 * 11)])
        data = self.png(picture, 3, palette=entries)
        self.add("PNG heights", data, "png", read_png(data), Meaning(height_scale=2), ("--height-scale", "2"))

    def green(self):
        def down(sizes, steepness=0.4):
            width, height = self.size(sizes)
            vectors = [(x, -y, z) for x, y, z in surface(width, height, self.random, steepness)]
            return picture_of(vectors, width, height, "uint", 16, False)

        for _ in range(6):  # the program finds the direction of green
            data = self.png(down(LARGE), 2)
            self.add("green", data, "png", read_png(data), Meaning(green=-1))
        for _ in range(4):  # the option states the direction of green
            data = self.png(down(SIZES), 2)
            self.add("green", data, "png", read_png(data), Meaning(green=-1), ("--green", "down"))
        data = self.png(down(LARGE), 2)
        self.add("green", data, "png", read_png(data), Meaning(), ("--green", "up"), ("green was set to up",))
        for size in ((5, 7), (8, 8)):  # the map is too small for statistics, so green is read as up
            data = self.png(down((size,)), 2)
            self.add("green", data, "png", read_png(data), Meaning(), (), ("--green up or --green down",))
        picture, meaning = self.normals(bits=16)
        data = self.png(picture, 2)
        meaning.normal_scale = 0.25
        self.add("green", data, "png", read_png(data), meaning, ("--normal-scale", "0.25"))

    def layout(self, picture, **keys):
        """Chooses any predictor that is legal for the picture."""
        choose = self.random.choice
        layout = Layout(order=choose("<>"), is_big=choose((False, True)), is_planar=choose((False, True)),
                        compression=choose((tiff.NONE, tiff.LZW, tiff.DEFLATE, tiff.PACKBITS, tiff.OLD_DEFLATE)))
        if choose((False, True)):
            layout.tile = choose(((16, 16), (16, 32), (32, 16)))
        else:
            layout.rows_per_strip = choose((0, 1, 2, 3, 5, 8))
        if layout.compression in (tiff.LZW, tiff.DEFLATE, tiff.OLD_DEFLATE) and choose((False, True)):
            layout.predictor = 3 if picture.kind == "float" else 2 if picture.bits in (8, 16, 32) else 1
        for name, value in keys.items():
            setattr(layout, name, value)
        return layout

    def tiff_normals(self):
        for kind, bits in (("uint", 8), ("uint", 16), ("uint", 32), ("int", 8), ("int", 16), ("int", 32), ("float", 16),
                           ("float", 32), ("float", 64)):
            for i in range(9):
                is_signed = kind == "int" or kind == "float" and i % 2 == 0
                # Rows and tiles of 64-bit floats are refused unless each channel has its own plane.
                is_double = (kind, bits) == ("float", 64)
                sizes = SIZES if not is_double else [size for size in SIZES if size[1] > 1]
                picture, meaning = self.normals(kind, bits, sizes, is_signed)
                extra = ()
                if i % 3 == 2:
                    extra = self.random.choice(((1,), (2,), (0,)))
                    picture = self.with_alpha(picture)
                layout = self.layout(picture, extra=extra, **({"tile": ()} if is_double else {}))
                data = write_tiff(picture, layout)
                decoded = read_tiff(data)
                assert decoded.samples == picture.samples, layout
                decoded.colours = 3
                self.add("TIFF normals", data, "tif", decoded, meaning)

    def tiff_depths(self):
        """Adds heights of every bit depth, with 0 for black or for white."""
        for photometric in (tiff.BLACK_IS_ZERO, tiff.WHITE_IS_ZERO):
            for bits in (2, 4, 6, 8, 10, 12, 14, 16, 32):
                for i in range(2):
                    width, height = self.size(SIZES[:9])
                    picture = scalar_picture(heights(width, height, self.random), width, height, "uint", bits)
                    extra = ()
                    if bits >= (16 if photometric == tiff.WHITE_IS_ZERO else 8) and bits % 8 == 0 and i == 1:
                        picture, extra = self.with_alpha(picture), (2,)
                    layout = self.layout(picture, photometric=photometric, extra=extra,
                                         is_planar=bool(extra) and self.random.choice((False, True)))
                    if bits == 8 and i == 1:
                        layout = Layout(photometric=photometric, extra=extra, rows_per_strip=2, predictor=2,
                                        compression=tiff.DEFLATE)
                    data = write_tiff(picture, layout)
                    decoded = read_tiff(data)
                    scale = 2.0
                    self.add("TIFF depths", data, "tif", decoded, Meaning(height_scale=scale),
                             ("--height-scale", str(scale)), ("a grey image, read as a height field",),
                             tolerance={6: 2 * scale / 255, 10: 1e-4, 12: 1e-4, 14: 1e-4}.get(bits, 1e-5))
        for order in "<>":
            for tile in ((), (16, 16)):
                picture = scalar_picture(heights(17, 11, self.random), 17, 11, "uint", 24)
                data = write_tiff(picture, Layout(order=order, tile=tile))
                self.add("TIFF, refused", data, "tif", refused=("24 bits", "expected"))
        for kind, bits in (("int", 4), ("int", 12), ("uint", 3), ("uint", 20), ("float", 24)):
            codes = [self.random.randrange(2**(bits - 1)) for _ in range(17 * 11)]
            data = write_tiff(Picture(17, 11, 1, "uint", bits, codes), Layout())
            format_entry = struct.pack("<HHIH", 339, 3, 1, 1)
            number = tiff.SAMPLE_FORMAT[kind]
            data = data.replace(format_entry, struct.pack("<HHIH", 339, 3, 1, number))
            self.add("TIFF, refused", data, "tif", refused=(f"{bits} bits", "expected"))
        picture = scalar_picture(heights(9, 13, self.random), 9, 13, "uint", 1)  # a depth of one bit is not supported
        self.add("TIFF, refused", write_tiff(picture, Layout(left_out=258)), "tif",
                 refused=("BitsPerSample", "expected"), options=("--bumpformat", "height"))

    def tiff_palettes(self):
        for bits in (1, 2, 4, 8, 16):
            for unit in (257, 256):
                entries = self.few_normals(min(256, 2**bits))
                colour_map = [entries[i % len(entries)][c] * unit for c in range(3) for i in range(2**bits)]
                width, height = self.size(((8, 8), (9, 13), (17, 11), (33, 17)))
                picture = Picture(width, height, 1, "uint", bits,
                                  [self.random.randrange(2**bits) for _ in range(width * height)])
                layout = self.layout(picture, photometric=tiff.PALETTE, colour_map=colour_map, is_planar=False)
                data = write_tiff(picture, layout)
                self.add("TIFF palettes", data, "tif", read_tiff(data), options=("--bumpformat", "normal"))
        entries = self.few_normals(256)  # 8 bits cannot hold these 16-bit values, so the loss is reported
        words = [min(65535, entries[i][c] * 257 + self.random.randrange(257)) for c in range(3) for i in range(256)]
        picture = Picture(9, 13, 1, "uint", 8, [self.random.randrange(256) for _ in range(9 * 13)])
        data = write_tiff(picture, Layout(photometric=tiff.PALETTE, colour_map=words))
        decoded = Picture(9, 13, 3, "uint", 16, [words[c * 256 + i] for i in picture.samples for c in range(3)])
        self.add("TIFF palettes", data, "tif", decoded, options=("--bumpformat", "normal"), warns=("16-bit colours",),
                 tolerance=0.012)
        for extra in (0, 2):
            entries = self.few_normals(256)
            words = [entries[i][c] * 257 for c in range(3) for i in range(256)]
            picture = self.with_alpha(Picture(9, 13, 1, "uint", 8, [self.random.randrange(256) for _ in range(9 * 13)]))
            data = write_tiff(picture, Layout(photometric=tiff.PALETTE, colour_map=words, extra=(extra,)))
            self.add("TIFF palettes", data, "tif", refused=("palette", "2 channels", "expected"))

    def tiff_pages(self):
        for orientation in range(1, 9):
            picture, meaning = self.normals()
            data = write_tiff(picture, self.layout(picture, orientation=orientation))
            self.add("TIFF pages", data, "tif", read_tiff(data), meaning,
                     warns=(f"orientation {orientation}",) if orientation > 1 else ())
        for keys, warning in (({"more_pages": 2}, "3 pages"), ({"more_pages": 1, "subfile": 1}, "reduced version"),
                              ({"subfile": 1}, "reduced version"), ({"more_pages": 3, "subfile": 2}, "4 pages")):
            for is_big in (False, True):
                picture, meaning = self.normals(bits=16)
                data = write_tiff(picture, self.layout(picture, is_big=is_big, **keys))
                self.add("TIFF pages", data, "tif", read_tiff(data), meaning, warns=(warning,))

    def tiff_strips(self):
        """Adds strips that hold all rows. The number of rows is left out or is the largest possible number."""
        for kind, bits in (("uint", 8), ("uint", 16), ("float", 32), ("float", 64)):
            for rows in (-1, 2**32 - 1, 2**31 - 1):
                for compression in (tiff.NONE, tiff.DEFLATE):
                    picture, meaning = self.normals(kind, bits, ((9, 13), (17, 11)), False)
                    layout = Layout(rows_per_strip=rows, compression=compression,
                                    predictor=2 if compression == tiff.DEFLATE and kind == "uint" else 1)
                    data = write_tiff(picture, layout)
                    if (bits, rows, compression) == (64, -1, tiff.DEFLATE):
                        self.add("TIFF strips", data, "tif", refused=("RowsPerStrip", "expected"))
                    else:
                        self.add("TIFF strips", data, "tif", read_tiff(data), meaning)
        for compression in (tiff.NONE, tiff.LZW, tiff.DEFLATE):
            for is_planar in (False, True):
                picture, meaning = self.normals("float", 64, ((17, 11), (33, 17)), True)
                layout = Layout(tile=(16, 16), compression=compression, is_planar=is_planar,
                                predictor=3 if compression == tiff.LZW else 1)
                data = write_tiff(picture, layout)
                if is_planar:
                    self.add("TIFF strips", data, "tif", read_tiff(data), meaning)
                else:
                    self.add("TIFF strips", data, "tif", refused=("64-bit", "tiles", "expected"))
        for rows in (1, 2, 7, 12, 13):  # doubles need strips that hold all rows
            for is_planar in (False, True):
                picture, meaning = self.normals("float", 64, ((9, 13),), True)
                data = write_tiff(picture, Layout(rows_per_strip=rows, is_planar=is_planar))
                self.add("TIFF strips", data, "tif", read_tiff(data), meaning)

    def tiff_refused(self):
        for kind, bits in (("int", 8), ("int", 16), ("float", 32), ("float", 16)):
            picture = scalar_picture(heights(9, 13, self.random), 9, 13, kind, bits)
            self.add("TIFF, refused", write_tiff(picture, Layout(photometric=tiff.WHITE_IS_ZERO)), "tif",
                     refused=("MinIsWhite", "expected"))
        for kind, bits in (("uint", 64), ("int", 64)):
            samples = [self.random.randrange(2**62) for _ in range(9 * 13 * 3)]
            self.add("TIFF, refused", write_tiff(Picture(9, 13, 3, kind, bits, samples), Layout()), "tif",
                     refused=("64 bits", "expected"))
        picture, meaning = self.normals("float", 64, ((16, 1),), True)
        self.add("TIFF, refused", write_tiff(picture, Layout()), "tif", refused=("64-bit", "expected"))
        picture, _ = self.normals(sizes=((17, 11),))
        for photometric in (tiff.CMYK, tiff.CIELAB, 9, 10, 32803):
            wide = self.with_alpha(picture) if photometric == tiff.CMYK else picture
            self.add("TIFF, refused", write_tiff(wide, Layout(photometric=photometric)), "tif",
                     refused=("PhotometricInterpretation", "expected"))
        for kind, bits in (("uint", 16), ("float", 32)):
            picture, _ = self.normals(kind, bits, ((17, 11),))
            for photometric in (tiff.CMYK, tiff.CIELAB):
                wide = self.with_alpha(picture) if photometric == tiff.CMYK else picture
                self.add("TIFF, refused", write_tiff(wide, Layout(photometric=photometric)), "tif",
                         refused=("PhotometricInterpretation", "expected"))
        picture, meaning = self.normals(bits=16)  # linear values of a camera, which are read unchanged
        data = write_tiff(picture, Layout(photometric=34892))
        self.add("TIFF normals", data, "tif", read_tiff(data), meaning)
        for count in (1, 2, 4):  # channels in addition to colour and alpha
            picture, meaning = self.normals(bits=16)
            data = write_tiff(self.with_alpha(picture, count), Layout(extra=(0,) * count))
            decoded = read_tiff(data)
            decoded.colours = 3
            self.add("TIFF normals", data, "tif", decoded, meaning)

    def exr_file(self, picture, names, **keys):
        kind = "uint" if picture.kind == "uint" else {16: "half", 32: "float"}[picture.bits]
        channels = {name: (kind, picture.samples[c::picture.channels]) for c, name in enumerate(names)}
        return write_exr([ExrPart(picture.width, picture.height, channels, **keys)])

    def exr_normals(self):
        for kind, bits in (("float", 16), ("float", 32), ("uint", 32)):
            for compression in range(4):
                for tile in (0, 16):
                    is_signed = kind == "float" and self.random.choice((False, True))
                    picture, meaning = self.normals(kind, bits, is_signed=is_signed)
                    data = self.exr_file(picture, "RGB", compression=compression, tile=tile)
                    self.add("EXR normals", data, "exr", exr_picture(data, "RGB"), meaning)
        for origin, display in (((-5, 3), (0, 0, 31, 31)), ((1000, -2000), ()), ((3, 3), (0, 0, 99, 9)),
                                ((0, 0), (0, 0, 4, 4))):
            for compression, decreasing, tile in ((3, False, 0), (2, True, 0), (0, False, 16)):
                picture, meaning = self.normals("float", 32, is_signed=True)
                data = self.exr_file(picture, "XYZ", compression=compression, decreasing=decreasing, tile=tile,
                                     origin=origin, display=display)
                self.add("EXR windows", data, "exr", exr_picture(data, "XYZ"), meaning)

    def exr_names(self):
        for names in ("XYZ", "xyz", "RGB", "rgb", ("layer.R", "layer.G", "layer.B"), ("N.X", "N.Y", "N.Z"),
                      ("N.x", "N.y", "N.z"), ("Red", "Green", "Blue"), ("nx", "ny", "nz"), ("a.b.X", "a.b.Y", "a.b.Z")):
            picture, meaning = self.normals("float", 32, LARGE, True)
            data = self.exr_file(picture, names)
            self.add("EXR names", data, "exr", exr_picture(data, names), meaning)
        for names in ("RGBA", "XYZA", ("n.R", "n.G", "n.B", "n.A")):
            picture, meaning = self.normals("float", 16, LARGE, True)
            data = self.exr_file(self.with_alpha(picture), names)
            self.add("EXR names", data, "exr", exr_picture(data, names[:3]), meaning)
        for names in (("R", "G"), ("X", "Y"), ("x", "y"), ("N.X", "N.Y"), ("U", "V"), ("nx", "ny"), ("r", "g")):
            width, height = self.size(LARGE)
            vectors = [v[:2] for v in surface(width, height, self.random, 0.7)]
            picture = picture_of(vectors, width, height, "float", 32, True)
            data = self.exr_file(picture, names)
            self.add("EXR names", data, "exr", exr_picture(data, names), Meaning(is_signed=True, is_two_channel=True))
        picture, meaning = self.normals("float", 32, LARGE, True)
        wide = self.with_alpha(picture, 3)
        data = self.exr_file(wide, ("R", "G", "B", "depth.Z", "mask.R", "mask.G"))
        self.add("EXR names", data, "exr", exr_picture(data, "RGB"), meaning)
        channels = {"R": ("half", [rounded(v, "float", 16) for v in picture.samples[0::3]]),
                    "G": ("float", picture.samples[1::3]), "B": ("float", picture.samples[2::3])}
        data = write_exr([ExrPart(picture.width, picture.height, channels)])
        self.add("EXR names", data, "exr", exr_picture(data, "RGB"), meaning)
        for name in ("Y", "Z", "height", "R", "layer.Y"):
            width, height = self.size(LARGE)
            picture = scalar_picture(heights(width, height, self.random), width, height, "float", 32)
            data = self.exr_file(picture, (name,))
            self.add("EXR names", data, "exr", exr_picture(data, (name,)), Meaning(height_scale=2),
                     ("--height-scale", "2"))
        picture, _ = self.normals("float", 32, LARGE, False)  # luminance and chroma channels
        self.add("EXR names", self.exr_file(picture, ("Y", "RY", "BY")), "exr", refused=("BY", "expected"))
        data = self.exr_file(self.colours(3, 32, "float"), ("Y", "RY", "BY"))
        self.beside(9, 13, Beside("--albedo", data, "exr", []), kind="EXR names", refused=("BY", "expected"))

    def exr_parts(self):
        for compression in range(4):
            for tile in (0, 16):
                picture, meaning = self.normals("float", 32, is_signed=True)
                other, _ = self.normals("float", 16, is_signed=True)
                parts = [ExrPart(p.width, p.height, {name: (kind, p.samples[c::3]) for c, name in enumerate("RGB")},
                                 display=(0, 0, 40, 40), compression=compression, tile=tile)
                         for p, kind in ((picture, "float"), (other, "half"))]
                data = write_exr(parts)
                self.add("EXR parts", data, "exr", exr_picture(data, "RGB"), meaning, warns=("2 parts",))

    def contents(self):
        """Adds normals that need repair or care: invalid, short, black, below the horizon, or flat."""
        def add(picture, meaning, warns=(), options=(), name="contents", tolerance=1e-5):
            kind = "float" if picture.kind == "float" else "uint"
            data = self.exr_file(picture, "RGB", compression=3) if kind == "float" else self.png(picture, 2)
            decoded = exr_picture(data, "RGB") if kind == "float" else read_png(data)
            self.add(name, data, "exr" if kind == "float" else "png", decoded, meaning, options, warns,
                     tolerance=tolerance)

        def broken(values, **keys):
            picture, meaning = self.normals("float", 32, ((33, 17),), True)
            for texel, vector in zip(self.random.sample(range(33 * 17), len(values)), values):
                picture.samples[3 * texel:3 * texel + 3] = vector
            return picture, Meaning(is_signed=True, **keys)

        for values in (((NAN, 0, 1), (0, INF, 1), (0, 0, -INF)), ((1e10, 0, 1), (0, 0, 1e30)), ((0, 0, 0), (0, 0, 0)),
                       ((0.5, 0.5, -0.7), (0, 0, -1), (-1, 0, 0), (0, 1, 0.0001)), ((NAN, NAN, NAN),),
                       ((100, 20, 300), (3e5, 0, 1e6))):
            add(*broken(values))
        add(*broken(((NAN, 0, 1), (0, INF, 1)), fixnan="black"), options=("--fixnan", "black"))
        picture, meaning = broken(((NAN, 0, 1),))  # two neighbouring texels in the corner
        picture.samples[0:6] = [NAN] * 6
        add(picture, meaning)
        for bits in (8, 16):
            picture, meaning = self.normals("uint", bits, ((33, 17),))
            for texel, code in zip(self.random.sample(range(33 * 17), 4), (0, 4, 0, 3)):
                picture.samples[3 * texel:3 * texel + 3] = [code * (257 if bits == 16 else 1)] * 3
            add(picture, meaning)
            picture, meaning = self.normals("uint", bits, ((33, 17),))
            for texel in self.random.sample(range(33 * 17), 4):
                picture.samples[3 * texel:3 * texel + 3] = [2**(bits - 1), 2**(bits - 1) - 1, 2**(bits - 1)]
            add(picture, meaning)
            picture, meaning = self.normals("uint", bits, ((33, 17),))
            for texel in self.random.sample(range(33 * 17), 30):  # an atlas
                picture.samples[3 * texel:3 * texel + 3] = [0, 0, 0]
            add(picture, meaning, ("black",))
        for bits, factor in ((32, 0.01), (16, 0.01), (32, 1e-4), (32, 100.0), (32, 0.3)):
            picture, meaning = self.normals("float", bits, LARGE, True)
            picture.samples = [rounded(v * factor, "float", bits) for v in picture.samples]
            add(picture, meaning, ("instead of 1",))
        for kind, bits, is_signed in (("uint", 8, False), ("uint", 16, False), ("float", 32, True),
                                      ("float", 16, False)):
            for flat in ((0.0, 0.0, 1.0), (0.1, -0.05, math.sqrt(1 - 0.0125))):
                width, height = self.size()
                add(picture_of([flat] * (width * height), width, height, kind, bits, is_signed),
                    Meaning(is_signed=is_signed))
        for pair in ((127, 127), (128, 127), (127, 128), (128, 128), (126, 128)):
            add(Picture(5, 7, 3, "uint", 8, [*pair, 255] * 35), Meaning())

    def height_settings(self):
        modes = ("periodic", "clamp", "mirror", "black")
        for i in range(12):
            width, height = self.size(SIZES[:9])
            kind, bits = self.random.choice((("float", 32), ("float", 16), ("uint", 16), ("int", 16)))
            picture = scalar_picture(heights(width, height, self.random), width, height, kind, bits)
            wrap = (modes[i % 4], self.random.choice(modes))
            scale = self.random.choice((0.5, 3.0, -2.0, 10.0))
            data = write_tiff(picture, self.layout(picture, is_planar=False))
            self.add("heights", data, "tif", read_tiff(data), Meaning(height_scale=scale, wrap=wrap),
                     ("--height-scale", str(scale), "--swrap", wrap[0], "--twrap", wrap[1]))
        for value in (NAN, INF, -INF):
            for fixnan in ("box3", "black"):
                picture = scalar_picture(heights(33, 17, self.random), 33, 17, "float", 32)
                for texel in (0, 200, 201):
                    picture.samples[texel] = value
                data = write_tiff(picture, self.layout(picture, is_planar=False))
                self.add("heights", data, "tif", read_tiff(data), Meaning(height_scale=2.0, fixnan=fixnan),
                         ("--height-scale", "2", "--fixnan", fixnan))
        picture = scalar_picture([0.5] * 63, 9, 7, "float", 32)
        data = write_tiff(picture, Layout())
        self.add("heights", data, "tif", read_tiff(data), Meaning(height_scale=1), ("--bumpformat", "height"))
        picture, _ = self.normals("float", 32, ((9, 13),), False)
        self.add("heights", write_tiff(picture, Layout()), "tif", refused=("colours", "expected"),
                 options=("--bumpformat", "height", "--height-scale", "3"))

    def beside(self, width, height, *besides, kind="beside", **keys):
        """Adds a case of ordinary normals with accompanying maps."""
        picture = picture_of(surface(width, height, self.random), width, height, "uint", 16, False)
        data = self.png(picture, 2)
        self.add(kind, data, "png", read_png(data), Meaning(), beside=besides, **keys)

    def colours(self, count, bits, kind="uint"):
        width, height = 9, 13
        largest = 2**bits - 1
        samples = [self.random.randrange(largest + 1) if kind == "uint" else
                   rounded(self.random.uniform(0, 3), kind, bits) for _ in range(width * height * count)]
        return Picture(width, height, count, kind, bits, samples)

    def albedo(self, data, extension, picture, transfer, **keys):
        self.beside(picture.width, picture.height, Beside("--albedo", data, extension, colours_of(picture, transfer)),
                    kind="albedo", **keys)

    def albedos(self):
        def power(exponent):
            return lambda v: v**exponent

        def plain(v):
            return v

        def gamma(exponent):
            return (b"gAMA", struct.pack(">I", round(100000 / exponent)))

        for bits, colour_type, chunks, transfer in (
                (8, 2, [], linear_from_srgb), (16, 2, [], linear_from_srgb), (8, 6, [], linear_from_srgb),
                (8, 0, [], linear_from_srgb), (16, 4, [], linear_from_srgb), (2, 0, [], linear_from_srgb),
                (8, 2, [(b"sRGB", b"\0")], linear_from_srgb), (8, 2, [gamma(2.2)], linear_from_srgb),
                (8, 2, [gamma(2.2), (b"sRGB", b"\0")], linear_from_srgb), (16, 2, [gamma(1.0)], plain),
                (8, 0, [gamma(1.0)], plain), (8, 2, [gamma(1.8)], power(1.8)), (8, 2, [gamma(1.85)], power(1.85)),
                (16, 2, [gamma(1.43)], power(1.43)), (8, 2, [gamma(0.45)], power(0.45)),
                (8, 2, [gamma(2.62)], power(2.62)), (8, 2, [gamma(1.0), (b"sRGB", b"\3")], linear_from_srgb),
                (8, 2, [(b"sRGB", b"\0"), gamma(1.0)], linear_from_srgb), (16, 2, [gamma(1.015)], power(1.015))):
            picture = self.colours({0: 1, 2: 3, 4: 2, 6: 4}[colour_type], bits)
            data = self.png(picture, colour_type, chunks=chunks, interlace=self.random.choice((False, True)))
            self.albedo(data, "png", read_png(data), transfer)
        palette = [[self.random.randrange(256) for _ in range(3)] for _ in range(256)]
        data = self.png(self.colours(1, 8), 3, palette=palette, transparent=bytes(range(100)))
        self.albedo(data, "png", read_png(data), linear_from_srgb)
        for unit in (256, 257):
            words = [palette[i][c] * unit for c in range(3) for i in range(256)]
            data = write_tiff(self.colours(1, 8), Layout(photometric=tiff.PALETTE, colour_map=words, order=">"))
            self.albedo(data, "tif", read_tiff(data), linear_from_srgb)
        for count, kind, bits, transfer in ((3, "uint", 8, linear_from_srgb), (3, "uint", 16, linear_from_srgb),
                                            (1, "uint", 16, linear_from_srgb), (3, "float", 32, plain),
                                            (1, "float", 16, plain), (3, "float", 64, plain)):
            picture = self.colours(count, bits, kind)
            data = write_tiff(picture, self.layout(picture, **({"tile": ()} if bits == 64 else {})))
            self.albedo(data, "tif", read_tiff(data), transfer)
        for bits in (1, 8, 16):
            data = write_tiff(self.colours(1, bits), Layout(photometric=tiff.WHITE_IS_ZERO, rows_per_strip=2))
            self.albedo(data, "tif", read_tiff(data), linear_from_srgb)
        for names in ("RGB", ("c.R", "c.G", "c.B"), "Y"):
            picture = self.colours(len(names), 16, "float")
            picture.samples[5:8] = [-0.5, NAN, INF]
            data = self.exr_file(picture, names)
            self.albedo(data, "exr", exr_picture(data, names), plain)
        picture = self.colours(4, 8)
        for photometric in (tiff.CMYK, tiff.CIELAB):
            cmyk = photometric == tiff.CMYK
            data = write_tiff(picture if cmyk else self.colours(3, 8), Layout(photometric=photometric))
            self.albedo(data, "tif", self.colours(3, 8), plain, refused=("PhotometricInterpretation", "expected"))

    def materials(self):
        for option in ("--roughness", "--gloss"):
            for count, bits, channel in ((1, 8, ""), (3, 8, ""), (3, 16, "B"), (4, 8, "A"), (2, 16, "A"), (1, 1, "")):
                picture = self.colours(count, bits)
                data = self.png(picture, {1: 0, 2: 4, 3: 2, 4: 6}[count])
                place = "RGBA".index(channel) if channel and count > 2 else 1 if count > 1 else 0
                values = [texel[place] for texel in read_png(data).texels(count)]
                self.beside(9, 13, Beside(option, data, "png", [1 - v if option == "--gloss" else v for v in values],
                                          channel), kind="roughness")
            picture = self.colours(1, 8)
            data = write_tiff(picture, Layout(photometric=tiff.WHITE_IS_ZERO, compression=tiff.LZW, predictor=2))
            values = [texel[0] for texel in read_tiff(data).texels()]
            self.beside(9, 13, Beside(option, data, "tif", [1 - v if option == "--gloss" else v for v in values]),
                        kind="roughness")
        for count in (1, 2, 3, 4):
            picture = self.colours(count, 8)
            data = self.png(picture, {1: 0, 2: 4, 3: 2, 4: 6}[count])
            self.beside(9, 13, Beside("--weights", data, "png", read_png(data).texels(count)), kind="weights")
            picture.colours = count
            extra = {1: (), 2: (0,), 3: (0, 0), 4: (0, 0, 0)}[count]
            data = write_tiff(picture, self.layout(picture, photometric=tiff.BLACK_IS_ZERO, extra=extra))
            self.beside(9, 13, Beside("--weights", data, "tif", read_tiff(data).texels(count)), kind="weights")
        data = write_tiff(self.colours(2, 8), Layout(photometric=tiff.WHITE_IS_ZERO, extra=(0,)))
        self.beside(9, 13, Beside("--weights", data, "tif", []), kind="weights", refused=("MinIsWhite", "expected"))
        data = write_tiff(self.colours(2, 16), Layout(photometric=tiff.WHITE_IS_ZERO, extra=(0,)))
        self.beside(9, 13, Beside("--weights", data, "tif", read_tiff(data).texels(2)), kind="weights")

    def lobes(self):
        for i in range(8):
            picture, meaning = self.normals("uint", 16, SIZES[:9])
            data = self.png(picture, 2)
            self.add("lobes", data, "png", read_png(data), meaning, movmf=True, tolerance=2e-4)
        colours = self.colours(3, 8)
        data = self.png(colours, 2)
        beside = Beside("--albedo", data, "png", colours_of(read_png(data), linear_from_srgb))
        self.beside(9, 13, beside, kind="lobes", movmf=True, tolerance=6e-4)
        data = self.png(self.colours(1, 8), 0)
        beside = Beside("--roughness", data, "png", [texel[0] for texel in read_png(data).texels()])
        self.beside(9, 13, beside, kind="lobes", movmf=True, tolerance=2e-4)

    def refusals(self):
        def add(data, extension, *words, **keys):
            self.add("refused", data, extension, refused=words, **keys)

        picture, _ = self.normals(bits=8, sizes=((17, 11),))
        good = self.png(picture, 2)
        for data, extension in ((b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 8\n" + bytes(256), "hdr"),
                                (b"PF\n8 8\n-1.0\n" + bytes(768), "pfm"), (b"BM" + bytes(200), "bmp"),
                                (b"GIF89a" + bytes(100), "gif"), (b"", "png"),
                                (b"P6 8 8 255\n" + bytes(192), "ppm")):
            add(data, extension, "unknown format", "expected")
        add(b"DDS " + bytes(124), "dds", "DDS texture", "expected")
        for share in (0.3, 0.6, 0.95):
            add(good[:int(len(good) * share)], "png", "cut")
        whole = write_tiff(picture, Layout(compression=tiff.DEFLATE))
        for share in (0.5, 0.98):
            add(whole[:int(len(whole) * share)], "tif", "damaged")
        exr = self.exr_file(self.normals("float", 32, ((17, 11),), True)[0], "RGB", compression=3)
        for share, word in ((0.1, "cut"), (0.6, "damaged"), (0.9, "damaged")):
            add(exr[:int(len(exr) * share)], "exr", word)
        damaged = bytearray(good)
        damaged[good.index(b"IDAT") + 12] ^= 255
        add(bytes(damaged), "png", "damaged")
        mask = Picture(9, 13, 1, "uint", 1, [self.random.randrange(2) for _ in range(9 * 13)])
        add(self.png(mask, 0), "png", "mask", "expected")
        add(self.png(Picture(9, 13, 1, "uint", 8, [7] * 9 * 13), 0), "png", "holds no information", "expected")
        colours = Picture(33, 17, 3, "uint", 8, [self.random.randrange(256) for _ in range(33 * 17 * 3)])
        add(self.png(colours, 2), "png", "neither a normal map nor", "expected")
        blue = Picture(33, 17, 3, "uint", 8, [v + self.random.randrange(3) for _ in range(33 * 17)
                                              for v in (135, 206, 235)])
        add(self.png(blue, 2), "png", "neither a normal map nor", "expected")
        sides = [v for _ in range(33 * 17) for v in (self.random.randrange(256), self.random.randrange(256), 0)]
        add(self.png(Picture(33, 17, 3, "uint", 8, sides), 2), "png", "neither a normal map nor", "expected")
        moved = self.with_alpha(picture)
        moved.samples[0::4] = [255] * (17 * 11)
        add(self.png(moved, 6), "png", "DXT5nm", "expected")
        nan, _ = self.normals("float", 32, ((33, 17),), True)
        nan.samples[3 * 33 + 6] = NAN
        data = self.exr_file(nan, "RGB")
        add(data, "exr", "NaN", "column 2, row 1", "expected", options=("--checknan",))
        add(data, "exr", "NaN", "column 2, row 1", "expected", options=("--fixnan", "none"))
        nan.samples[0:21] = [INF] * 21  # NaN in all channels would mean that a texel was never written
        add(self.exr_file(nan, "RGB"), "exr", "8 of 561", "expected")
        black, _ = self.normals(sizes=((33, 17),))
        black.samples[:3 * 300] = [0] * 900
        add(self.png(black, 2), "png", "300 of 561", "black", "expected")
        grey = scalar_picture(heights(9, 13, self.random), 9, 13, "uint", 8)
        add(self.png(grey, 0), "png", "1 colour channel", options=("--two-channel",))
        add(self.png(grey, 0), "png", "1 colour channel", options=("--bumpformat", "normal"))
        short, _ = self.normals("float", 32, ((33, 17),), True)
        short.samples = [v * self.random.choice((0.1, 0.3)) for v in short.samples]
        add(self.exr_file(short, "RGB"), "exr", "expected")
        for option, beside, words in (
                ("--albedo", self.png(self.colours(3, 8), 2), ("9 x 13", "17 x 11")),
                ("--roughness", self.png(self.colours(1, 8), 0), ("9 x 13", "17 x 11")),
                ("--weights", self.png(self.colours(1, 8), 0), ("9 x 13", "17 x 11"))):
            add(good, "png", "expected", *words, beside=(Beside(option, beside, "png", []),))
        two = Picture(17, 11, 2, "float", 32, [0.25] * 17 * 11 * 2)
        data = write_tiff(two, Layout(photometric=tiff.BLACK_IS_ZERO, extra=(0,)))
        add(good, "png", "2 colour channels", "expected", beside=(Beside("--albedo", data, "tif", []),))
        for value in (1.5, -0.1, NAN):
            rough = Picture(17, 11, 1, "float", 32, [0.25] * 17 * 11)
            rough.samples[20] = value
            add(good, "png", "texel (3, 1)", "expected",
                beside=(Beside("--roughness", write_tiff(rough, Layout()), "tif", []),))
        five = Picture(17, 11, 5, "uint", 8, [9] * 17 * 11 * 5)
        add(good, "png", "5 channels", "expected",
            beside=(Beside("--weights", write_tiff(five, Layout(photometric=1, extra=(0,) * 4)), "tif", []),))
        bright = Picture(17, 11, 3, "float", 32, [1e6] * 17 * 11 * 3)
        add(good, "png", "expected", beside=(Beside("--albedo", write_tiff(bright, Layout()), "tif", []),),
            options=("-d", "half"))


def generated(random):
    """Returns all cases. Equal seeds give equal bytes."""
    return Generator(random).cases
