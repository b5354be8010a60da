#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a C++ file that contains the bytes of files, so that a program can run without these files.

As a table, a function that returns std::map<std::string, std::string_view> by the files' names:
  embed_files.py OUTPUT.cpp --header HEADER --function web_files FOLDER FILE...
or as variables, `const char* const shader_scene_vert` for scene.vert:
  embed_files.py OUTPUT.cpp --header HEADER --variables shader_ FOLDER FILE...
With --flatten-into FOLDER, the first #include of each file is replaced with its text, and FOLDER also keeps the
results. Kernels need this option, because drivers do not search folders, and linking separately compiled programs takes
0.4 s at every start.
"""
import argparse
import pathlib
import re

INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"')
# Compilers warn about "??=" and similar sequences, because they were trigraphs in earlier standards.
ESCAPES = {ord("\n"): "\\n", ord('"'): '\\"', ord("\\"): "\\\\", ord("?"): "\\?"}


def flatten(folder, name, seen):
    """Returns the source of `name`, in which the first include of each file is replaced with the file. Because of
    #line, error messages name the original files."""
    if name in seen:
        return []
    seen.add(name)
    lines = [f'#line 1 "{name}"']
    for number, line in enumerate((folder / name).read_text().splitlines(), start=1):
        match = INCLUDE.match(line)
        if match:
            lines += flatten(folder, match.group(1), seen)
            lines.append(f'#line {number + 1} "{name}"')
        else:
            lines.append(line)
    return lines


def literal(content):
    """Returns string literals, one per line of the file, which compilers join. Octal escapes end after three digits."""
    def escaped(line):
        return "".join(ESCAPES.get(byte) or (chr(byte) if 32 <= byte < 127 else f"\\{byte:03o}") for byte in line)
    return "\n".join(f'    "{escaped(line)}"' for line in content.splitlines(keepends=True)) or '    ""'


def identifier(name):
    return re.sub("[^A-Za-z0-9]", "_", name)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("files", nargs="+", help="names below FOLDER")
    parser.add_argument("--header", required=True, help="the header that declares the function or the variables")
    parser.add_argument("--namespace", default="multum")
    parser.add_argument("--flatten-into", type=pathlib.Path)
    form = parser.add_mutually_exclusive_group(required=True)
    form.add_argument("--function", help="its name")
    form.add_argument("--variables", metavar="PREFIX")
    arguments = parser.parse_args()

    contents = {}
    for name in sorted(arguments.files):
        if arguments.flatten_into is None:
            contents[name] = (arguments.folder / name).read_bytes()
            continue
        contents[name] = ("\n".join(flatten(arguments.folder, name, set())) + "\n").encode()
        arguments.flatten_into.mkdir(parents=True, exist_ok=True)
        (arguments.flatten_into / name).write_bytes(contents[name])
    if arguments.function:
        entries = "".join(f'  {{"{name}",\n{literal(content)}sv}},\n' for name, content in contents.items())
        body = (f"const std::map<std::string, std::string_view>& {arguments.function}() {{\n"
                "  using namespace std::literals;\n"
                f"  static const std::map<std::string, std::string_view> files = {{\n{entries}  }};\n"
                "  return files;\n}\n")
    else:
        body = "\n".join(f"const char* const {arguments.variables}{identifier(name)} =\n{literal(content)};\n"
                         for name, content in contents.items())
    arguments.output.write_text(f'// Made by tools/embed_files.py.\n#include "{arguments.header}"\n\n'
                                f"namespace {arguments.namespace} {{\n\n{body}\n"
                                f"}}  // namespace {arguments.namespace}\n")


if __name__ == "__main__":
    main()
