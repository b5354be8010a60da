#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares what two builds of multum read from the same baked files.

  same_map_test.py bake FOLDER MULTUM PRINTED_MAP   # bakes maps with this machine's build, and stores what it prints
  same_map_test.py compare FOLDER COMMAND...        # compares this with what another build prints

PRINTED_MAP is the program of tests/cross/printed_map.cpp. COMMAND runs this program of the other build, as in
`qemu-aarch64-static build/arm64-readers/bin/printed_map`. Texts, checksums, lookups, and the error messages of damaged
files must be equal. Shading calls exp() and log(), which differ between C libraries, so its numbers may differ by
1e-11 of the largest number in the line. Sampling differs most: 1.0e-12 was measured in Wine.
"""
import pathlib
import re
import subprocess
import sys

TOLERANCE = 1e-11
COMPUTED = re.compile(r"(shade|sample|density)\b")
BAKES = {"movmf": ["--ndf", "vmf", "--lobes", "3"], "gmm": ["--ndf", "gmm"], "moments": ["--ndf", "moments"],
         "sh": ["--ndf", "sh"], "half": ["--ndf", "vmf", "--data-format", "half"],
         "float": ["--ndf", "vmf", "--data-format", "float"]}
DAMAGED = {"cut": lambda data: data[:len(data) // 2],
           "changed": lambda data: data[:len(data) // 2] + bytes([data[len(data) // 2] ^ 1])
           + data[len(data) // 2 + 1:],
           "empty": lambda data: b""}


def numbers(line):
    return [float(word) for word in line.partition(": ")[2].split()]


def difference(line, other):
    """Returns the largest difference of the numbers, relative to the largest number of the line."""
    here, there = numbers(line), numbers(other)
    if len(here) != len(there) or line.partition(": ")[0] != other.partition(": ")[0]:
        return float("inf")
    scale = max(map(abs, here), default=0.0) or 1.0
    return max((abs(a - b) / scale for a, b in zip(here, there)), default=0.0)


def printed(command, folder):
    """Returns what the program prints for the good files, and a line for every damaged or missing file."""
    files = [f"{name}.ndf.exr" for name in BAKES]
    text = subprocess.run(command + files, check=True, stdout=subprocess.PIPE, text=True, cwd=folder).stdout
    for name in [*DAMAGED, "missing"]:
        run = subprocess.run(command + [f"{name}.ndf.exr"], check=False, stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE, text=True, cwd=folder)
        message = run.stderr.strip().rpartition(f"{name}.ndf.exr: ")[2]
        text += f"{name}: exit {run.returncode}, {message}\n"
    return text


def bake(folder, multum, printed_map):
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([multum, "testmap", folder / "map", "--size", "64"], check=True, stdout=subprocess.DEVNULL)
    for name, options in BAKES.items():
        subprocess.run([multum, "bake", folder / "map_normal.png", "-o", folder / f"{name}.ndf.exr", "--green", "down"]
                       + options, check=True, stdout=subprocess.DEVNULL)
    good = (folder / "movmf.ndf.exr").read_bytes()
    for name, damage in DAMAGED.items():
        (folder / f"{name}.ndf.exr").write_bytes(damage(good))
    (folder / "printed.txt").write_text(printed([printed_map], folder))


def compare(folder, command):
    here, there = (folder / "printed.txt").read_text().splitlines(), printed(command, folder).splitlines()
    assert len(here) == len(there), f"{len(here)} lines here, {len(there)} lines there"
    largest, exact = 0.0, 0
    for line, found in zip(here, there):
        if COMPUTED.match(line):
            largest = max(largest, difference(line, found))
            assert largest <= TOLERANCE, f"expected {line}\nfound    {found}"
        else:
            exact += 1
            assert line == found, f"expected {line}\nfound    {found}"
    assert exact > 100 and len(here) - exact > 100, "too few lines: the test compares nothing"
    print(f"{len(BAKES)} files: {exact} equal lines; {len(here) - exact} lines of shading, largest difference "
          f"{largest:.1e}")


if __name__ == "__main__":
    step, folder = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    if step == "bake":
        bake(folder, sys.argv[3], sys.argv[4])
    else:
        compare(folder, sys.argv[3:])
