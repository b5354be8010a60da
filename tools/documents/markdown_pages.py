# SPDX-License-Identifier: Apache-2.0
"""Reads the Markdown pages of a project: headings, links, code spans and code blocks, each with its line."""
import dataclasses
import pathlib
import re

FENCE = re.compile(r"(\s*)(`{3,}|~{3,})\s*([^`]*)$")
HEADING = re.compile(r"(#{1,6})\s+(.*?)\s*#*$")
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
CODE_SPAN = re.compile(r"(?<!`)(`+)(?!`)((?:(?!\n\s*\n).)+?)(?<!`)\1(?!`)", re.DOTALL)
LINK = re.compile(r"\]\(\s*<?([^()\s<>]*(?:\([^()\s]*\)[^()\s]*)*)>?(?:\s+\"[^\"]*\")?\s*\)")
REFERENCE = re.compile(r"^ {0,3}\[[^\]]+\]:\s*(\S+)", re.MULTILINE)
ATTRIBUTE = re.compile(r"<(?:a|img)\s[^>]*?\b(?:href|src)=\"([^\"]*)\"")
ANCHOR = re.compile(r"<a\s[^>]*?\b(?:id|name)=\"([^\"]*)\"")
FOLDERS = ("tutorials", "how-to", "reference", "explanation", "evidence", "contributing")


@dataclasses.dataclass
class Block:
    """A code block. `line` is the line of its first fence; `is_closed` is false if the page ends in the block."""
    line: int
    language: str
    lines: list
    is_closed: bool = True


def blanked(text):
    """Replaces all characters except line breaks with spaces."""
    return re.sub(r"[^\n]", " ", text)


def split_fences(text):
    """Returns the text with spaces instead of fenced blocks, and the blocks."""
    kept, blocks, block, mark, indent = [], [], None, "", 0
    for number, line in enumerate(text.split("\n"), start=1):
        found = FENCE.match(line)
        if block is None:
            if found is None:
                kept.append(line)
                continue
            indent, mark = len(found[1]), found[2]
            block = Block(number, found[3].strip(), [], False)
            blocks.append(block)
        elif found and found[2].startswith(mark) and not found[3]:
            block.is_closed = True
            block = None
        else:
            block.lines.append(line[min(indent, len(line) - len(line.lstrip())):])
        kept.append("")
    return "\n".join(kept), blocks


def changed_outside_fences(text, change):
    """Applies `change` to each part of the text that is outside fenced blocks."""
    parts, part, mark = [], [], ""
    for line in text.split("\n"):
        found = FENCE.match(line)
        if mark or found:
            if part:
                parts.append(change("\n".join(part)))
                part = []
            parts.append(line)
            if not mark:
                mark = found[2]
            elif found and found[2].startswith(mark) and not found[3]:
                mark = ""
        else:
            part.append(line)
    return "\n".join([*parts, change("\n".join(part))] if part else parts)


def plain_heading(text):
    """Returns a heading without the marks of code, links and emphasis."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"`|\*\*|(?<!\w)[*_]|[*_](?!\w)", "", text).strip()


def slug(heading):
    """Returns the anchor that GitHub gives to a heading."""
    return re.sub(r"[^\w\- ]", "", plain_heading(heading).lower()).replace(" ", "-")


class Anchors:
    """Assigns anchors to the headings of one page. The anchors of equal headings end in -1, -2 and so on."""

    def __init__(self):
        self.counts = {}

    def of(self, heading):
        anchor = slug(heading)
        count = self.counts.get(anchor, 0)
        self.counts[anchor] = count + 1
        return f"{anchor}-{count}" if count else anchor


class Page:
    """One page of a project. `name` is its path from the root."""

    def __init__(self, root, name):
        self.root = pathlib.Path(root)
        self.name = name
        self.text = (self.root / name).read_text()
        without_fences, self.blocks = split_fences(self.text)
        self.visible = COMMENT.sub(lambda found: blanked(found[0]), without_fences)
        self.prose = CODE_SPAN.sub(lambda found: blanked(found[0]), self.visible)

    def line_at(self, position):
        return self.visible.count("\n", 0, position) + 1

    def headings(self):
        """Yields (line, level, text, anchor) of each heading."""
        anchors = Anchors()
        for number, line in enumerate(self.visible.split("\n"), start=1):
            found = HEADING.match(line)
            if found:
                yield number, len(found[1]), found[2], anchors.of(found[2])

    def title(self):
        return next((plain_heading(text) for _, level, text, _ in self.headings() if level == 1), self.name)

    def anchors(self):
        return {anchor for *_, anchor in self.headings()} | set(ANCHOR.findall(self.prose))

    def links(self):
        """Yields (line, target) of each link and picture."""
        for pattern in (LINK, REFERENCE, ATTRIBUTE):
            for found in pattern.finditer(self.prose):
                yield self.line_at(found.start(1)), found[1]

    def code_spans(self):
        """Yields (line, text) of each code span, with spaces instead of line breaks."""
        for found in CODE_SPAN.finditer(self.visible):
            yield self.line_at(found.start()), " ".join(found[2].split()).replace("\\|", "|")

    def indented_blocks(self):
        """Yields blocks of lines that are indented by four spaces: code, and text of nested lists."""
        lines = self.visible.split("\n")
        block = None
        for number, line in enumerate(lines, start=1):
            if line.startswith("    ") and line.strip():
                if block is None:
                    block = Block(number, "", [])
                block.lines.append(line[4:])
            elif block is not None:
                yield block
                block = None
        if block is not None:
            yield block


def page_names(root):
    """Returns README.md and all pages of docs/, as paths from the root."""
    root = pathlib.Path(root)
    return ["README.md", *sorted(path.relative_to(root).as_posix() for path in (root / "docs").rglob("*.md"))]


def folder_of(name):
    """Returns the folder of a page in docs/, and "" for README.md."""
    parts = name.split("/")
    return parts[1] if len(parts) > 2 else ""
