#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/check_layering, tools/check_style.py and tools/check_paths find each kind of planted violation, and pass a
clean tree."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LICENCE = "// SPDX-License-Identifier: Apache-2.0\n"


class CheckToolsTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        self.write("docs/ARCHITECTURE.md", (ROOT / "docs/ARCHITECTURE.md").read_text())
        self.write("host/base/error.h", LICENCE + "// Errors.\n#pragma once\n#include <string>\n")
        self.write("host/asset/lobes/movmf_mipmap.h",
                   LICENCE + "// Lobes.\n#include <string>\n#include <glm/vec3.hpp>\n")
        self.write("host/bake/bake.cpp", LICENCE + '// A bake.\n#include "host/asset/lobes/movmf_mipmap.h"\n')
        self.write("host/bake/CMakeLists.txt", "# SPDX-License-Identifier: Apache-2.0\nadd_library(b bake.cpp)\n")

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def run_tool(self, tool, *arguments):
        run = subprocess.run([sys.executable, ROOT / "tools" / tool, "--root", self.root, *arguments],
                             capture_output=True, text=True, check=False)
        return run.returncode, run.stdout + run.stderr

    def expect_violation(self, tool, *words, options=()):
        code, output = self.run_tool(tool, *options)
        self.assertEqual(code, 1, output)
        for word in words:
            self.assertIn(word, output)
        self.assertEqual(len(output.splitlines()), 1, output)

    def test_clean_tree_passes(self):
        for tool in ("check_layering", "check_style.py"):
            self.assertEqual(self.run_tool(tool), (0, ""))

    def test_include_against_the_arrow(self):
        self.write("host/asset/bad.h", LICENCE + '// x\n#include "host/bake/bake.h"\n')
        self.expect_violation("check_layering", "host/asset/bad.h:3", "host/asset includes host/bake/bake.h")

    def test_relative_include_against_the_arrow(self):
        self.write("host/asset/bad.h", LICENCE + '// x\n#include "../bake/bake.cpp"\n')
        self.expect_violation("check_layering", "host/asset includes host/bake/bake.cpp")

    def test_runtime_may_not_see_the_bake(self):
        self.write("runtime_gl/gl/bad.cpp", LICENCE + '// x\n#include "host/opencl/device.h"\n')
        self.expect_violation("check_layering", "runtime_gl includes host/opencl/device.h")

    def test_only_agreement_tests_see_both_worlds(self):
        self.write("tests/unit/bad.cpp", LICENCE + '// x\n#include "runtime_gl/gl/mesh.h"\n')
        self.write("tests/agreement/good.cpp", LICENCE + '// x\n#include "runtime_gl/gl/mesh.h"\n')
        self.expect_violation("check_layering", "tests/unit/bad.cpp", "runtime_gl/gl/mesh.h")

    def test_foreign_header_in_the_wrong_folder(self):
        for header in ("CL/cl.h", "GL/glcorearb.h", "EGL/egl.h", "OpenImageIO/imageio.h", "ImfHeader.h",
                       "assimp/scene.h", "openssl/evp.h", "CLI/CLI.hpp"):
            with self.subTest(header=header):
                self.write("host/bake/bad.h", LICENCE + f"// x\n#include <{header}>\n")
                self.expect_violation("check_layering", "host/bake/bad.h:3", header)

    def test_unknown_header(self):
        self.write("host/bake/bad.h", LICENCE + "// x\n#include <folly/Any.h>\n")
        self.expect_violation("check_layering", "folly/Any.h", "no row")

    def test_folder_without_layer(self):
        self.write("host/surprise/bad.h", LICENCE + "// x\n")
        self.expect_violation("check_layering", "host/surprise/bad.h", "no row in the layer table")

    def test_link_against_the_arrow(self):
        self.write("host/image/CMakeLists.txt", "# x\nmultum_library(multum_image PUBLIC multum_base multum_opencl)\n")
        self.expect_violation("check_layering", "host/image/CMakeLists.txt:2", "links multum_opencl")

    def test_row_that_nothing_needs(self):
        headers, programs = "```headers\nglm/ host\n```\n", "```programs\n```\n"
        for layers, words in (
                ("host/base -\nhost/asset host/base\nhost/bake host/asset", ("host/asset allows host/base",)),
                ("host/base -\nhost/asset host/gone\nhost/bake host/asset", ("host/gone", "no folder")),
                ("host/base -\nhost/asset -\nhost/bake host/asset\nhost/gone -", ("host/gone", "no folder"))):
            with self.subTest(layers=layers):
                self.write("docs/ARCHITECTURE.md", f"```layers\n{layers}\n```\n{headers}{programs}")
                self.assertEqual(self.run_tool("check_layering"), (0, ""))
                code, output = self.run_tool("check_layering", "--rows")
                self.assertEqual(code, 1, output)
                for word in words:
                    self.assertIn(word, output)
        rows = "```layers\nhost/base -\nhost/asset -\nhost/bake host/asset\n```\n"
        self.write("docs/ARCHITECTURE.md", rows + headers + programs)
        self.assertEqual(self.run_tool("check_layering", "--rows"), (0, ""))
        self.write("docs/ARCHITECTURE.md", rows + headers.replace("host", "host tests") + programs)
        self.expect_violation("check_layering", "glm/ allows tests", options=["--rows"])

    def test_rows_that_lead_in_a_circle(self):
        self.write("docs/ARCHITECTURE.md", "```layers\nhost/base -\nhost/asset host/bake\nhost/bake host/asset\n```\n"
                   "```headers\nglm/ host\n```\n```programs\n```\n")
        self.write("host/asset/back.h", LICENCE + '// x\n#include "host/bake/bake.cpp"\n')
        code, output = self.run_tool("check_layering", "--rows")
        self.assertEqual((code, len(output.splitlines())), (1, 2), output)
        self.assertIn("the row of host/bake leads back to it", output)

    def test_folder_of_many_files(self):
        for number in range(38):
            self.write(f"host/bake/unit_{number}.h", LICENCE + "// x\n")
        self.assertEqual(self.run_tool("check_layering"), (0, ""))
        self.write("host/bake/unit_38.h", LICENCE + "// x\n")
        self.expect_violation("check_layering", "host/bake:1", "41 files")

    def test_program_that_links_what_it_must_not(self):
        (self.root / "bin").mkdir()
        program = self.root / "bin/multum"
        library = self.root / "libEGL.so"
        subprocess.run(["cc", "-shared", "-fPIC", "-x", "c", "-", "-o", library], input="int f(void) { return 0; }",
                       text=True, check=True)
        subprocess.run(["cc", "-x", "c", "-", "-o", program, f"-L{self.root}", "-lEGL"],
                       input="extern int f(void); int main(void) { return f(); }", text=True, check=True)
        code, output = self.run_tool("check_layering", "--programs", self.root / "bin")
        self.assertEqual(code, 1, output)
        self.assertIn("multum: links libEGL.so", output)

    def test_marks_licence_comment_and_length(self):
        mark = "FIX" + "ME"
        for text, words in ((LICENCE + f"// x {mark}\n", (":2", mark)),
                            ("// A header.\n\n\n" + LICENCE, (":1", "SPDX")),
                            (LICENCE + "#pragma once\n", (":1", "no comment")),
                            (LICENCE + "// x" + "y" * 117 + "\n", (":2", "121 characters"))):
            with self.subTest(words=words):
                self.write("host/base/bad.h", text)
                self.expect_violation("check_style.py", "host/base/bad.h", *words)

    def test_header_that_opens_with_a_riddle(self):
        for word in ("What", "Where", "Which", "How", "That", "Whether", "Who", "As", "Of"):
            with self.subTest(word=word):
                self.write("host/base/bad.h", LICENCE + f"// {word} rows go.\n")
                self.expect_violation("check_style.py", "host/base/bad.h:2", f"'{word}'", "verb or noun first")
        for text in ("// Offers rows.\n// What they hold.\n", "// Assets of a map.\n", "// Rows. Of what: below.\n"):
            with self.subTest(text=text):
                self.write("host/base/bad.h", LICENCE + text)
                self.assertEqual(self.run_tool("check_style.py"), (0, ""))

    def test_dead_file(self):
        self.write("host/bake/old.cpp", LICENCE + "// x\n")
        self.expect_violation("check_style.py", "host/bake/old.cpp", "dead")

    def test_commented_out_file_is_dead(self):
        self.write("host/bake/old.cpp", LICENCE + "// x\n")
        self.write("host/bake/CMakeLists.txt", "# SPDX-License-Identifier: Apache-2.0\nx(bake.cpp)  # old.cpp\n")
        self.expect_violation("check_style.py", "host/bake/old.cpp", "dead")

    def test_unlisted_folder(self):
        self.write("tests/surprise/x.h", LICENCE + "// x\n")
        self.expect_violation("check_style.py", "tests/surprise: has no row")

    def test_unit_tests_mirror_rooms(self):
        self.write("tests/unit/asset/lobes/x.h", LICENCE + "// x\n")
        self.assertEqual(self.run_tool("check_style.py"), (0, ""))
        self.write("tests/unit/surprise/x.h", LICENCE + "// x\n")
        self.expect_violation("check_style.py", "tests/unit/surprise: has no row")

    def test_dead_paths(self):
        self.write("docs/ARCHITECTURE.md", "`host/bake`, `host/base/error.h`, `host/bake/bake`: `movmf_mipmap.h`.\n")
        self.write("host/base/good.h", LICENCE + "// As asset/lobes/movmf_mipmap.h and kernels/FILE.cl.\n"
                   'const char* text = "host/gone";\n')
        self.assertEqual(self.run_tool("check_paths"), (0, ""))
        for file, text, name in (("docs/PAGE.md", "See `host/gone/error.h`.\n", "host/gone/error.h"),
                                 ("docs/PAGE.md", "See `host/gone`: a folder.\n", "host/gone"),
                                 ("docs/PAGE.md", "host/base/errors has it.\n", "host/base/errors"),
                                 ("README.md", "The file `gone_file.h`.\n", "gone_file.h"),
                                 ("host/base/bad.h", LICENCE + "int x;  // host/base/gone.h\n", "host/base/gone.h"),
                                 ("host/base/bad.h", LICENCE + "// As bake/error.h has it.\n", "bake/error.h"),
                                 ("tools/bad.py", "# Reads tools/gone.py.\n", "tools/gone.py")):
            with self.subTest(name=name):
                self.write(file, text)
                self.expect_violation("check_paths", f"{file}:", f"names {name}, which does not exist")
                (self.root / file).unlink()


if __name__ == "__main__":
    unittest.main()
