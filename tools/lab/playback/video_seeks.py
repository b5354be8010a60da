# SPDX-License-Identifier: Apache-2.0
"""Measures how long dav1d takes to seek a frame of an AV1 stream, for which it decodes from the previous key frame to
this frame. dav1d runs on one thread of this process, so the time to start a program is not included. Only decoding is
timed, not the conversion of colours. The library fills all structures of libdav1d 1.0, except for the first members of
its settings.
"""
import ctypes
import os
import struct
import subprocess
import sys
import tempfile
import time

import video_codecs

SETTINGS_BYTES, DATA_BYTES, PICTURE_BYTES = 4096, 512, 4096  # at least as large as the structures
AGAIN = -11  # -EAGAIN


def ivf_stream(codec, quality, frames):
    """Returns the units of an AV1 stream as bytes, one per shown frame."""
    count, height, width, _ = frames.shape
    with tempfile.TemporaryDirectory() as folder:
        stream, planes = os.path.join(folder, "stream.ivf"), os.path.join(folder, "planes")
        video_codecs.ycbcr(frames).tofile(planes)
        video_codecs.ffmpeg("-f", "rawvideo", "-pix_fmt", "yuv444p10le", "-s", f"{width}x{height}", "-r", "30", "-i",
                            planes, *codec.options, "-crf", quality, "-color_range", "pc", "-colorspace", "bt709",
                            "-f", "ivf", stream)
        with open(stream, "rb") as file:
            text = file.read()
    units, at = [], struct.unpack_from("<H", text, 6)[0]
    while at < len(text):
        size = struct.unpack_from("<I", text, at)[0]
        units.append(text[at + 12:at + 12 + size])
        at += 12 + size
    if len(units) != count:
        sys.exit(f"{codec.name}: {len(units)} units for {count} frames, expected one per frame")
    return units


class Dav1d:
    def __init__(self):
        self.library = ctypes.CDLL("libdav1d.so.6")
        self.library.dav1d_version.restype = ctypes.c_char_p
        self.library.dav1d_data_create.restype = ctypes.c_void_p
        self.version = self.library.dav1d_version().decode()
        if not self.version.startswith("1."):
            sys.exit(f"libdav1d {self.version}, expected 1.*")

    def decoded(self, units):
        """Decodes units with a new decoder, as after a jump. The time includes the creation of the decoder. Returns
        seconds, processor seconds and the number of shown frames."""
        lib, context = self.library, ctypes.c_void_p()
        settings = (ctypes.c_int * (SETTINGS_BYTES // 4))()
        data, picture = ctypes.create_string_buffer(DATA_BYTES), ctypes.create_string_buffer(PICTURE_BYTES)
        begin, worked, shown = time.perf_counter(), time.process_time(), 0
        lib.dav1d_default_settings(settings)
        settings[0] = settings[1] = 1  # n_threads, max_frame_delay
        if lib.dav1d_open(ctypes.byref(context), settings) != 0:
            sys.exit("dav1d_open failed")
        for unit in units:
            ctypes.memset(data, 0, DATA_BYTES)
            place = lib.dav1d_data_create(data, ctypes.c_size_t(len(unit)))
            ctypes.memmove(place, unit, len(unit))
            if lib.dav1d_send_data(context, data) != 0:
                sys.exit("dav1d_send_data failed")
            while True:
                ctypes.memset(picture, 0, PICTURE_BYTES)
                result = lib.dav1d_get_picture(context, picture)
                if result != 0:
                    break
                shown += 1
                lib.dav1d_picture_unref(picture)
            if result != AGAIN:
                sys.exit(f"dav1d_get_picture failed: {result}")
        lib.dav1d_close(ctypes.byref(context))
        return time.perf_counter() - begin, time.process_time() - worked, shown


class VideoSeeks:
    """Seeks frames of one stream."""

    def __init__(self, codec, quality, frames):
        self.codec, self.units, self.decoder = codec, ivf_stream(codec, quality, frames), Dav1d()
        if self.decoder.decoded(self.units)[2] != len(self.units):
            sys.exit(f"{codec.name}: expected one frame of dav1d per unit")

    def seek(self, frame):
        """Returns seconds, processor seconds and the number of decoded frames."""
        first = frame - frame % self.codec.key_distance
        seconds, worked, shown = self.decoder.decoded(self.units[first:frame + 1])
        if shown != frame + 1 - first:
            sys.exit(f"{self.codec.name}: {shown} frames shown up to frame {frame} from {first}")
        return seconds, worked, shown
