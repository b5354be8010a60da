# SPDX-License-Identifier: Apache-2.0
"""Checks the links, anchors, command lines and code blocks of pages, and the number of words in each folder."""
import ast
import json
import os
import pathlib
import re
import tomllib

import command_lines
from markdown_pages import FOLDERS, Page, folder_of, page_names

LANGUAGES = {"sh", "bash", "text", "c", "cpp", "css", "csharp", "cmake", "diff", "dockerfile", "glsl", "hlsl", "html",
             "http", "ini", "java", "js", "json", "lua", "makefile", "metal", "nginx", "opencl", "python", "rust",
             "toml", "ts", "wgsl", "xml", "yaml"}
# The languages of code blocks with tables that scripts read.
TABLES = {"docs/contributing/ARCHITECTURE.md": {"districts", "layers", "headers", "programs", "exports", "folders"}}
# These pages name commands of earlier versions.
PAST_COMMANDS = {"docs/contributing/CHANGELOG.md"}
# Each limit applies to all of its folders together.
WORDS_MAX = {("tutorials", "how-to", "explanation"): 20_000, ("reference",): 30_000}


def link_faults(page, pages):
    """Finds dead links. `pages` has all pages by name, for their anchors."""
    for line, target in page.links():
        if re.match(r"[a-z][a-z+.-]*:", target):
            continue
        path, _, anchor = target.partition("#")
        if path.startswith("/"):
            yield line, f"the link {target} is absolute; write it relative to this page"
            continue
        name = os.path.normpath(os.path.join(os.path.dirname(page.name), path)) if path else page.name
        if name.startswith("..") or not (page.root / name).exists():
            yield line, f"the link {target} leads to {name}, which does not exist"
        elif anchor and name in pages and anchor not in pages[name].anchors():
            yield line, f"the link {target} leads to the heading #{anchor}, which {name} does not have"


def json_fault(text):
    """Returns the reason why a block is neither one JSON document nor one document per line, or None if it is valid."""
    try:
        json.loads(text)
        return None
    except ValueError as error:
        fault = str(error)
    try:
        for line in text.splitlines():
            if line.strip():
                json.loads(line)
        return None
    except ValueError:
        return fault


def syntax_fault(language, text):
    try:
        if language == "json":
            return json_fault(text)
        if language == "toml":
            tomllib.loads(text)
        if language == "python":
            ast.parse(text)
        return None
    except (ValueError, SyntaxError) as error:
        return str(error)


def block_faults(page):
    for block in page.blocks:
        language = block.language.partition(" ")[0]
        if not block.is_closed:
            yield block.line, "the code block does not end"
        elif not language:
            yield block.line, "the code block has no language; write ```sh, ```text or another one"
        elif language not in LANGUAGES | TABLES.get(page.name, set()):
            hint = "; write ```sh" if language in ("shell", "console") else ""
            yield block.line, f"the language {language} of the code block is unknown{hint}"
        else:
            fault = syntax_fault(language, "\n".join(block.lines))
            if fault is not None:
                yield block.line, (f"the {language} block cannot be parsed: {fault}; write ```text if the block is "
                                   "only a part of a file")


def shell_blocks(page):
    for block in page.blocks:
        if block.language in ("sh", "bash"):
            yield block.line + 1, block.lines
    for block in page.indented_blocks():
        is_drawing = any(re.search(r"\S {3,}[^#\s]", line) for line in block.lines)
        if command_lines.is_command(block.lines[0]) and not is_drawing:
            yield block.line, block.lines


def command_faults(page, programs):
    if page.name in PAST_COMMANDS:
        return
    for line, lines in shell_blocks(page):
        for offset, words in command_lines.shell_lines(lines):
            if words is None:
                yield line + offset, "a quotation in the command line does not end"
                continue
            for fault in command_lines.command_faults(page.root, programs, words):
                yield line + offset, fault
    for line, text in page.code_spans():
        if not command_lines.is_command(text):
            continue
        try:
            words = command_lines.words_of(text)
        except ValueError:
            continue
        for fault in command_lines.command_faults(page.root, programs, words):
            yield line, f"{fault} (in `{text}`)"


def check_pages(root, bin_folder):
    """Returns one line per fault, and the programs whose command lines were not checked because they are missing."""
    root = pathlib.Path(root)
    programs = command_lines.Programs(bin_folder)
    pages = {name: Page(root, name) for name in page_names(root)}
    faults = []
    for name, page in pages.items():
        found = [*link_faults(page, pages), *block_faults(page), *command_faults(page, programs)]
        faults += [f"{name}:{line}: {fault}" for line, fault in sorted(set(found))]
    return faults, sorted(programs.not_built)


def count_words(root):
    """Returns the words per folder, by page, as `wc -w` counts them: {"how-to": {"docs/how-to/plain_pyramids.md":
    1200}}."""
    root = pathlib.Path(root)
    words = {folder: {} for folder in ("", *FOLDERS)}
    for name in page_names(root):
        words.setdefault(folder_of(name), {})[name] = len((root / name).read_text().split())
    return words


def word_faults(words):
    for folders, limit in WORDS_MAX.items():
        count = sum(sum(words[folder].values()) for folder in folders)
        if count > limit:
            yield f"{' + '.join(f'docs/{folder}' for folder in folders)}: {count} words, at most {limit}"
