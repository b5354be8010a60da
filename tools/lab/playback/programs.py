# SPDX-License-Identifier: Apache-2.0
"""Runs multum and multum-view on a field to infer textures, pack, unpack and draw frames, and measures each run."""
import pathlib
import re
import shutil
import sys
import tempfile

import numpy as np
from fields import eight_bit, read_channels
from measured_run import run, succeed

USAGE = 2  # the exit code of a wrong command line
SAMPLES_A_RUN = 64  # number of samples that one run of multum-view draws


class Programs:
    def __init__(self, folder, context="auto"):
        self.multum, self.viewer = pathlib.Path(folder) / "multum", pathlib.Path(folder) / "multum-view"
        self.context = context
        self.pack_help = succeed([self.multum, "pack", "--help"]).text

    def version(self):
        return succeed([self.multum, "--version"]).text.strip()

    def devices(self):
        lines = succeed([self.multum, "devices"]).text.splitlines()
        return re.sub(r"^\d+\s+|\s+\(.*", "", lines[0]) if lines else "no device"

    def job(self, folder, path):
        succeed([self.multum, "animation", folder, "-o", path])

    def infer(self, job, output, options=()):
        return succeed([self.multum, "infer", job, "-o", output, "--no-frames", "--no-comparison", "--context",
                        self.context, *options])

    def unknown_option(self, options):
        """Returns the first option that `multum pack` does not know, or None if it knows all."""
        return next((one for one in options
                     if one.startswith("--") and not re.search(rf"(?<![\w-]){one}(?![\w-])", self.pack_help)), None)

    def pack(self, folder, file, options):
        """Packs textures. The exit code is USAGE if a size cannot be reached or an option's value is invalid."""
        done = run([self.multum, "pack", folder, "-o", file, "--quiet", *options])
        if done.code not in (0, USAGE):
            sys.exit(f"exit code {done.code} of multum pack {' '.join(map(str, options))}\n{done.text}")
        return done

    def drawn_frames(self, folder, field):
        """Returns uint8 [frame, height, width, 3] of all samples."""
        white, frames = field.job.get("radiance_max", 1), []
        for begin in range(0, len(field.samples), SAMPLES_A_RUN):
            with tempfile.TemporaryDirectory() as pictures:
                names = [one.get("name", "_".join(map(str, one["at"])))
                         for one in field.samples[begin:begin + SAMPLES_A_RUN]]
                files = [f"{pictures}/{number}.exr" for number in range(len(names))]
                succeed([self.viewer, "sample", folder, "--context", self.context,
                         *[word for name, file in zip(names, files) for word in ("--at", name, "-o", file)]])
                frames += [eight_bit(read_channels(file, "RGB")[0] / white) for file in files]
        return np.stack(frames)

    def unpacked_frames(self, file, field, scratch):
        """Draws a packed field. `scratch` is a folder that is emptied before and after. It must not be the file's own
        folder."""
        shutil.rmtree(scratch, ignore_errors=True)
        succeed([self.multum, "unpack", file, "-o", scratch, "--quiet"])
        frames = self.drawn_frames(scratch, field)
        shutil.rmtree(scratch)
        return frames
