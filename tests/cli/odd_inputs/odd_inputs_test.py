#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bakes about 570 odd inputs and compares level 0 with an independent decoding, texel by texel. If an input must cause
an error or a warning, the message must say why.

  odd_inputs_test.py MULTUM [--seed N] [--only WORD] [--keep FOLDER]

No code of multum decodes the pictures: odd_images, odd_tiff and exr_reading decode them by the rules of the formats,
and odd_maps turns them into normals by the rules of docs/reference/input_maps.md. exr_reading also reads baked files
(docs/reference/file_format.md). Most inputs are baked as moments of floats, which hold level 0 unchanged; some are
baked as lobes.
"""
import argparse
import collections
import concurrent.futures
import os
import random
import subprocess
import sys
import tempfile

from exr_reading import Baked
from odd_cases import generated
from odd_maps import mean_cosine, normals_of

WORKERS = 2
BATCH = 16  # the number of maps per command; with one map per command, starting the process and OpenCL would take most
            # of the time
INPUT_REFUSED = 3  # the exit code in docs/reference/commands.md
COMPRESSIONS = ("none", "rle", "zips", "zip:1")


class Run:
    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, number, case):
        """Returns the files of a case, which are NUMBER.EXTENSION and the accompanying maps."""
        case.file = f"{number:03}.{case.extension}"
        case.output = self.path(os.path.join("out", f"{number:03}.ndf.exr"))
        files = [(case.file, case.data)]
        case.arguments = list(case.options)
        for i, more in enumerate(case.beside):
            name = f"{number:03}_more{i}.{more.extension}"
            files.append((name, more.data))
            case.arguments += [more.option, self.path(name) + (":" + more.channel if more.channel else "")]
        for name, data in files:
            with open(self.path(name), "wb") as file:
                file.write(data)

    def bake(self, cases, arguments, output):
        """Runs one command for all cases of the group. Returns the exit code and stderr."""
        first = cases[0]
        kind = [] if first.movmf else ["--ndf", "moments"]
        if "-d" not in arguments and not first.movmf:
            kind += ["-d", "float"]
        # No map may keep a process busy for 400 seconds of processor time.
        files = [self.path(case.file) for case in cases]
        command = ["prlimit", "--cpu=400", self.program, "bake", *files, "-o", output, "--no-measure", "--threads", "2",
                   "--compression", COMPRESSIONS[int(first.file[:3]) % len(COMPRESSIONS)], *kind, *arguments]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        return result.returncode, result.stderr

    def commands(self, cases):
        """Groups cases that one command bakes. A case that must be refused has its own command, so that its exit code
        is known."""
        alike, alone = collections.defaultdict(list), []
        for case in cases:
            if case.refused or case.beside:
                alone.append([case])
            else:
                alike[(case.movmf, *case.arguments)].append(case)
        return [some[i:i + BATCH] for some in alike.values() for i in range(0, len(some), BATCH)] + alone

    def perform(self, cases):
        output = self.path("out") + "/" if len(cases) > 1 else cases[0].output
        code, text = self.bake(cases, cases[0].arguments, output)
        for case in cases:
            case.code, case.lines = code, [line for line in text.splitlines() if self.path(case.file[:3]) in line]
            case.text = text
        return cases


def difference(found, expected):
    return max(abs(a - b) for a, b in zip(found, expected, strict=True))


def held_difference(case):
    """Returns the largest difference between the normals, colours and weights of a texel and the expected values."""
    with open(case.output, "rb") as file:
        baked = Baked(file.read())
    assert (baked.width, baked.height) == (case.picture.width, case.picture.height), "size"
    expected = normals_of(case.picture, case.meaning)
    pairs = []
    for beside in case.beside:
        if beside.option in ("--roughness", "--gloss"):
            expected = [tuple(c * mean_cosine(p) for c in n) for n, p in zip(expected, beside.expected, strict=True)]
        else:
            pairs.append((baked.colours if beside.option == "--albedo" else baked.weights, beside.expected))
    pairs.append((baked.normals, expected))
    return max(difference(a, b) for found, wanted in pairs for a, b in zip(found, wanted, strict=True))


def verdict(case):
    """Returns "held" or "refused", the largest difference, and the error text or ""."""
    is_there = os.path.exists(case.output)
    messages = [line for line in case.lines if "warning: " not in line and line.startswith("multum: ")]
    if case.refused:
        wrong = []
        if is_there or case.code != INPUT_REFUSED:
            wrong.append(f"exit code {case.code}, expected {INPUT_REFUSED} and no file")
        message = messages[0] if messages else ""
        if not message:
            wrong.append("no message names the file")
        wrong += [f"the message lacks '{words}'" for words in case.refused if words not in message]
        return "refused", 0.0, "; ".join(wrong)
    if not is_there:
        return "held", 0.0, "no file was baked"
    try:
        worst = held_difference(case)
    except (AssertionError, ValueError, TypeError, KeyError) as error:
        return "held", 0.0, f"{type(error).__name__}: {error}"
    wrong = [f"no warning has '{words}'" for words in case.warns
             if not any("warning: " in line and words in line for line in case.lines)]
    if not worst <= case.tolerance:
        wrong.append(f"differs by {worst:.3g}, expected at most {case.tolerance:g}")
    return "warned" if case.warns else "held", worst, "; ".join(wrong)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--seed", type=int, default=320)
    parser.add_argument("--only", default="", help="run only kinds whose names contain this word")
    parser.add_argument("--keep", help="keep inputs and results in this folder")
    arguments = parser.parse_args()
    print(f"seed {arguments.seed}")
    cases = generated(random.Random(arguments.seed))
    with tempfile.TemporaryDirectory() as temporary:
        run = Run(os.path.abspath(arguments.program), arguments.keep or temporary)
        os.makedirs(run.path("out"), exist_ok=True)
        for number, case in enumerate(cases):
            run.write(number, case)
        cases = [case for case in cases if arguments.only in case.kind]
        with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
            list(pool.map(run.perform, run.commands(cases)))
        failed = report(cases)
    return 1 if failed else 0


def report(cases):
    """Prints a line for each kind and for each wrong case. Returns the number of wrong cases."""
    kinds = collections.defaultdict(lambda: [0, 0, 0, 0.0])
    failed = 0
    for case in cases:
        what, worst, wrong = verdict(case)
        row = kinds[case.kind]
        row[("held", "refused", "warned").index(what)] += not wrong
        row[3] = max(row[3], worst)
        if wrong:
            failed += 1
            said = " | ".join(case.lines) or case.text.strip()
            about = ", ".join(filter(None, (case.kind, case.file, case.note, " ".join(case.options))))
            print(f"FAILED {about}: {wrong}; it said: {said[:400]}")
    print(f"{'kind':<16}{'held':>6}{'refused':>9}{'warned':>8}  worst difference")
    for kind, (held, refused, warned, worst) in kinds.items():
        print(f"{kind:<16}{held:>6}{refused:>9}{warned:>8}  {worst:.2g}")
    print(f"{len(cases)} inputs, {failed} wrong")
    return failed


if __name__ == "__main__":
    sys.exit(main())
