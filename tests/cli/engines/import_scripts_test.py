#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the import scripts of tools/engines with files of `multum export`, without the engines, which are not free.
unreal_stand_in.py and unity_stand_in.cs declare what the scripts use. They record the values that the engine would
receive. So the tests cover the scripts themselves, not the engines.

  import_scripts_test.py MULTUM [unittest's arguments]
"""
import contextlib
import os
import pathlib
import runpy
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

MULTUM = ""
HERE = pathlib.Path(__file__).resolve().parent
SCRIPTS = HERE.parents[2] / "tools/engines"
HEAD_BYTES = 148
sys.path.insert(0, str(HERE))


class EngineTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="multum_engines_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.run_multum("testmap", "rock", "--size", 32, "--write-green", "up")

    @classmethod
    def run_multum(cls, *words):
        subprocess.run([MULTUM, *map(str, words)], cwd=cls.folder, check=True, capture_output=True)

    def export(self, engine, output, *options):
        self.run_multum("export", "rock_normal.png", "-o", output, "--green", "up", "--for", engine, "--no-measure",
                        *options)


class UnrealTest(EngineTest):
    def imported(self, folder):
        """Runs the script, and returns the stand-in for Unreal with all that it recorded."""
        import unreal_stand_in as unreal
        unreal.reset()
        arguments, sys.argv = sys.argv, ["import_into_unreal.py", str(self.folder / folder), "/Game/Rocks"]
        sys.modules["unreal"] = unreal
        try:
            with contextlib.redirect_stdout(None):
                runpy.run_path(str(SCRIPTS / "import_into_unreal.py"), run_name="__main__")
        finally:
            sys.argv = arguments
            del sys.modules["unreal"]
        return unreal

    def test_keeps_levels_and_data(self):
        self.export("unreal", "good/rock.dds")
        unreal = self.imported("good")
        self.assertEqual(unreal.errors, [])
        self.assertEqual(sorted(unreal.textures), ["/Game/Rocks/T_rock_N", "/Game/Rocks/T_rock_ORM"])
        for path, texture in unreal.textures.items():
            self.assertEqual(texture.values["mip_gen_settings"], "TMGS_LEAVE_EXISTING_MIPS")
            self.assertIs(texture.values["srgb"], False)
            self.assertIs(texture.values["flip_green_channel"], False)
            self.assertEqual(texture.values["compression_settings"],
                             "TC_NORMALMAP" if path.endswith("_N") else "TC_MASKS")
            self.assertTrue(texture.is_saved)

    def test_skips_what_unreal_would_spoil(self):
        self.export("unreal", "bad/blocks.dds", "--texels", "bc")
        self.export("unreal", "bad/cut.dds")
        path = self.folder / "bad/T_cut_N.dds"
        content = bytearray(path.read_bytes())
        struct.pack_into("<I", content, 28, 3)  # the number of levels
        path.write_bytes(content)
        (self.folder / "bad/T_text_N.dds").write_text("no picture")
        (self.folder / "bad/odd.dds").write_bytes((self.folder / "bad/T_cut_ORM.dds").read_bytes())
        unreal = self.imported("bad")
        self.assertEqual(list(unreal.textures), ["/Game/Rocks/T_cut_ORM"])
        self.assertEqual(len(unreal.errors), 5)
        for name, part in (("T_blocks_N", "--texels rgba8"), ("T_blocks_ORM", "--texels rgba8"),
                           ("T_cut_N", "3 levels; expected 6"), ("T_text_N", "DX10 header"),
                           ("odd.dds", "no known end")):
            self.assertTrue(any(name in error and part in error for error in unreal.errors), (name, unreal.errors))


class UnityTest(EngineTest):
    """Compiles the importer with Mono, and compares what it passes to Unity with the rows of the file."""

    @classmethod
    def setUpClass(cls):
        if shutil.which("mcs") is None:
            raise unittest.SkipTest("no C# compiler: Debian package mono-mcs")
        super().setUpClass()
        cls.program = cls.folder / "importer.exe"
        subprocess.run(["mcs", f"-out:{cls.program}", HERE / "unity_stand_in.cs", SCRIPTS / "MultumImporter.cs"],
                       check=True)

    def imported(self, file, storage="AsInFile"):
        output = self.folder / "rows.bin"
        run = subprocess.run(["mono", self.program, self.folder / file, storage, output], check=True,
                             capture_output=True, text=True)
        return run.stdout.split("\n"), output.read_bytes() if output.exists() else b""

    def test_keeps_levels_and_turns_rows_round(self):
        self.export("unity", "unity/rock.dds")
        for name in ("rock_Normal", "rock_MaskMap"):
            said, rows = self.imported(f"unity/{name}.dds")
            self.assertEqual(said[0], f"{name} RGBA32 32 32 6 linear", said)
            stored = (self.folder / f"unity/{name}.dds").read_bytes()[HEAD_BYTES:]
            turned, at = b"", 0
            for level in range(6):
                side = 32 >> level
                lines = [stored[at + 4 * side * y:at + 4 * side * (y + 1)] for y in range(side)]
                turned += b"".join(reversed(lines))
                at += 4 * side * side
            self.assertEqual(rows, turned)
        self.assertIn("compressed BC7", self.imported("unity/rock_MaskMap.dds", "BC7")[0])

    def test_says_what_it_cannot_read(self):
        self.export("unity", "blocks/rock.dds", "--texels", "bc")
        self.assertIn("--texels rgba8", self.imported("blocks/rock_Normal.dds")[0][0])
        whole = self.folder / "unity_cut.dds"
        self.export("unity", "cut/rock.dds")
        whole.write_bytes((self.folder / "cut/rock_Normal.dds").read_bytes()[:-1])
        self.assertIn("expected", self.imported("unity_cut.dds")[0][0])
        whole.write_bytes(b"DDS ")
        self.assertIn("DX10 header", self.imported("unity_cut.dds")[0][0])


if __name__ == "__main__":
    MULTUM = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=2)
