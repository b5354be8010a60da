# SPDX-License-Identifier: Apache-2.0
"""The functions and classes of the package, over the module _multum (host/api/python/multum_module.cpp)."""
from __future__ import annotations

import functools
import json
import os
import warnings
from typing import Any, Callable, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _multum
from ._errors import MachineError, SettingError

PathLike = Union[str, "os.PathLike[str]"]
Image = Union[PathLike, np.ndarray]
Progress = Union[bool, Callable[[str, float], Any], None]

_PARTS = {"lobes": 0, "colours": 1, "weights": 2, "slopes": 3, "mean_normals": 4, "harmonics": 5}
_TYPES = {"float32": 3, "float16": 2, "int16": 4}
_MAPS = ("albedo", "roughness", "weights")


class Setting(NamedTuple):
    """A setting of a command: its name, its effect, and its legal values with the default."""
    name: str
    help: str
    values: str


def settings(command: str) -> "list[Setting]":
    """Lists the settings of "bake", "export", "gltf", "infer" or "pack".

    >>> [s for s in settings("bake") if s.name == "lobes"][0].values
    'an integer from 1 to 8, default 4'
    """
    return [Setting(*row) for row in _multum.parameters(command)]


def devices() -> "list[Tuple[int, str, str]]":
    """Lists the OpenCL devices: (index, name, platform). The argument `device` takes an index or a part of a name."""
    return _multum.devices()


def _device(selector: Union[str, int]) -> "_multum.Device":
    return _opened_device(str(selector))


@functools.lru_cache(maxsize=None)
def _opened_device(selector: str) -> "_multum.Device":
    try:
        return _multum.Device(selector)
    except MachineError as error:
        # PoCL with LLVM 18 terminates the process on some processors unless this variable is set. libmultum does not
        # change the environment of its host, but a script has no better place to set the variable than here.
        name, _, value = error.expected.partition(" ")[0].partition("=")
        if name != "POCL_WORK_GROUP_METHOD" or name in os.environ:
            raise
        os.environ[name] = value
        return _multum.Device(selector)


def _array(values: np.ndarray, name: str) -> np.ndarray:
    """Returns (height, width, channels) with pixels contiguous within a row; copies only other layouts."""
    array = np.asarray(values)
    if array.ndim == 2:
        array = array[:, :, None]
    if array.ndim != 3 or not 1 <= array.shape[2] <= 4:
        expected = "(height, width) or (height, width, channels) with 1 to 4 channels"
        raise SettingError(f"{name}: shape is {np.shape(values)}, expected {expected}", name, str(np.shape(values)),
                           expected)
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    if array.dtype == np.float64:
        array = array.astype(np.float32)
    if array.dtype not in (np.uint8, np.uint16, np.float16, np.float32):
        expected = "uint8, uint16, float16, float32 or float64"
        raise SettingError(f"{name}: type is {array.dtype}, expected {expected}", name, str(array.dtype), expected)
    is_plain = array.strides[2] == array.itemsize and array.strides[1] == array.itemsize * array.shape[2]
    if not is_plain or abs(array.strides[0]) < array.strides[1] * array.shape[1]:
        array = np.ascontiguousarray(array)
    return array


def _maps(normals: Image, others: "dict[str, Any]") -> "_multum.Maps":
    """Takes the arrays out of `others`; files stay there as settings."""
    images = {}
    path: Union[str, bytes] = ""
    if isinstance(normals, np.ndarray):
        images["normals"] = _array(normals, "normals")
    else:
        path = os.fsencode(normals)
    for name in _MAPS:
        if isinstance(others.get(name), np.ndarray):
            images[name] = _array(others.pop(name), name)
    return _multum.Maps(path, images)


def _values(command: str, given: "dict[str, Any]") -> "_multum.Values":
    plain = {}
    for name, value in given.items():
        if isinstance(value, np.generic):
            value = value.item()
        elif isinstance(value, os.PathLike):
            value = os.fspath(value)
        if not isinstance(value, (bool, int, float, str, type(None))):
            raise SettingError(f"{name} is {value!r}, expected a number, a text or True or False", "", repr(value),
                               "a number, a text or True or False")
        plain[name.removesuffix("_")] = value  # for_="unreal", because `for` is a keyword
    return _multum.Values(command, plain)


class _Listener:
    """Shows the progress of one call, and turns its warnings into Python's."""

    def __init__(self, progress: Progress, subject: str):
        self._bar = None
        self._function = progress if callable(progress) else None
        if progress is True:
            from tqdm import tqdm  # only for progress=True
            self._bar = tqdm(total=1.0, desc=subject, bar_format="{desc}: {percentage:3.0f}%|{bar}| {postfix}")

    def progress(self, stage: str, share: float) -> None:
        if self._bar is not None and share >= 0:
            self._bar.set_postfix_str(stage, refresh=False)
            self._bar.update(share - self._bar.n)
        if self._function is not None and self._function(stage, share) is False:
            from ._errors import Cancelled
            raise Cancelled("cancelled; no unfinished files remain")

    @staticmethod
    def log(kind: int, message: str) -> None:
        if kind == 0:
            warnings.warn(message, stacklevel=4)

    def __enter__(self) -> "_Listener":
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()


def bake(normals: Image, output: Optional[PathLike] = None, *, device: Union[str, int] = "", progress: Progress = None,
         **settings: Any) -> "BakedMap":
    """Bakes a normal map or a height field into mipmaps of distributions of normals.

    normals   a file; or an array (height, width, channels) of uint8, uint16, float16 or float32 with the meaning of a
              file: unsigned integers are normals scaled to 0..1, floats are vectors or 0..1 (detected; `bump_format`,
              `signed` and `green` decide). The first row is the top of the image.
    output    *.ndf.exr; None keeps the result in a temporary file, which `save` copies
    device    index or part of the name of an OpenCL device; "" takes the first GPU, or else the first CPU
    progress  True shows a bar (tqdm); a function gets (stage, share), with a share below 0 while it is unknown, and
              cancels the bake if it returns False. Ctrl-C cancels too.
    settings  see multum.settings("bake"); `albedo`, `roughness` and `weights` take arrays as well as files

    Returns a BakedMap. Raises SettingError, InputError, MachineError, VerificationError, Cancelled. Warnings of the
    bake are warnings of Python. An unfinished file never remains.
    """
    maps = _maps(normals, settings)
    with _Listener(progress, str(normals) if isinstance(normals, (str, os.PathLike)) else "bake") as listener:
        made = _multum.bake(_device(device), maps, _values("bake", settings),
                            "" if output is None else os.fsencode(output), listener.progress, listener.log)
    return BakedMap(made)


def load(path: PathLike) -> "BakedMap":
    """Opens a baked file. Reads only its header; levels are read when they are first used. Needs no OpenCL."""
    return BakedMap(_multum.open_map(os.fsencode(path)))


def export(normals: Image, output: PathLike, *, device: Union[str, int] = "", progress: Progress = None,
           **settings: Any) -> dict:
    """Exports a map as a material of one lobe per texel that engines load, as `multum export` does.

    normals   a file (a map or a baked file) or an array, as for bake()
    output    a folder, or NAME.ktx2 or NAME.dds
    settings  see multum.settings("export"); `roughness` takes an array as well as a file, and `for_` is the setting
              `for`, which is a keyword of Python: export("rock.png", "rock.dds", for_="unreal")

    Returns the report of the export: "files", the errors of each level, and more.
    """
    maps = _maps(normals, settings)
    with _Listener(progress, "export") as listener:
        text = _multum.export_map(_device(device), maps, _values("export", settings), os.fsencode(output),
                                  listener.progress, listener.log)
    return json.loads(text)


def gltf(model: PathLike, output: PathLike, *, device: Union[str, int] = "", progress: Progress = None,
         **settings: Any) -> dict:
    """Writes a copy of a glTF model whose normal and roughness textures have fitted mips, as `multum gltf` does.

    model     *.glb, or *.gltf with its files
    output    *.glb
    settings  see multum.settings("gltf")

    Returns the report: "materials", "textures" and more.
    """
    with _Listener(progress, "gltf") as listener:
        text = _multum.convert_model(_device(device), os.fsencode(model), _values("gltf", settings),
                                     os.fsencode(output), listener.progress, listener.log)
    return json.loads(text)


def measure(baked: PathLike, normals: Image, *, device: Union[str, int] = "", progress: Progress = None,
            **settings: Any) -> list:
    """Measures the error of a baked file against the maps that it was baked from.

    settings  those of the bake

    Returns rows like BakedMap.error(). Raises VerificationError if the file is damaged.
    """
    maps = _maps(normals, settings)
    with _Listener(progress, "measure") as listener:
        text = _multum.measure(_device(device), os.fsencode(baked), maps, _values("bake", settings), listener.progress,
                               listener.log)
    return _error_rows(text)


class ErrorRow(NamedTuple):
    """A measured error of a baked file (docs/evidence/ACCURACY.md).

    level     level of the mipmap; -1 for the error of whole pixels
    point     "pixels"; or the place within a level: at a texel, between texels, between levels
    brdf      such as "blinn-phong:100"
    error     relative L1, 0.1 = 10 %
    interval  half width of the 95 % interval; None if the file does not state it
    """
    level: int
    point: str
    brdf: str
    error: float
    interval: Optional[float]


def _error_rows(text: str) -> "list[ErrorRow]":
    rows = json.loads(text) if text else []
    return [ErrorRow(row[0], row[1], row[2], row[3], row[4] if len(row) > 4 else None) for row in rows]


class Brdf:
    """A BRDF for shading: "lambert", "blinn-phong:100", "ggx:0.4" (roughness), "ggx:0.4,0.04" (roughness, F0), ..."""

    def __init__(self, text: str):
        self.text = text
        self._brdf = _multum.Brdf(text)

    def __repr__(self) -> str:
        return f"Brdf({self.text!r})"


def _brdf(brdf: Union[str, Brdf]) -> Brdf:
    return brdf if isinstance(brdf, Brdf) else Brdf(brdf)


def _rows(values: Any, shape: "Tuple[int, ...]", width: int) -> np.ndarray:
    wide = np.broadcast_to(np.asarray(values, dtype=np.float64), shape + (width,))
    return np.ascontiguousarray(wide).reshape(-1, width)


class Lobes:
    """Lobes at one or many points: mixtures of von Mises-Fisher distributions (Han et al. 2007, section 7).

    values   float32 (..., lobes, 4): (a r_x, a r_y, a r_z, a), amplitude a and mean vector r of the normals
    colours  float32 (..., lobes, 3): a times linear RGB; None if the map has no colours
    mean_cosine  0; or the mean cosine of the roughness that the lobes contain, if the map was baked with roughness

    Directions are unit vectors in tangent space, (..., 3): +X right, +Y towards the first row of the image, +Z out.
    Arguments broadcast against the points.
    """

    def __init__(self, values: np.ndarray, colours: Optional[np.ndarray] = None, mean_cosine: float = 0.0):
        self.mean_cosine = mean_cosine
        self.values = np.asarray(values, dtype=np.float32)
        self.colours = None if colours is None else np.asarray(colours, dtype=np.float32)

    @property
    def shape(self) -> "Tuple[int, ...]":
        """Shape of the points."""
        return self.values.shape[:-2]

    @property
    def amplitude(self) -> np.ndarray:
        """(..., lobes)"""
        return self.values[..., 3]

    @property
    def mean_direction(self) -> np.ndarray:
        """Unit vectors (..., lobes, 3)"""
        r = self.values[..., :3]
        length = np.linalg.norm(r, axis=-1, keepdims=True)
        return np.where(length > 1e-12, r / np.maximum(length, 1e-12), [0.0, 0.0, 1.0])

    @property
    def kappa(self) -> np.ndarray:
        """Concentration (..., lobes), by the approximation of Banerjee et al. 2005: |r| (3 - |r|^2) / (1 - |r|^2)"""
        a = np.maximum(self.amplitude.astype(np.float64), 1e-12)
        r = np.minimum(np.linalg.norm(self.values[..., :3].astype(np.float64), axis=-1) / a, 1.0 - 1e-9)
        return r * (3.0 - r * r) / (1.0 - r * r)

    def _at(self, *arguments: Any) -> "Tuple[Tuple[int, ...], Any]":
        shape = np.broadcast_shapes(self.shape, *[np.shape(a)[:-1] for a in arguments])
        lobes = self.values.shape[-2]
        values = np.broadcast_to(self.values, shape + (lobes, 4)).reshape(-1, lobes, 4)
        if self.colours is None:
            colours = np.zeros(0, np.float32)
        else:
            colours = np.broadcast_to(self.colours, shape + (lobes, 3)).reshape(-1, lobes, 3)
        return shape, _multum.LobeRows(values, colours, self.mean_cosine)

    def shade(self, light: Any, view: Any, brdf: Union[str, Brdf]) -> np.ndarray:
        """Returns the reflected light in linear RGB, (..., 3): BRDF * max(n . light, 0), integrated over the normals n.

        >>> up = [0.0, 0.0, 1.0]
        >>> flat = Lobes([[0.0, 0.0, 1.0, 1.0]])
        >>> flat.shade(up, up, "lambert").round(4).tolist()     # albedo 0.5 / pi
        [0.1592, 0.1592, 0.1592]
        """
        shape, rows = self._at(light, view)
        rgb = _multum.shade(rows, _brdf(brdf)._brdf, _rows(light, shape, 3), _rows(view, shape, 3))
        return rgb.reshape(shape + (3,))

    def density(self, normal: Any) -> np.ndarray:
        """Returns the density of normals per steradian, (...)."""
        shape, rows = self._at(normal)
        return _multum.density(rows, _rows(normal, shape, 3)).reshape(shape)

    def sample(self, view: Any, random: Any, brdf: Union[str, Brdf]) -> "Tuple[np.ndarray, np.ndarray]":
        """Draws light directions in proportion to an approximation of shade().

        random  numbers in [0, 1), (..., 3)

        Returns the directions (..., 3), some of which may point below the horizon, and their densities per steradian
        (...). A density of 0 means that nothing can be sampled.
        """
        shape, rows = self._at(view, random)
        light, pdf = _multum.sample(rows, _brdf(brdf)._brdf, _rows(view, shape, 3), _rows(random, shape, 3))
        return light.reshape(shape + (3,)), pdf.reshape(shape)

    def pdf(self, view: Any, light: Any, brdf: Union[str, Brdf]) -> np.ndarray:
        """Returns the densities with which sample() draws `light`, (...)."""
        shape, rows = self._at(view, light)
        return _multum.pdf(rows, _brdf(brdf)._brdf, _rows(view, shape, 3), _rows(light, shape, 3)).reshape(shape)


class BakedMap:
    """A baked mipmap of distributions of normals. Level 0 is the finest, and its first row is the top of the image."""

    def __init__(self, made: "_multum.Map"):
        self._map = made
        self._info = made.info()

    width = property(lambda self: self._info["width"], doc="texels of level 0")
    height = property(lambda self: self._info["height"], doc="texels of level 0")
    level_count = property(lambda self: self._info["level_count"], doc="number of levels, down to 1 x 1")
    first_level = property(lambda self: self._info["first_level"], doc="the finest stored level")
    lobe_count = property(lambda self: self._info["lobe_count"], doc="lobes per texel; 0 for other representations")
    sh_order = property(lambda self: self._info["sh_order"], doc="order of spherical harmonics; 0 for others")
    has_colours = property(lambda self: self._info["has_colours"], doc="True if the map was baked with an albedo")
    weight_count = property(lambda self: self._info["weight_count"], doc="weights of basis BRDFs, 0 to 4")
    repeats = property(lambda self: self._info["repeats"], doc="(True, True) if the map repeats along u and v")
    representation = property(lambda self: self._map.text("representation"), doc="vmf, gmm, moments or sh")
    encoding = property(lambda self: self._map.text("encoding"), doc="snorm16, half or float")
    content_hash = property(lambda self: self._map.text("content_hash"), doc="SHA-256 of all texels")
    source_name = property(lambda self: self._map.text("source_name"), doc="name of the baked file or array")

    def __repr__(self) -> str:
        return (f"<BakedMap {self.representation} of {self.source_name}, {self.width} x {self.height}, "
                f"levels {self.first_level} to {self.level_count - 1}>")

    def settings(self) -> dict:
        """Returns the settings that the file was baked with."""
        return json.loads(self._map.text("settings") or "{}")

    def report(self) -> dict:
        """Returns the report of the bake; empty for a file that was only opened."""
        return json.loads(self._map.text("report") or "{}")

    def error(self) -> "list[ErrorRow]":
        """Returns the errors that the bake measured."""
        return _error_rows(self._map.text("measured_error"))

    def lobes(self, level: int) -> np.ndarray:
        """Returns the lobes of a level, float32 (lobes, rows, columns, 4): (a r_x, a r_y, a r_z, a).

        Like the other parts, the array is a read-only view of the map's memory, without a copy. It keeps the map alive.
        """
        return self._map.level(level, 0)

    def colours(self, level: int) -> np.ndarray:
        """Returns linear RGB, float32 (layers, rows, columns, 3); lobes have a layer each, multiplied by a."""
        return self._map.level(level, 1)

    def weights(self, level: int) -> np.ndarray:
        """Returns weights of basis BRDFs, float32 (layers, rows, columns, weight_count), layers as for colours."""
        return self._map.level(level, 2)

    def slopes(self, level: int) -> np.ndarray:
        """Returns moments of slopes, float32 (1, rows, columns, 6): height, E[s], E[t], E[s^2], E[t^2], E[s t]."""
        return self._map.level(level, 3)

    def mean_normals(self, level: int) -> np.ndarray:
        """Returns mean normals of files of moments, float32 (1, rows, columns, 3)."""
        return self._map.level(level, 4)

    def harmonics(self, level: int) -> np.ndarray:
        """Returns coefficients of spherical harmonics in groups of four, float32 (groups, rows, columns, 4)."""
        return self._map.level(level, 5)

    def read(self, level: int, region: "Tuple[int, int, int, int]", part: str = "lobes",
             dtype: Any = "float32") -> np.ndarray:
        """Reads (x, y, width, height) of a level without keeping the level, and decodes only the needed rows of tiles.

        part   lobes, colours, weights, slopes, mean_normals or harmonics
        dtype  float32; float16; or int16 for lobes of encoding snorm16 (the value times 32767, as stored)
        """
        name = np.dtype(dtype).name
        if part not in _PARTS or name not in _TYPES:
            what, found, legal = ("part", part, _PARTS) if part not in _PARTS else ("dtype", name, _TYPES)
            raise SettingError(f"{what} is {found}, expected {', '.join(legal)}", "", str(found), ", ".join(legal))
        return self._map.read(level, _PARTS[part], *region, _TYPES[name])

    def lookup(self, u: Any, v: Any, level: Any) -> Lobes:
        """Filters lobes at texture coordinates linearly in and between levels, as graphics hardware does.

        u, v   texture coordinates, broadcast together; v = 0 is the top of the image
        level  level of detail, clamped to the stored levels
        """
        places = np.broadcast_arrays(*[np.asarray(a, dtype=np.float64) for a in (u, v, level)])
        lobes, colours, mean_cosine = _multum.look_up(self._map, np.stack([p.ravel() for p in places], axis=-1))
        shape = places[0].shape
        return Lobes(lobes.reshape(shape + lobes.shape[1:]),
                     colours.reshape(shape + colours.shape[1:]) if self.has_colours else None, mean_cosine)

    def shade(self, u: Any, v: Any, level: Any, light: Any, view: Any, brdf: Union[str, Brdf]) -> np.ndarray:
        """Returns lookup(u, v, level).shade(light, view, brdf)."""
        return self.lookup(u, v, level).shade(light, view, brdf)

    def render_plane(self, brdf: Union[str, Brdf], *, eye: Sequence[float] = (0.5, -0.7, 0.7),
                     target: Sequence[float] = (0.5, 0.5, 0.0), light: Sequence[float] = (0.0, 0.0, 1.0),
                     fov: float = 40.0, size: "Tuple[int, int]" = (256, 256), taps: int = 4,
                     device: Union[str, int] = "", progress: Progress = None) -> np.ndarray:
        """Draws a plane that is covered with the map, on an OpenCL device.

        The plane is z = 0. One tile of the map covers 0 <= x <= 1 and 0 <= y <= 1, with the first row at y = 1.

        eye, target  place of the camera, above the plane, and the point in the middle of the picture
        light        direction of any length to a distant light, which has irradiance 1 on a surface that faces it
        fov          vertical angle of view in degrees
        size         width and height in pixels
        taps         largest number of lookups per pixel, along the longer side of its footprint

        Returns float32 (height, width, 4): linear RGB, and 1 where the plane is visible.
        """
        to_light = np.asarray(light, dtype=np.float64)
        vectors = np.array([eye, target, to_light / max(float(np.linalg.norm(to_light)), 1e-300)], dtype=np.float64)
        with _Listener(progress, "render_plane") as listener:
            return _multum.render_plane(_device(device), self._map, _brdf(brdf)._brdf, vectors, fov, size[0], size[1],
                                        taps, listener.progress, listener.log)

    def save(self, path: PathLike) -> None:
        """Writes the map to a file, which appears complete or not at all."""
        self._map.save(os.fsencode(path))
