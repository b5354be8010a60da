#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the constants of host/bakes/scene/bake_cost.cpp and prints them as C++.

    tools/lab/plan_constants.py --multum build/release/bin/multum [--sizes 512 2048] [--repeat 3]

Bakes the four-quarter map in two sizes with a few settings, and divides the time of each stage into nanoseconds per
texel and a constant part.
"""
import argparse
import json
import os
import subprocess
import tempfile


class Bakes:
    """Times of bakes of maps in two sizes: nanoseconds per texel of each stage and level, and a constant part."""

    def __init__(self, multum, folder, sizes, repeat):
        self.multum, self.folder, self.sizes, self.repeat = multum, folder, sizes, repeat
        for size in sizes:
            subprocess.run([multum, "testmap", "--size", str(size), os.path.join(folder, f"q{size}")], check=True,
                           capture_output=True)

    def one(self, size, options):
        """Returns seconds by stage and by "level N". They are the lowest of several runs, because other work only adds
        time."""
        path = os.path.join(self.folder, f"q{size}")
        least = {}
        for _ in range(self.repeat):
            subprocess.run([self.multum, "bake", path + "_normal.png", "-o", path + ".ndf.exr", "--force", "--quiet",
                            "--report", path + ".json", *(option.replace("@", path) for option in options)],
                           check=True, capture_output=True)
            with open(path + ".json", encoding="utf-8") as file:
                report = json.load(file)
            seconds = {stage["name"]: stage["seconds"] for stage in report["stages"]}
            seconds.update({f"level {row['level']}": row["seconds"] for row in report["levels"]})
            for name, value in seconds.items():
                least[name] = min(value, least.get(name, value))
        return least

    def run(self, *options):
        small, large = (self.one(size, options) for size in self.sizes)
        small_texels, large_texels = (size * size for size in self.sizes)
        grows = {name: max(0.0, (large[name] - small.get(name, 0.0)) / (large_texels - small_texels)) for name in large}
        stages = [name for name in small if not name.startswith("level")]
        fixed = sum(max(0.0, small[name] - grows[name] * small_texels) for name in stages)
        return {name: 1e9 * value for name, value in grows.items()}, 1e3 * fixed


def line(low, high):
    """Returns constant and slope of the line through (2 lobes, low) and (4 lobes, high), each at least 0."""
    slope = max(0.0, (high - low) / 2.0)
    return max(0.0, high - 4.0 * slope), slope


def level_sum(times, levels):
    return sum(times.get(f"level {level}", 0.0) for level in levels)


def measure(bakes):
    """Returns the constants by name. Binning is not part of one level, so its time is added to the coarse levels."""
    two, _ = bakes.run("--lobes", "2")
    four, fixed = bakes.run("--lobes", "4")
    coloured, _ = bakes.run("--lobes", "4", "--albedo", "@_albedo.png")
    one, fixed_average = bakes.run("--lobes", "1")
    moments, _ = bakes.run("--ndf", "moments")
    fine = range(2, 6)
    averaged = [one.get("fit", 0.0) / 3.0, moments.get("average", 0.0) / 8.0]
    found = {"kRead": one["read"], "kAveragePlane": sum(averaged) / 2.0}
    found["kFitLevelOne"], found["kFitLobeOne"] = line(two["level 1"], four["level 1"])
    found["kFitFine"], found["kFitLobeFine"] = line(level_sum(two, fine) / 4.0, level_sum(four, fine) / 4.0)
    found["kFitCoarse"] = max(0.0, four["fit"] - level_sum(four, range(1, 6)))
    found["kColourFactor"] = max(0.0, coloured["fit"] / four["fit"] - 1.0)
    found["kWriteTexture"] = four["write"] / (4.0 * 4.0 / 3.0)  # four lobes, all levels
    # Lambert costs a third as much as an exponent. A bake measures Lambert once, and three exponents.
    found["kMeasureExponent"] = four["measure"] / (3.0 + 1.0 / 3.0)
    found["kMeasureLambert"] = found["kMeasureExponent"] / 3.0
    found["kFixedMs"] = fixed
    found["kFixedAverageMs"] = fixed_average
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--multum", default="build/release/bin/multum")
    parser.add_argument("--sizes", type=int, nargs=2, default=[512, 2048])
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name, value in measure(Bakes(options.multum, folder, options.sizes, options.repeat)).items():
            print(f"constexpr double {name} = {value:.3g};")


if __name__ == "__main__":
    main()
