#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Configures a build without fields and farm (preset core) where SQLite and Boost cannot be found. The build names no
file or library of fields and farm, and compiles the sources that replace them.

Usage: core_build_test.py FOLDER BUILD    (a folder that it may replace; a build of everything)

The complete build compiles all other sources of the core build with the same flags. The test compares both lists.
"""
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HIDDEN = ("SQLite3", "Boost")
FOREIGN = re.compile(r"(host|tools/multum|tools/multum_view)/(fields|farm)/|sqlite3|boost|libsystemd|node_modules|wasm",
                     re.IGNORECASE)
OWN = {"host/api/api_no_fields.cpp", "tools/multum/no_farm.cpp", "tools/multum/no_field_commands.cpp",
       "tools/multum_view/no_field_commands.cpp"}
COMPILED = re.compile(r"^build (\S+\.o): CXX_COMPILER\S* (\S+)", re.MULTILINE)


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: {done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout


def objects(folder):
    """Returns the sources of the programs that a build compiles, each with its object. For unity files, returns the
    included sources."""
    found = {}
    for made, source in COMPILED.findall((folder / "build.ninja").read_text()):
        path = pathlib.Path(source)
        texts = path.read_text() if path.match("Unity/*.cxx") else f'#include "{path}"'
        for name in re.findall(r'^#include "(.+)"', texts, re.MULTILINE):
            if (path := pathlib.Path(name)).is_relative_to(ROOT):
                found[str(path.relative_to(ROOT))] = made
    return {name: made for name, made in found.items() if name.startswith(("host/", "runtime_gl/", "tools/"))}


def main():
    folder, whole = map(pathlib.Path, sys.argv[1:])
    shutil.rmtree(folder, ignore_errors=True)
    run("cmake", "--preset", "core", "-S", ROOT, "-B", folder, "-DMULTUM_BUILD_TESTS=ON", "-DCMAKE_UNITY_BUILD=OFF",
        *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in HIDDEN))
    for line in (folder / "build.ninja").read_text().splitlines():
        if word := FOREIGN.search(line):
            sys.exit(f"a core build names {word.group(0)}: {line[:300]}")
    core = objects(folder)
    if (own := core.keys() - objects(whole).keys()) != OWN:
        sys.exit(f"only the core build compiles {sorted(own)}, expected {sorted(OWN)}")
    for name in OWN:  # must compile without any other build step before it
        command = run("ninja", "-C", folder, "-t", "commands", "-s", core[name])
        run("bash", "-c", f"cd '{folder}' && {command.strip()} -fsyntax-only")
    print(f"{len(core)} sources, {len(own)} of its own")


if __name__ == "__main__":
    main()
