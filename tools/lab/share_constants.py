#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares processor times of the shares of a map with the prediction of `multum plan --shards N`, which uses the
constants of host/bakes/scene/share_cost.cpp.

    tools/lab/share_constants.py --multum build/release/bin/multum  # a table of settings and counts
    tools/lab/share_constants.py --multum build/release/bin/multum --check --size 1024
                                                                    # exit code 1 if an error exceeds a third

The model does not predict the speed of a machine, so --check compares each part's share of the whole time.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

from measured_run import succeed

SETTINGS = (("--lobes", "4"), ("--lobes", "2"), ("--lobes", "4", "--first-level", "2"),
            ("--lobes", "4", "--albedo", "@_albedo.png"), ("--lobes", "4", "--no-measure"))
ALLOWED = 1.0 / 3.0


class Shares:
    """Timed bakes of the four-quarter map of one size."""

    def __init__(self, multum, folder, size, repeat):
        self.multum, self.size, self.repeat = multum, size, repeat
        self.path = os.path.join(folder, f"q{size}")
        subprocess.run([multum, "testmap", "--size", str(size), self.path], check=True, capture_output=True)

    def words(self, options):
        return [self.path + "_normal.png", "--quiet", *(option.replace("@", self.path) for option in options)]

    def seconds(self, *options):
        """Returns the processor time of a bake and its children."""
        words = [self.multum, "bake", *self.words(options), "-o", self.path + ".ndf.exr", "--force"]
        return succeed(words).processor_seconds

    def rounds(self, count, options):
        """Measures four processes in each round: the bake in one process, share 0, the band with the most rows around
        it, and the merge."""
        rounds = []
        for _ in range(self.repeat):
            whole = self.seconds(*options)
            times = [self.seconds(*options, "--shard", f"{i}/{count}") for i in range(count + 1)]
            rounds.append([whole, times[0], max(times[1:]), self.seconds(*options, "--merge", str(count))])
        return rounds

    def predicted(self, count, options):
        plan = json.loads(subprocess.run(
            [self.multum, "plan", *self.words(options), "--shards", str(count), "--json"], check=True,
            capture_output=True, text=True).stdout)
        return [plan["processor_seconds"], plan["coarse_seconds"], max(plan["band_seconds"]), plan["merge_seconds"]]


PARTS = ("one process", "share 0", "band", "merge")


def check(shares, counts):
    """Tests whether all parts are within the bound."""
    is_within = True
    for count in counts:
        rounds, predicted = shares.rounds(count, SETTINGS[0]), shares.predicted(count, SETTINGS[0])
        for part, name in enumerate(PARTS):
            # Each ratio is of two runs of one round, which other work slows alike.
            ratio = statistics.median(predicted[part] / times[part] * times[0] / predicted[0] for times in rounds)
            is_within = is_within and 1.0 - ALLOWED <= ratio <= 1.0 + ALLOWED
            print(f"{shares.size} x {shares.size}, {count} bands, {name:<12} measured "
                  f"{statistics.median(times[part] for times in rounds):7.2f} s, predicted {predicted[part]:7.2f} s, "
                  f"to one process {ratio:.2f}")
    return is_within


def table(shares, counts):
    """Prints the measured and the predicted times of all settings."""
    for options in SETTINGS:
        for count in counts:
            measured = [min(times) for times in zip(*shares.rounds(count, options))]  # other work only adds time
            predicted = shares.predicted(count, options)
            print(f"{shares.size} {count} {' '.join(options):<32} "
                  + "  ".join(f"{m:6.2f}/{p:6.2f}={p / m:4.2f}" for m, p in zip(measured, predicted)), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--multum", default="build/release/bin/multum")
    parser.add_argument("--size", type=int, default=2048)
    parser.add_argument("--counts", type=int, nargs="+", default=[2, 8])
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        shares = Shares(options.multum, folder, options.size, options.repeat)
        if not options.check:
            table(shares, options.counts)
        elif not check(shares, options.counts):
            sys.exit(f"the error of a part is above {ALLOWED:.2f}")


if __name__ == "__main__":
    main()
