#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes docs/evidence/SHARES.md, the page about the costs of baking one map in shares.

The page compares these costs with one whole bake and with the prediction of `multum plan`.

    tools/lab/shares_document.py --multum build/release/bin/multum --folder FOLDER -o docs/evidence/SHARES.md

FOLDER is on the disk that is measured. A map of 16384 x 16384 needs about 8 GB there, and takes half an hour on two
cores without other work. Runs in the file of --state are not repeated, but the plan is made again.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import platform
import sys

import committed_tree
import report_page
from measured_run import succeed

PARTS = (("coarse", "share 0"), ("band", "bands"), ("merge", "merge"))


def machine_words():
    model = report_page.first_value("/proc/cpuinfo", "model name") or platform.machine()
    memory = int(report_page.first_value("/proc/meminfo", "MemTotal").split()[0]) / 2 ** 20
    system = report_page.first_value("/etc/os-release", "PRETTY_NAME")
    return f"{os.cpu_count()} cores of {model}, {memory:.0f} GiB of memory, {system}"


def sha256(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


class Bakes:
    """One map that is baked whole and in shares."""

    def __init__(self, multum, folder, size, count):
        self.multum, self.count = multum, count
        self.map = folder / f"q{size}_normal.png"
        if not self.map.exists():
            succeed([multum, "testmap", "--size", size, folder / f"q{size}"])
        self.output = folder / "out.ndf.exr"

    def bake(self, *options):
        done = succeed([self.multum, "bake", self.map, "-o", self.output, "--quiet", *options])
        return {"processor_s": done.processor_seconds, "memory": done.memory_bytes}

    def whole(self):
        self.output.unlink(missing_ok=True)
        run = self.bake()
        return {**run, "sha256": sha256(self.output)}

    def shared(self, processes):
        """First removes leftovers of an interrupted run. Then bakes share 0, bakes the bands, `processes` at a time,
        and merges."""
        for old in self.output.parent.glob(self.output.name + "*"):
            old.unlink()
        coarse = self.bake("--shard", f"0/{self.count}")
        with concurrent.futures.ThreadPoolExecutor(processes) as pool:
            bands = list(pool.map(lambda i: self.bake("--shard", f"{i}/{self.count}"), range(1, self.count + 1)))
        merge = self.bake("--merge", str(self.count))
        return {"coarse": [coarse], "band": bands, "merge": [merge], "sha256": sha256(self.output)}

    def plan(self):
        plan = json.loads(succeed([self.multum, "plan", self.map, "--shards", self.count, "--json", "--quiet"]).text)
        return {"whole": plan["processor_seconds"], "coarse": [plan["coarse_seconds"]], "band": plan["band_seconds"],
                "merge": [plan["merge_seconds"]]}


def seconds(runs):
    return sum(run["processor_s"] for run in runs)


def total(run):
    return sum(seconds(run[key]) for key, _ in PARTS)


def whole_seconds(one):
    """Returns the mean cost of the two whole bakes before and after the shares of a round."""
    return seconds(one["wholes"]) / len(one["wholes"])


def mib(runs):
    return max(run["memory"] for run in runs) >> 20


def span(values, form):
    low, high = form.format(min(values)), form.format(max(values))
    return low if low == high else f"{low} to {high}"


def section(size, rounds, processes, plan):
    """Makes the section of one size. It lists the costs, and the measured and planned costs of the parts in % of one
    bake."""
    wholes = [run for one in rounds for run in one["wholes"]]
    hashes = {run["sha256"] for one in rounds for run in (*one["wholes"], *(one[str(count)] for count in processes))}
    if len(hashes) != 1:
        sys.exit(f"{size}: the files of shares and of one whole bake differ: {sorted(hashes)}")
    rows = [f"| one whole bake | | | | {span([w['processor_s'] for w in wholes], '{:.1f}')} | | {mib(wholes)} |"]
    for count in processes:
        runs = [one[str(count)] for one in rounds]
        ratios = [total(one[str(count)]) / whole_seconds(one) for one in rounds]
        cells = " | ".join(span([seconds(run[key]) for run in runs], "{:.1f}") for key, _ in PARTS)
        memory = ", ".join(f"{max(mib(run[key]) for run in runs)} ({name})" for key, name in PARTS)
        rows.append(f"| {count} at a time | {cells} | {span([total(run) for run in runs], '{:.1f}')} | "
                    f"{span(ratios, '{:.2f}')} | {memory} |")
    predicted = plan["whole"]
    parts = []
    for key, name in PARTS:
        asked = [100 * p / predicted for p in plan[key]]
        found = [100 * run["processor_s"] / whole_seconds(one)
                 for one in rounds for count in processes for run in one[str(count)][key]]
        off = [want * whole_seconds(one) / run["processor_s"] - 100 for one in rounds
               for count in processes for run, want in zip(one[str(count)][key], asked)]
        name = "one band" if key == "band" else name
        parts.append(f"| {name} | {span(asked, '{:.1f}')} | {span(found, '{:.1f}')} | {span(off, '{:+.0f}')} |")
    return f"""## {size} x {size}

The table lists processor seconds, and the memory in MiB of the largest process of each kind{ "" if len(rounds) == 1
else f", from {len(rounds)} rounds"}. The whole map was baked once before the shares and once after the shares. The
column *times one bake* lists the sum of all parts, divided by the mean of the two whole bakes. All output files had
the same SHA-256.

| | share 0 | all bands | merge | sum | times one bake | MiB |
|---|---|---|---|---|---|---|
{chr(10).join(rows)}

The next table lists the costs of the parts in % of the cost of one bake, as `multum plan --shards` predicts them and
as they were measured.

| | plan | measured | error of the plan, % of the measured cost |
|---|---|---|---|
{chr(10).join(parts)}
"""


def page_text(state, count, processes, planned):
    sections = [section(size, found["rounds"], processes, found["plan"])
                for size, found in sorted(state["sizes"].items(), key=lambda item: int(item[0]))]
    return f"""# Costs of baking one map in shares

This page lists the processor time and the memory of a bake that is divided into shares. It compares these costs with
the costs of one whole bake and with the plan.

Generated by `tools/lab/shares_document.py -o docs/evidence/SHARES.md`. Do not edit. The bakes were measured at
{state["source"]}, on {state["machine"]}. The plan was computed at {planned}.

The input is the four-quarter map of `multum testmap` as a PNG, baked with defaults in {count} bands
([clusters](../how-to/clusters.md), "One large map on many machines"). Share 0 was baked first. The bands were baked
next, 1, 2 or 4 at a time. The merge ran last. All processes ran on one machine, and each process used all threads.

{chr(10).join(sections)}"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--multum", default="build/release/bin/multum")
    parser.add_argument("--folder", type=pathlib.Path, required=True, help="for maps and shares")
    parser.add_argument("--sizes", type=int, nargs="+", default=[8192, 16384])
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--rounds", type=int, nargs="+", default=[1, 1], help="for each size")
    parser.add_argument("--state", type=pathlib.Path, help="JSON file of runs, which is written after each run")
    committed_tree.add_option(parser)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    options = parser.parse_args()
    if len(options.rounds) != len(options.sizes):
        parser.error(f"--rounds has {len(options.rounds)} numbers, expected {len(options.sizes)}, one for each size")
    options.folder.mkdir(parents=True, exist_ok=True)
    state = {"sizes": {}}
    if options.state and options.state.exists():
        state = json.loads(options.state.read_text())
    planned = committed_tree.stated_commit(options.allow_dirty)
    state["source"] = state.get("source") or planned
    state["machine"] = state.get("machine") or machine_words()

    def keep():
        if options.state:
            options.state.write_text(json.dumps(state, indent=1) + "\n")

    for size, rounds in zip(options.sizes, options.rounds):
        found = state["sizes"].setdefault(str(size), {"rounds": []})
        bakes = Bakes(options.multum, options.folder, size, options.shards)
        found["plan"] = bakes.plan()
        while len(found["rounds"]) < rounds:
            one = {"wholes": [bakes.whole()]}
            print(f"{size}: one bake {whole_seconds(one):.1f} s", flush=True)
            for count in options.processes:
                run = one[str(count)] = bakes.shared(count)
                print(f"{size}: {count} at a time {total(run):.1f} s", flush=True)
            one["wholes"].append(bakes.whole())
            print(f"{size}: one bake {whole_seconds(one):.1f} s", flush=True)
            found["rounds"].append(one)
            keep()
    options.output.write_text(page_text(state, options.shards, options.processes, planned))


if __name__ == "__main__":
    main()
