#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every page of docs/ that a comment, a message or a page names exists, and has the section that is quoted
after the name.

    docs/reference/file_format.md                  the page exists
    docs/reference/file_format.md, "Rounding"      it has the heading "Rounding", or a paragraph that begins so in bold
    ARCHITECTURE.md                                some folder has a page of that name

Comments and messages may span several lines. Usage: document_paths_test.py [--root FOLDER] first checks itself on texts
of its own, and then the tree. Prints one line per dead name, and exits with code 1 if there are any.
"""
import argparse
import os
import pathlib
import re
import sys
import tempfile

SKIPPED = {"build", "out", ".git", "__pycache__", "node_modules"}
MADE_UP = {"tests/site/site_test.py"}  # this test makes pages for its own trees
SUFFIXES = {".h", ".cpp", ".cl", ".clh", ".glsl", ".vert", ".frag", ".js", ".mjs", ".css", ".html", ".py", ".sh",
            ".cmake", ".txt", ".toml", ".json", ".md", ""}
PAGE = re.compile(r"(?<![\w/.-])docs/[\w./-]+?\.(?:md|json|py)\b")
BARE = re.compile(r"(?<![\w/.([-])[A-Z][A-Z_]+\.md\b")
# The quoted name of a section follows the page directly or after a comma. A second section follows "and".
SECTIONS = re.compile(r'(?:,\s*|\s+)"([^"<>{}]+)"(?:\s*(?:,|and)\s*"([^"<>{}]+)")?')
# These are names that stand for any page, and pages of other projects.
STANDS_FOR_ANY = {"NAME.md", "PAGE.md", "FILE.md", "OUTPUT.md", "MANIFEST.md"}
SELF = "tests/tools/document_paths_test.py"


def joined(text):
    """Returns the comments and string literals of the text as continuous lines, and the line number of each
    character."""
    pieces, lines, number = [], [], 1
    pattern = re.compile(r'"[ \t]*\n[ \t]*(?:R?"|fmt::format\(")|\n[ \t]*(?:///?|#|\*)?[ \t]*|\\"|\\n', re.MULTILINE)
    at = 0
    for found in pattern.finditer(text):
        pieces.append(text[at:found.start()])
        lines += [number] * (found.start() - at)
        token = found[0]
        replaced = '"' if token == '\\"' else "" if token.startswith('"') else " "
        pieces.append(replaced)
        lines += [number] * len(replaced)
        number += token.count("\n")
        at = found.end()
    pieces.append(text[at:])
    lines += [number] * (len(text) - at)
    return "".join(pieces), lines


def plain(title):
    """Returns a heading without its marks."""
    return re.sub(r"[`*]", "", title).strip()


def sections(page):
    """Returns the headings of a page, and the emphasised words that open its paragraphs and list items."""
    found, is_code = set(), False
    for line in page.splitlines():
        if line.startswith("```"):
            is_code = not is_code
        if is_code:
            continue
        if heading := re.match(r"#+ (.*)", line):
            found.add(plain(heading[1]))
        if bold := re.match(r"(?:[-*] |\d+\. )?\*\*?(.+?)[.:?]?\*", line):
            found.add(plain(bold[1]))
    return found


def is_section(title, titles):
    """Returns whether the quoted words are the name of a section, or the part of the name before a colon or comma."""
    title = plain(" ".join(title.split())).rstrip(".,:")
    return title in titles or any(known.split(":")[0] == title or known.split(",")[0] == title for known in titles)


class Tree:
    def __init__(self, root):
        self.root, self.files, self.pages = root, [], {}
        for folder, folders, names in os.walk(root):
            folders[:] = [f for f in folders if f not in SKIPPED]
            for name in names:
                path = pathlib.Path(folder) / name
                if path.relative_to(root).as_posix() in MADE_UP:
                    continue
                if path.suffix in SUFFIXES and not path.is_symlink() and path.stat().st_size < 1 << 22:
                    self.files.append(path.relative_to(root).as_posix())
        self.files.sort()
        self.names = {file.rsplit("/", 1)[-1] for file in self.files}

    def sections(self, page):
        if page not in self.pages:
            self.pages[page] = sections((self.root / page).read_text())
        return self.pages[page]

    def dead_names(self):
        for file in self.files:
            data = (self.root / file).read_bytes()
            if file == SELF or b".md" not in data or b"\0" in data:
                continue
            text, lines = joined(data.decode(errors="replace"))
            for found in PAGE.finditer(text):
                where = f"{file}:{lines[found.start()]}: "
                page = found[0]
                if not (self.root / page).is_file():
                    if not re.search(r"/(NAME|PAGE|FILE)\.", page):
                        yield where + f"{page} does not exist"
                    continue
                quoted = SECTIONS.match(text, found.end()) if page.endswith(".md") else None
                for title in quoted.groups() if quoted else ():
                    if title is not None and not is_section(title, self.sections(page)):
                        yield where + f'{page} has no section "{title}"'
            for found in BARE.finditer(text):
                if found[0] not in self.names | STANDS_FOR_ANY:
                    yield f"{file}:{lines[found.start()]}: no page has the name {found[0]}"


def check_itself():
    page = "# Title\n\n## The `first` part\n\n**Bold words.** Text.\n\n```sh\n# no heading\n```\n"
    cases = [  # the text of a source, and the number of dead names in it
        ('// Rows (docs/a/page.md,\n// "The first part").\n', 0),
        ('// Rows (docs/a/page.md, "The second part").\n', 1),
        ('// docs/a/page.md, "Bold words", "The first part" and docs/a/page.md\n', 0),
        ('// docs/a/page.md, "no heading"\n', 1),
        ('  x("see docs/a/page.md, \\"The "\n    "first part\\"");\n', 0),
        ('  x("see docs/a/page.md, \\"The "\n    "last part\\"");\n', 1),
        ('const names = ["docs/a/page.md", "Another"];\n', 0),
        ("// docs/a/gone.md, docs/a/NAME.md\n", 1),
        ("// PAGES.md and FORMER.md\n", 1),
    ]
    for text, expected in cases:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs/a").mkdir(parents=True)
            (root / "docs/a/page.md").write_text(page)
            (root / "docs/a/PAGES.md").write_text("")
            (root / "source.cpp").write_text(text)
            found = list(Tree(root).dead_names())
            if len(found) != expected:
                sys.exit(f"found {found} in {text!r}, expected {expected} dead names")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent.parent)
    root = parser.parse_args().root.resolve()
    check_itself()
    found = list(Tree(root).dead_names())
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
