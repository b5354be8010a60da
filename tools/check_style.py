#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the rules of style that a script can check: marks, licence line, header comment, line length, dead files,
folders, and the slips of English that tools/word_patterns.txt lists.

Usage: check_style.py [--root FOLDER]. Prints one line per violation. The exit code is 1 if a rule is broken.
"""
import argparse
import os
import pathlib
import re
import sys

import prose

HERE = pathlib.Path(__file__).resolve().parent
LINE_LENGTH_MAX = 120
COMMENT = {".h": "//", ".cpp": "//", ".cl": "//", ".clh": "//", ".glsl": "//", ".vert": "//", ".frag": "//", ".py": "#",
           ".cmake": "#", ".txt": "#", "": "#", ".js": "//", ".mjs": "//", ".css": "/*"}
# A source with one of these endings is dead unless a build file names it. Kernels are found by a glob, and headers are
# included.
BUILT = {".cpp", ".cl", ".glsl", ".vert", ".frag"}
SOURCE_FOLDERS = ("kernels", "host", "runtime_gl", "tools", "tests")
SKIPPED = ("build", "out", ".git", "__pycache__", "node_modules")


def project_files(root):
    """Yields the files to which the rules apply: sources, scripts and CMake files in every folder."""
    found = []
    for folder, folders, names in os.walk(root):
        folders[:] = [f for f in folders if f not in SKIPPED]
        found += [pathlib.Path(folder) / name for name in names]
    for file in sorted(found):
        parts = file.relative_to(root).parts
        is_script = file.suffix == "" and parts[0] in ("tools", ".ci") and file.read_bytes()[:2] == b"#!"
        if is_script or (file.suffix in COMMENT and file.suffix not in ("", ".txt")) or file.name == "CMakeLists.txt":
            yield file


def check_text(file, text):
    lines = text.splitlines()
    for number, line in enumerate(lines, start=1):
        if len(line) > LINE_LENGTH_MAX:
            yield number, f"{len(line)} characters, at most {LINE_LENGTH_MAX}"
        if re.search(r"\b(FIX" r"ME|XX" r"X)\b", line):
            yield number, "FIX" "ME and XX" "X may not be merged: name an issue with TODO, or fix it"
    if not any("SPDX-License-Identifier: Apache-2.0" in line for line in lines[:3]):
        yield 1, "found no line 'SPDX-License-Identifier: Apache-2.0' among the first three"


def has_header_comment(file, lines):
    """Returns whether there is a comment other than the licence line before the first line of code. A .cpp file needs
    no such comment if its header has one."""
    if file.suffix == ".cpp" and (file.with_suffix(".h").is_file() or file.with_suffix(".clh").is_file()):
        return True
    if file.name == "CMakeLists.txt":
        return True
    mark = COMMENT[file.suffix]
    for line in lines:
        if line.startswith("#!") or "SPDX" in line or not line.strip():
            continue
        if line.startswith("#version"):  # GLSL requires it in the first line
            continue
        return line.startswith((mark, '"""', "/*"))
    return False


def table_rows(path, columns):
    """Returns the rows of a file whose columns are separated by tabs, without empty lines and comments."""
    if not path.is_file():
        return []
    rows = [line.split("\t") for line in path.read_text().splitlines() if line and not line.startswith("# ")]
    for row in rows:
        if len(row) != columns:
            sys.exit(f"{path}: found {len(row)} columns in '{row[0]}', expected {columns}, separated by tabs")
    return rows


class WordSlips:
    """Finds slips of English by the patterns of tools/word_patterns.txt, except those in tools/word_exceptions.txt."""

    def __init__(self, root):
        self.root = root
        self.patterns = [(re.compile(pattern), advice)
                         for pattern, advice in table_rows(HERE / "word_patterns.txt", 2)]
        self.exceptions = table_rows(root / "tools" / "word_exceptions.txt", 3)
        self.unused = {(file, words) for file, words, _ in self.exceptions}

    def is_exception(self, name, text):
        found = [(file, words) for file, words, _ in self.exceptions if file in ("*", name) and words in text]
        self.unused -= set(found)
        return bool(found)

    def of(self, file):
        name = file.relative_to(self.root).as_posix()
        for line, text in prose.prose(file, file.read_text(errors="replace")):
            for pattern, advice in self.patterns:
                found = pattern.search(text)
                if found and not self.is_exception(name, text):
                    start = max(found.start() - 30, 0)
                    yield f"{name}:{line}: '{text[start:found.end() + 20].strip()}': write {advice}"


def built_patterns(root, files):
    """Returns a regular expression of the paths that any CMakeLists.txt names or globs. A name also matches in
    subfolders, because CMake puts a folder before each name in the list of shaders."""
    patterns = []
    for file in (f for f in files if f.name == "CMakeLists.txt"):
        code = re.sub(r"#.*", "", file.read_text())
        for token in re.findall(r"[^\s()\";]+\.(?:cpp|cl|glsl|vert|frag)\b", code):
            start = root if token.startswith("${CMAKE_SOURCE_DIR}") else file.parent
            token = re.sub(r"^\$\{CMAKE_(CURRENT_)?SOURCE_DIR\}/", "", token)
            if "${" in token:
                continue
            path = pathlib.Path(os.path.normpath(start / token)).relative_to(root).as_posix()
            if "*" in token:
                patterns.append(re.escape(path).replace(r"\*", "[^/]*"))
                continue
            base = file.parent.relative_to(root).as_posix()
            patterns += [re.escape(path), re.escape(base) + "/(.*/)?" + re.escape(token)]
    return re.compile("|".join(patterns) or "$.")


def folder_rows(root):
    text = (root / "docs/contributing/ARCHITECTURE.md").read_text()
    block = re.search(r"^```folders\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    if block is None:
        sys.exit("docs/contributing/ARCHITECTURE.md: found no table ```folders")
    return {line.split()[0] for line in block.group(1).splitlines() if line.strip()}


def is_listed(folder, listed):
    """Returns whether the folder has a row. A folder that has only subfolders, such as
    host/fields/inference, counts as listed if one of its subfolders has a row."""
    return folder in listed or any(row.startswith(f"{folder}/") for row in listed)


def violations(root):
    files = list(project_files(root))
    built = built_patterns(root, files)
    listed = folder_rows(root)
    missing_folders = set()
    slips = WordSlips(root)
    documents = sorted(file for file in root.rglob("*.md")
                       if not set(SKIPPED) & set(file.relative_to(root).parts))
    for file in documents:
        yield from slips.of(file)
    for file in files:
        yield from slips.of(file)
        name = file.relative_to(root).as_posix()
        text = file.read_text(errors="replace")
        for number, what in check_text(file, text):
            yield f"{name}:{number}: {what}"
        if not has_header_comment(file, text.splitlines()):
            yield f"{name}:1: found no comment before the code that says what the file computes"
        if file.suffix in BUILT and not built.fullmatch(name):
            yield f"{name}:1: no CMakeLists.txt names it: dead"
        folder = file.parent.relative_to(root).as_posix()
        mirror = re.match("tests/unit/(.*)", folder)  # mirrors a folder of host/, whose row stands for both
        wanted = f"host/{mirror[1]}" if mirror else folder
        if folder.split("/")[0] in SOURCE_FOLDERS and file.name != "CMakeLists.txt" and not is_listed(wanted, listed):
            missing_folders.add(folder)
    for file, words in sorted(slips.unused):
        yield f"tools/word_exceptions.txt: '{words}' is not in {file}: remove the row"
    for folder in sorted(missing_folders):
        yield f"{folder}: has no row in the folder table of docs/contributing/ARCHITECTURE.md"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent)
    root = parser.parse_args().root.resolve()
    found = list(violations(root))
    for violation in found:
        print(violation)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
