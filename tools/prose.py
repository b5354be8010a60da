# SPDX-License-Identifier: Apache-2.0
"""Finds the prose of a project: paragraphs of documents, comments of sources, and strings that people read."""
import ast
import io
import re
import tokenize

SLASHES = (".h", ".cpp", ".cl", ".clh", ".glsl", ".vert", ".frag", ".js", ".mjs")
WORDS_MIN = 4  # shorter strings are names, keys and formats
STRING = re.compile(r'"(?:[^"\\\n]|\\.)*"')
# The parts of a document that are not prose, which are code, HTML comments and generated figures. Their line breaks are
# kept.
NO_PROSE = re.compile(r"```.*?^\s*```|<!--.*?-->|^(?:    |\t).*?$", re.DOTALL | re.MULTILINE)


def spoken(text):
    """Returns text without code spans, targets of links and repeated spaces."""
    text = re.sub(r"`[^`]*`", "CODE", text)
    return " ".join(re.sub(r"\]\([^)]*\)", "]", text).split())


def document_paragraphs(text):
    text = NO_PROSE.sub(lambda found: "\n" * found[0].count("\n"), text)
    for block in re.finditer(r"(?:[^\n]+\n?)+", text):
        line = text.count("\n", 0, block.start()) + 1
        for part in re.split(r"\n(?=\s*[-*] |\s*\d+\. |\||#)", block[0]):
            yield line, spoken(part)
            line += part.count("\n") + 1


def comment_start(line):
    """Returns the column of `//` outside of strings, or -1."""
    quote, column = "", 0
    while column < len(line):
        letter = line[column]
        if quote:
            column += letter == "\\"
            quote = "" if letter == quote else quote
        elif letter in "\"'`":
            quote = letter
        elif line.startswith("//", column):
            return column
        column += 1
    return -1


def joined_comments(comments):
    """Joins neighbouring comments of one column into paragraphs. `comments` are (line, column, text without its
    mark)."""
    paragraph, begin, last, at = [], 0, -2, -1
    for line, column, text in comments:
        if paragraph and (line != last + 1 or column != at):
            yield begin, spoken(" ".join(paragraph))
            paragraph = []
        if not paragraph:
            begin, at = line, column
        if "SPDX" not in text and "NOLINT" not in text:
            paragraph.append(text.strip())
        last = line
    if paragraph:
        yield begin, spoken(" ".join(paragraph))


def slash_comments(text):
    for number, line in enumerate(text.splitlines(), start=1):
        column = comment_start(line)
        if column >= 0:
            yield number, column, line[column:].lstrip("/").lstrip("<")


def hash_comments(text):
    for number, line in enumerate(text.splitlines(), start=1):
        found = re.match(r"(\s*)#(?!!)(.*)", line)
        if found:
            yield number, len(found[1]), found[2]


def strings(text):
    """Yields strings in double quotes. Adjacent strings are joined."""
    for found in re.finditer(rf'{STRING.pattern}(?:\s*f?{STRING.pattern})*', text):
        words = "".join(part[1:-1] for part in STRING.findall(found[0]))
        if len(re.findall(r"[A-Za-z]{2,}", words)) >= WORDS_MIN:
            yield text.count("\n", 0, found.start()) + 1, spoken(re.sub(r"\\[nt]", " ", words))


def python_prose(text):
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    except (tokenize.TokenError, IndentationError):
        return
    yield from joined_comments([(t.start[0], t.start[1], t.string.lstrip("#")) for t in tokens
                                if t.type == tokenize.COMMENT and not t.string.startswith("#!")])
    for token in tokens:
        if token.type != tokenize.STRING:
            continue
        try:
            value = ast.literal_eval(token.string.lstrip("fF"))
        except (SyntaxError, ValueError):
            continue
        if isinstance(value, str) and len(re.findall(r"[A-Za-z]{2,}", value)) >= WORDS_MIN:
            yield token.start[0], spoken(value)


def prose(file, text):
    """Yields (line, paragraph) for all prose in the file with this text: documents, comments, and strings of at least
    four
    words. Code spans read CODE."""
    if file.suffix == ".md":
        yield from document_paragraphs(text)
    elif file.suffix in SLASHES:
        yield from joined_comments(slash_comments(text))
        if file.suffix in (".h", ".cpp"):
            yield from strings(text)
    elif file.suffix == ".py" or text.startswith("#!/usr/bin/env python"):
        yield from python_prose(text)
    elif file.suffix in ("", ".txt", ".cmake"):
        yield from joined_comments(hash_comments(text))
