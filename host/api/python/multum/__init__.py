# SPDX-License-Identifier: Apache-2.0
"""Bakes, reads and shades textures that look right at every distance.

>>> import numpy, multum
>>> slope = 0.5 * numpy.sin(numpy.arange(64) * 2 * numpy.pi / 16)
>>> normals = numpy.stack([-slope, 0 * slope, 1 + 0 * slope], axis=-1) / numpy.sqrt(1 + slope**2)[:, None]
>>> baked = multum.bake(numpy.broadcast_to(normals.astype("float32"), (64, 64, 3)), lobes=4)
>>> baked.lobes(3).shape          # lobes, rows, columns, (a r_x, a r_y, a r_z, a)
(4, 8, 8, 4)

Names of settings are those of the command line with underscores: `multum bake --target-error 0.05` is
`multum.bake(file, target_error=0.05)`. `multum.settings("bake")` lists them.
"""

from ._api import (BakedMap, Brdf, Lobes, Setting, bake, devices, export, gltf, load, measure, settings)
from ._errors import Cancelled, Error, InputError, MachineError, ServiceError, SettingError, VerificationError
from ._fields import Field, infer, pack
from ._multum import __version__
from .service import Job, Service

__all__ = [
    "BakedMap", "Brdf", "Cancelled", "Error", "Field", "InputError", "Job", "Lobes", "MachineError", "Service",
    "ServiceError", "Setting", "SettingError", "VerificationError", "__version__", "bake", "devices", "export", "gltf",
    "infer", "load", "measure", "pack", "settings"
]
