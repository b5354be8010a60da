#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that a program gets the bytes of the files that tools/embed_files.py has embedded in it. embed_files_test.py
C++-COMPILER"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "tools/embed_files.py"
COMPILER = "c++"


class EmbeddingTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(subprocess.run, ["rm", "-r", self.folder])

    def embed(self, *arguments, files):
        for name, content in files.items():
            path = self.folder / "in" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        subprocess.run([sys.executable, SCRIPT, self.folder / "out.cpp", "--header", "out.h", *arguments,
                        self.folder / "in", *(name for name in files if not name.endswith(".clh"))], check=True)

    def compiled_output(self, header, main):
        """Compiles main with the embedded files, with warnings as errors, and returns its output."""
        (self.folder / "out.h").write_text(header)
        (self.folder / "main.cpp").write_text('#include <iostream>\n#include "out.h"\nint main() { ' + main + " }")
        program = self.folder / "program"
        subprocess.run([COMPILER, "-std=c++20", "-Wall", "-Wextra", "-Werror", "-I", self.folder, "-o", program,
                        self.folder / "main.cpp", self.folder / "out.cpp"], check=True)
        return subprocess.run([program], check=True, capture_output=True).stdout

    def test_every_byte_comes_back(self):
        content = bytes(range(256)) + b'"; )R" \\n ??= \0000 \r\n no end of a line'
        self.embed("--function", "files", files={"a/b.js": content, "empty": b""})
        header = ("#include <map>\n#include <string>\n#include <string_view>\nnamespace multum {\n"
                  "const std::map<std::string, std::string_view>& files();\n}\n")
        main = 'std::cout << multum::files().at("a/b.js") << multum::files().at("empty") << multum::files().size();'
        self.assertEqual(self.compiled_output(header, main), content + b"2")

    def test_variables_are_called_by_their_files(self):
        name = "/".join(("common", "a.glsl"))
        self.embed("--variables", "shader_", "--namespace", "multum::gl", files={name: b"one\ntwo\n"})
        header = "namespace multum::gl {\nextern const char* const shader_common_a_glsl;\n}\n"
        self.assertEqual(self.compiled_output(header, "std::cout << multum::gl::shader_common_a_glsl;"), b"one\ntwo\n")

    def test_includes_are_flattened_once(self):
        files = {"k.cl": b'#include "a.clh"\n#include "b.clh"\nk\n', "a.clh": b"a\n",
                 "b.clh": b'#include "a.clh"\nb\n'}
        self.embed("--function", "files", "--flatten-into", self.folder / "flat", files=files)
        self.assertEqual((self.folder / "flat" / "k.cl").read_text().splitlines(), [
            '#line 1 "k.cl"', '#line 1 "a.clh"', "a", '#line 2 "k.cl"', '#line 1 "b.clh"', '#line 2 "b.clh"', "b",
            '#line 3 "k.cl"', "k"])


if __name__ == "__main__":
    COMPILER = sys.argv.pop(1) if len(sys.argv) > 1 else COMPILER
    unittest.main()
