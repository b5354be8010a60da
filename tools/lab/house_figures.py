#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts lines, folders and switches over representations in the sources.

    tools/lab/house_figures.py [COMMIT]   # default: HEAD

Comparisons with `Representation::` use ==, != or `case`. Each file of product code that names a representation or a
BRDF counts once.
"""
import argparse
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
CODE = r"\.(cpp|h|cl|clh|glsl|vert|frag|js|mjs|html|css)$"
PRODUCT = re.compile(
    r"^(host|kernels|runtime_gl|tools/(multum|multum_view|multum_decode|multum_wasm|command_line))/.*" + CODE)
TESTS = re.compile(r"^tests/.*(" + CODE + r"|\.py$)")
COMPARISON = re.compile(r"(?:[=!]=\s*|\bcase\s+)Representation::\w+|Representation::\w+\s*[=!]=")


def git(*words):
    return subprocess.run(["git", "-C", ROOT, *words], capture_output=True, check=True).stdout


def texts(commit, files):
    """Returns the text of each file at the commit."""
    query = "".join(f"{commit}:{file}\n" for file in files).encode()
    command = ["git", "-C", ROOT, "cat-file", "--batch"]
    out = subprocess.run(command, input=query, capture_output=True, check=True).stdout
    found, at = {}, 0
    for file in files:
        head, at = out[at:out.index(b"\n", at)], out.index(b"\n", at) + 1
        size = int(head.split()[2])
        found[file], at = out[at:at + size].decode("utf-8", "replace"), at + size + 1
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit", nargs="?", default="HEAD")
    commit = parser.parse_args().commit
    files = git("ls-tree", "-r", "--name-only", commit).decode().splitlines()
    product = texts(commit, [file for file in files if PRODUCT.match(file)])
    tests = texts(commit, [file for file in files if TESTS.match(file)])
    entries = {file.split("/")[1] for file in files if file.startswith("host/") and file.count("/") > 1}
    print(f"entries in host/                        {len(entries)}")
    print(f"lines of product code                   {sum(text.count(chr(10)) for text in product.values())}")
    print(f"lines of tests                          {sum(text.count(chr(10)) for text in tests.values())}")
    print(f"comparisons with Representation::       {sum(len(COMPARISON.findall(text)) for text in product.values())}")
    for name, pattern in (("Representation::kGmm", r"Representation::kGmm\b"),
                          ("Torrance-Sparrow", r"kTorranceSparrow|torrance.sparrow")):
        count = sum(re.search(pattern, text, re.IGNORECASE) is not None for text in product.values())
        print(f"files of product code that name {name:22} {count}")


if __name__ == "__main__":
    main()
