#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Studies the normal maps of a folder: what accuracy costs in time and memory, and what the lobes of a texel look like.

The first map is baked with 1, 2, 4 and 8 lobes, for the plots. Then all maps are baked with the chosen number of lobes:
here, or by a service if --service names one.

  folder_study.py FOLDER -o OUTPUT [--lobes 4] [--service http://127.0.0.1:8470]

Writes OUTPUT/costs.png, OUTPUT/lobes.png and OUTPUT/NAME.ndf.exr for each map. Needs matplotlib.
"""
import argparse
import pathlib
import resource
import time

import matplotlib
import numpy as np

import multum

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

PICTURES = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".exr"}


def pixel_error(baked, brdf="blinn-phong:100"):
    """Returns the error of whole pixels in per cent."""
    return 100 * next(row.error for row in baked.error() if row.point == "pixels" and row.brdf == brdf)


def texel_bytes(baked):
    """Returns the bytes of all stored lobes."""
    return sum(baked.lobes(level).size * 2 for level in range(baked.first_level, baked.level_count))


def plot_costs(source, output):
    """Bakes one map with several numbers of lobes, and plots its error against time and memory."""
    rows = []
    for lobes in (1, 2, 4, 8):
        multum.bake(source, lobes=lobes)  # compiles the kernels, which the time below does not count
        begin = time.process_time()
        baked = multum.bake(source, lobes=lobes)
        rows.append((lobes, pixel_error(baked), time.process_time() - begin, texel_bytes(baked) / 2**20))
        print("{} lobes: error {:.1f} %, {:.2f} s of processor time, {:.1f} MiB".format(*rows[-1]))
    lobes, errors, seconds, memory = zip(*rows)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True)
    for axis, values, label in ((axes[0], seconds, "processor time of the bake in s"),
                                (axes[1], memory, "memory of the lobes in MiB")):
        axis.plot(values, errors, "o-")
        for x, y, count in zip(values, errors, lobes):
            axis.annotate(f"{count} lobe{'s' if count > 1 else ''}", (x, y), textcoords="offset points", xytext=(6, 3))
        axis.set_xlabel(label)
        axis.set_ylim(bottom=0)
        axis.margins(x=0.25, y=0.1)
    axes[0].set_ylabel("error of pixels in %")
    figure.suptitle(f"{pathlib.Path(source).name}: what accuracy costs")
    figure.tight_layout()
    figure.savefig(output, dpi=120)
    plt.close(figure)


def plot_lobes(baked, output):
    """Draws the density of normals of one texel per level, seen from above: the disc is the hemisphere."""
    x, y = np.meshgrid(np.linspace(-1, 1, 201), np.linspace(1, -1, 201))
    inside = x * x + y * y < 1
    normals = np.stack([x, y, np.sqrt(np.where(inside, 1 - x * x - y * y, 1))], -1)
    levels = range(max(baked.first_level, 1), baked.level_count)
    figure, axes = plt.subplots(1, len(levels), figsize=(2 * len(levels), 2.6), squeeze=False)
    for axis, level in zip(axes[0], levels):
        density = baked.lookup(0.5, 0.5, level).density(normals)
        axis.imshow(np.where(inside, np.log10(np.maximum(density, 1e-3)), np.nan), vmin=-3, vmax=2, cmap="magma",
                    extent=(-1, 1, -1, 1))
        axis.set_title(f"level {level}", fontsize=9)
        axis.axis("off")
    figure.suptitle(f"{baked.source_name}: normals under the middle of the map, logarithmic")
    figure.savefig(output, dpi=120)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="folder of normal maps")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder to write to")
    parser.add_argument("--lobes", type=int, default=4, help="lobes per texel of the written files, 1 to 8")
    parser.add_argument("--service", help="URL of a service that bakes the files; it must be able to read FOLDER")
    options = parser.parse_args()
    maps = sorted(file.resolve() for file in options.folder.iterdir() if file.suffix.lower() in PICTURES)
    if not maps:
        raise SystemExit(f"folder_study: {options.folder}: found no pictures, expected normal maps")
    options.output.mkdir(parents=True, exist_ok=True)
    plot_costs(maps[0], options.output / "costs.png")
    plot_lobes(multum.bake(maps[0], options.output / f"{maps[0].stem}.ndf.exr", lobes=options.lobes),
               options.output / "lobes.png")
    rest = {source: (options.output / f"{source.stem}.ndf.exr").resolve() for source in maps[1:]}
    if options.service:
        service = multum.Service(options.service)
        jobs = [service.submit("bake", output=str(output), input=str(source), lobes=options.lobes)
                for source, output in rest.items()]
        service.wait(jobs)
    else:
        for source, output in rest.items():
            multum.bake(source, output, lobes=options.lobes)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    print(f"{len(maps)} maps are baked in {options.output}; peak memory {peak:.0f} MiB")


if __name__ == "__main__":
    main()
