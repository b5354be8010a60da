# SPDX-License-Identifier: Apache-2.0
"""Fields: textures that are inferred from ray-traced pictures over parameters (Hakura et al. 2000)."""
from __future__ import annotations

import json
import os
from typing import Any, Optional, Sequence, Union

import numpy as np

from . import _multum
from ._api import PathLike, Progress, _device, _Listener, _values
from ._errors import SettingError


def infer(job: PathLike, output: PathLike, *, device: Union[str, int] = "", progress: Progress = None,
          **settings: Any) -> dict:
    """Infers the textures of a job file, as `multum infer` does (docs/reference/animation_jobs.md).

    job       job file, *.toml
    output    folder for textures, manifest and report
    settings  see multum.settings("infer")

    Returns the report: "objects", "frames", "textures" and more. Draws frames with the program multum-view.
    """
    with _Listener(progress, "infer") as listener:
        text = _multum.infer(_device(device), os.fsencode(job), _values("infer", settings), os.fsencode(output),
                             listener.progress, listener.log)
    return json.loads(text)


def pack(folder: PathLike, output: PathLike, *, device: Union[str, int] = "", progress: Progress = None,
         **settings: Any) -> dict:
    """Compresses the folder that infer() wrote into one file, *.mpt, as `multum pack` does.

    settings  see multum.settings("pack")

    Returns the report: "bytes", "raw_bytes", "mse_added", "chunks" and more.
    """
    with _Listener(progress, "pack") as listener:
        text = _multum.pack(_device(device), os.fsencode(folder), _values("pack", settings), os.fsencode(output),
                            listener.progress, listener.log)
    return json.loads(text)


class Field:
    """A packed field. A point is a sequence with one number per parameter: an index along the parameter's samples.

    >>> field = Field("room.mpt")                                   # doctest: +SKIP
    >>> field.parameters, field.sizes                               # doctest: +SKIP
    (['view', 'light'], [8, 8])
    >>> field.frame([3.5, 2], linear=True).shape                    # doctest: +SKIP
    (240, 320, 4)
    """

    def __init__(self, path: PathLike):
        self._path = os.fsencode(path)
        self._field = _multum.Field(self._path)
        self._facts = json.loads(self._field.text())

    parameters = property(lambda self: self._facts["parameters"], doc="names of the parameters")
    sizes = property(lambda self: self._facts["sizes"], doc="number of samples along each parameter")
    width = property(lambda self: self._facts["width"], doc="pixels of a frame")
    height = property(lambda self: self._facts["height"], doc="pixels of a frame")
    objects = property(lambda self: self._facts["objects"], doc="names of the objects")
    layers = property(lambda self: self._facts["layers"], doc="object and name of each layer")
    bytes = property(lambda self: self._facts["bytes"], doc="size of the file")

    def __repr__(self) -> str:
        return f"<Field {os.fsdecode(self._path)}, {self.width} x {self.height}, {self.parameters} {self.sizes}>"

    def _points(self, points: Any) -> np.ndarray:
        array = np.ascontiguousarray(points, dtype=np.float64)
        if array.ndim != 2 or array.shape[1] != len(self.parameters) or array.shape[0] < 1:
            expected = f"one number for each of {', '.join(self.parameters)}"
            raise SettingError(f"point: shape is {np.shape(points)}, expected {expected}", "", str(np.shape(points)),
                               expected)
        return array

    def texture(self, layer: int, point: Sequence[float]) -> Optional[np.ndarray]:
        """Decodes the texture of a layer at the nearest sample of a point.

        layer  index of an entry of `layers`

        Returns linear radiance, float32 (rows, columns, 3), or None if the layer is invisible there.
        """
        return self._field.texture(layer, self._points([point])[0])

    def frames(self, points: Any, *, linear: bool = False, progress: Progress = None) -> np.ndarray:
        """Draws a frame for each point, with the program multum-view.

        points  (frames, parameters)
        linear  True interpolates textures linearly between samples; False takes those of the nearest sample. Cameras
                and objects move continuously in both cases.

        Returns linear radiance and the share of each pixel that objects cover, float32 (frames, height, width, 4).
        """
        with _Listener(progress, "play") as listener:
            return self._field.play(self._points(points), self.width, self.height, linear, listener.progress,
                                    listener.log)

    def frame(self, point: Sequence[float], *, linear: bool = False) -> np.ndarray:
        """Draws one frame, float32 (height, width, 4), like frames()."""
        return self.frames([point], linear=linear)[0]

    def publish(self, output: PathLike) -> None:
        """Writes the player for browsers: a folder for a static web server, or a single page, *.html."""
        _multum.publish_field(self._path, os.fsencode(output))
