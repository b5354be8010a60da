#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests that tools/check_layering, tools/check_style.py and tools/check_paths find each kind of planted violation and
accept a clean tree."""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LICENCE = "// SPDX-License-Identifier: Apache-2.0\n"
BESIDE, BUT = "be" "side", "but " "for"  # slips, split into pieces that do not match any pattern


class CheckToolsTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        tables = re.findall(r"^```.*?^```", (ROOT / "docs/contributing/ARCHITECTURE.md").read_text(), re.S | re.M)
        self.write("docs/contributing/ARCHITECTURE.md", "\n\n".join(tables))
        self.write("host/foundation/base/error.h", LICENCE + "// Errors.\n#pragma once\n#include <string>\n")
        self.write("host/formats/asset/lobes/movmf_mipmap.h",
                   LICENCE + "// Lobes.\n#include <string>\n#include <glm/vec3.hpp>\n")
        self.write("host/bakes/bake/bake.cpp",
                   LICENCE + '// A bake.\n#include "host/formats/asset/lobes/movmf_mipmap.h"\n')
        self.write("host/bakes/bake/CMakeLists.txt", "# SPDX-License-Identifier: Apache-2.0\nadd_library(b bake.cpp)\n")

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
        self.write("host/formats/asset/bad.h", LICENCE + '// x\n#include "host/bakes/bake/bake.h"\n')
        self.expect_violation("check_layering", "host/formats/asset/bad.h:3",
                              "host/formats/asset includes host/bakes/bake/bake.h")

    def test_relative_include_against_the_arrow(self):
        self.write("host/formats/asset/bad.h", LICENCE + '// x\n#include "../../bakes/bake/bake.cpp"\n')
        self.expect_violation("check_layering", "host/formats/asset includes host/bakes/bake/bake.cpp")

    def test_runtime_may_not_see_the_bake(self):
        self.write("runtime_gl/gl/bad.cpp", LICENCE + '// x\n#include "host/formats/opencl/device.h"\n')
        self.expect_violation("check_layering", "runtime_gl includes host/formats/opencl/device.h")

    def test_only_agreement_tests_see_both_worlds(self):
        self.write("tests/unit/bad.cpp", LICENCE + '// x\n#include "runtime_gl/gl/mesh.h"\n')
        self.write("tests/agreement/good.cpp", LICENCE + '// x\n#include "runtime_gl/gl/mesh.h"\n')
        self.expect_violation("check_layering", "tests/unit/bad.cpp", "runtime_gl/gl/mesh.h")

    def test_foreign_header_in_the_wrong_folder(self):
        for header in ("CL/cl.h", "GL/glcorearb.h", "EGL/egl.h", "OpenImageIO/imageio.h", "ImfHeader.h",
                       "assimp/scene.h", "openssl/evp.h", "CLI/CLI.hpp"):
            with self.subTest(header=header):
                self.write("host/bakes/bake/bad.h", LICENCE + f"// x\n#include <{header}>\n")
                self.expect_violation("check_layering", "host/bakes/bake/bad.h:3", header)

    def test_unknown_header(self):
        self.write("host/bakes/bake/bad.h", LICENCE + "// x\n#include <folly/Any.h>\n")
        self.expect_violation("check_layering", "folly/Any.h", "no row")

    def test_folder_without_layer(self):
        self.write("host/surprise/bad.h", LICENCE + "// x\n")
        self.expect_violation("check_layering", "host/surprise/bad.h", "no row in the layer table")

    def test_link_against_the_arrow(self):
        self.write("host/formats/image/CMakeLists.txt",
                   "# x\nmultum_library(multum_image PUBLIC multum_base multum_opencl)\n")
        self.expect_violation("check_layering", "host/formats/image/CMakeLists.txt:2", "links multum_opencl")

    def write_tables(self, layers, districts="", headers="glm/ host"):
        self.write("docs/contributing/ARCHITECTURE.md", f"```districts\n{districts}\n```\n```layers\n{layers}\n```\n"
                                           f"```headers\n{headers}\n```\n```programs\n```\n```exports\n```\n")

    def test_row_that_nothing_needs(self):
        base, asset, bake = "host/foundation/base", "host/formats/asset", "host/bakes/bake"
        for layers, words in ((f"{base} -\n{asset} {base}\n{bake} {asset}", (f"{asset} allows {base}",)),
                              (f"{base} -\n{asset} host/gone\n{bake} {asset}", ("host/gone", "not a folder")),
                              (f"{base} -\n{asset} -\n{bake} {asset}\nhost/gone -", ("host/gone", "not a folder"))):
            with self.subTest(layers=layers):
                self.write_tables(layers)
                self.assertEqual(self.run_tool("check_layering"), (0, ""))
                code, output = self.run_tool("check_layering", "--rows")
                self.assertEqual(code, 1, output)
                for word in words:
                    self.assertIn(word, output)
        rows = f"{base} -\n{asset} -\n{bake} \\\n {asset}"
        self.write_tables(rows)
        self.assertEqual(self.run_tool("check_layering", "--rows"), (0, ""))
        self.write_tables(rows, headers="glm/ host tests")
        self.expect_violation("check_layering", "glm/ allows tests", options=["--rows"])

    def test_rows_that_lead_in_a_circle(self):
        self.write_tables("host/foundation/base -\nhost/formats/asset host/bakes/bake\n"
                          "host/bakes/bake host/formats/asset")
        self.write("host/formats/asset/back.h", LICENCE + '// x\n#include "host/bakes/bake/bake.cpp"\n')
        code, output = self.run_tool("check_layering", "--rows")
        self.assertEqual((code, len(output.splitlines())), (1, 2), output)
        self.assertIn("the row of host/bakes/bake leads back to it", output)

    def test_districts(self):
        rows = "host/foundation/base -\nhost/formats/asset -\nhost/bakes/bake host/formats/asset"
        self.write_tables(rows, "host/formats -\nhost/bakes host/formats")
        self.assertEqual(self.run_tool("check_layering", "--rows"), (0, ""))
        self.write_tables(rows, "host/formats -\nhost/bakes -")
        self.expect_violation("check_layering", "the district host/bakes uses host/formats")
        self.write_tables(rows, "host/foundation -\nhost/formats host/foundation\nhost/bakes host/formats")
        self.expect_violation("check_layering", "host/formats allows host/foundation", options=["--rows"])
        self.write_tables(rows, "host/formats host/bakes\nhost/bakes host/formats")
        self.write("host/formats/CMakeLists.txt", "multum_library(multum_x PUBLIC multum_bake)\n")
        _, output = self.run_tool("check_layering", "--rows")
        self.assertIn("the row of host/formats leads back to it", output)

    def test_folder_of_many_files(self):
        for number in range(38):
            self.write(f"host/bakes/bake/unit_{number}.h", LICENCE + "// x\n")
        self.assertEqual(self.run_tool("check_layering"), (0, ""))
        self.write("host/bakes/bake/unit_38.h", LICENCE + "// x\n")
        self.expect_violation("check_layering", "host/bakes/bake:1", "41 files")

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
                self.write("host/foundation/base/bad.h", text)
                self.expect_violation("check_style.py", "host/foundation/base/bad.h", *words)

    # A slip, a bar, and a plain sentence that must not match any pattern.
    SLIPS = """
        What rows hold. | Rows that hold directions.
        Of rows the first. | Of course, the first row.
        How rows go. | How to write rows.
        Whether it is open. | Returns whether the file is open.
        Where rows go. | Where a map is flat, its lobes are equal.
        Stores 16 bytes a texel. | Stores 16 bytes per texel.
        It is no file of lobes. | There is no file. It is no longer there, and that is no reason to stop.
        Numbers that are none. | Unknown numbers.
        Reads the header alone, once. | Reads only the header, which can stand alone.
        The result is 5 % off. | The error is 5 %. The camera is near.
        The name stands in the report. | The report has the name.
        Written beside the output. | Written next to the output. See --beside.
        Equal but for rounding. | Equal except for rounding.
        The threads are the writer's. | They are the writer's threads.
        Unused maps are warned of. | Warns about unused maps.
        Serves who asks first. | Serves the client that asks first, a reader who waits.
        Levels are held to the map. | Levels are clamped to the map's range.
        Reads the file to its end. | Reads until the file ends.
        """

    def test_slips_of_english(self):
        for slip, plain in (row.strip().split(" | ") for row in self.SLIPS.strip().splitlines()):
            with self.subTest(slip=slip):
                for file in ("docs/PAGE.md", "host/foundation/base/bad.h"):
                    mark = "" if file.endswith(".md") else LICENCE + "// "
                    self.write(file, f"{mark}{slip}\n")
                    self.expect_violation("check_style.py", file, "write ")
                    self.write(file, f"{mark}{plain}\n")
                    self.assertEqual(self.run_tool("check_style.py"), (0, ""))

    def test_slips_in_strings_and_scripts(self):
        self.write("host/foundation/base/bad.h", LICENCE + f'// Text.\nchar t[] = "write it {BESIDE} the"\n "file";\n')
        self.expect_violation("check_style.py", "host/foundation/base/bad.h:3", "next to")
        self.write("host/foundation/base/bad.h", LICENCE + f"// Text.\nint {BESIDE};  // the `{BESIDE}` of rows\n")
        self.assertEqual(self.run_tool("check_style.py"), (0, ""))
        self.write("tools/bad.py", '# SPDX-License-Identifier: Apache-2.0\n'
                   f'"""A tool.\n\nIt goes {BESIDE} others."""\n')
        self.expect_violation("check_style.py", "tools/bad.py:2", "next to")

    def test_exceptions_have_a_reason_and_a_use(self):
        self.write("host/foundation/base/bad.h", LICENCE + f"// Equal {BUT} a sign.\n")
        self.write("tools/word_exceptions.txt", f"*\t{BUT} a sign\tquoted\n")
        self.assertEqual(self.run_tool("check_style.py"), (0, ""))
        self.write("host/foundation/base/bad.h", LICENCE + "// Equal.\n")
        self.expect_violation("check_style.py", f"'{BUT} a sign' is not in *")
        self.write("tools/word_exceptions.txt", f"*\t{BUT} a sign\n")
        code, output = self.run_tool("check_style.py")
        self.assertEqual((code, "expected 3" in output), (1, True), output)

    def test_dead_file(self):
        self.write("host/bakes/bake/old.cpp", LICENCE + "// x\n")
        self.expect_violation("check_style.py", "host/bakes/bake/old.cpp", "dead")

    def test_commented_out_file_is_dead(self):
        self.write("host/bakes/bake/old.cpp", LICENCE + "// x\n")
        self.write("host/bakes/bake/CMakeLists.txt", "# SPDX-License-Identifier: Apache-2.0\nx(bake.cpp)  # old.cpp\n")
        self.expect_violation("check_style.py", "host/bakes/bake/old.cpp", "dead")

    def test_unlisted_folder(self):
        self.write("tests/surprise/x.h", LICENCE + "// x\n")
        self.expect_violation("check_style.py", "tests/surprise: has no row")

    def test_unit_tests_mirror_rooms(self):
        self.write("tests/unit/formats/asset/lobes/x.h", LICENCE + "// x\n")
        self.assertEqual(self.run_tool("check_style.py"), (0, ""))
        self.write("tests/unit/surprise/x.h", LICENCE + "// x\n")
        self.expect_violation("check_style.py", "tests/unit/surprise: has no row")

    def test_dead_paths(self):
        self.write("docs/contributing/ARCHITECTURE.md", "`host/bakes/bake`, `host/foundation/base/error.h`, "
                                                        "`host/bakes/bake/bake`: "
                                           "`movmf_mipmap.h`.\n")
        self.write("host/foundation/base/good.h", LICENCE + "// As asset/lobes/movmf_mipmap.h and kernels/FILE.cl.\n"
                   'const char* text = "host/gone";\n')
        self.assertEqual(self.run_tool("check_paths"), (0, ""))
        for file, text, name in (("docs/PAGE.md", "See `host/gone/error.h`.\n", "host/gone/error.h"),
                                 ("docs/PAGE.md", "See `host/gone`: a folder.\n", "host/gone"),
                                 ("docs/PAGE.md", "host/foundation/base/errors has it.\n",
                                  "host/foundation/base/errors"),
                                 ("README.md", "The file `gone_file.h`.\n", "gone_file.h"),
                                 ("host/foundation/base/bad.h", LICENCE + "int x;  // host/foundation/base/gone.h\n",
                                  "host/foundation/base/gone.h"),
                                 ("host/foundation/base/bad.h", LICENCE + "// As bake/error.h has it.\n",
                                  "bake/error.h"),
                                 ("tools/bad.py", "# Reads tools/gone.py.\n", "tools/gone.py")):
            with self.subTest(name=name):
                self.write(file, text)
                self.expect_violation("check_paths", f"{file}:", f"names {name}, which does not exist")
                (self.root / file).unlink()


if __name__ == "__main__":
    unittest.main()
