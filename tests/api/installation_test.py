#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Installs the library into a new folder. Compiles and runs the examples there, once with pkg-config and once with
CMake.

Usage: installation_test.py BUILD SOURCE EXAMPLE...
Also checks what the library exports and links, and that it runs without libOpenCL.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

BUILD, SOURCE, *EXAMPLES = map(pathlib.Path, sys.argv[1:])
CONSUMER = """cmake_minimum_required(VERSION 3.16)
project(consumer C CXX)
find_package(multum REQUIRED)
add_executable(memory {source})
target_link_libraries(memory PRIVATE multum::multum m)
"""
# Does not open libOpenCL, as on a machine that lacks it.
NO_OPENCL = """#define _GNU_SOURCE
#include <dlfcn.h>
#include <string.h>
void* dlopen(const char* name, int flags) {
  static void* (*next)(const char*, int);
  if (!next) next = (void* (*)(const char*, int))dlsym(RTLD_NEXT, "dlopen");
  return name && strstr(name, "libOpenCL") ? 0 : next(name, flags);
}
"""


def finished(*command, **options):
    """Runs a command. If the library asks for POCL_WORK_GROUP_METHOD, sets it and runs the command again."""
    words = [str(word) for word in command]
    made = subprocess.run(words, capture_output=True, text=True, check=False, **options)
    wanted = re.search(r"expected (POCL_WORK_GROUP_METHOD)=(\w+) before the process starts", made.stderr)
    if wanted and wanted[1] not in os.environ and "env" not in options:
        os.environ[wanted[1]] = wanted[2]
        made = subprocess.run(words, capture_output=True, text=True, check=False, **options)
    return made


def run(*command, **options):
    made = finished(*command, **options)
    if made.returncode != 0:
        raise AssertionError(f"{command}: exit code {made.returncode}\n{made.stdout[-2000:]}{made.stderr[-2000:]}")
    return made.stdout


class InstallationTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="multum-installation-")
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.prefix = cls.folder / "prefix"
        for component in ("library", "development"):
            run("cmake", "--install", BUILD, "--prefix", cls.prefix, "--component", component)
        cls.libraries = next(cls.prefix.rglob("libmultum.so.1")).parent
        for example in EXAMPLES:
            cls.compile(example)
        cls.map = cls.folder / "map_normal.png"
        run(BUILD / "bin/multum", "testmap", "--size", "64", "--write-green", "up", "-o", cls.folder / "map")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def compile(cls, example):
        """Compiles an example as its comment says. The prefix was moved, as in an unpacked archive."""
        flags = run("pkg-config", "--define-prefix", "--cflags", "--libs", "multum",
                    env=dict(os.environ, PKG_CONFIG_PATH=str(cls.libraries / "pkgconfig"))).split()
        compiler = ["c++", "-std=c++17"] if example.suffix == ".cpp" else ["cc", "-std=c99"]
        run(*compiler, "-Wall", "-Wextra", "-Werror", "-pedantic", example, "-o", cls.folder / example.stem, *flags,
            "-lm", f"-Wl,-rpath,{cls.libraries}")

    def test_examples_are_short(self):
        for example in EXAMPLES:
            self.assertLessEqual(len(example.read_text().splitlines()), 60, example)

    def test_bake_and_shade(self):
        baked = self.folder / "a.ndf.exr"
        out = run(self.folder / "bake", self.map, baked)
        self.assertIn("level 6: 1 x 1 texels", out)
        self.assertIn("4 lobes per texel", out)
        means = [float(v) for v in re.findall(r": (\d+\.\d+), variance", run(self.folder / "shade", baked))]
        variances = [float(v) for v in re.findall(r"variance (\d+\.\d+)", run(self.folder / "shade", baked))]
        self.assertAlmostEqual(means[0] / means[1], 1.0, delta=0.05)
        self.assertLess(variances[0], variances[1])

    def test_errors_are_told(self):
        made = finished(self.folder / "bake", "/nowhere.png", self.folder / "b.ndf.exr")
        self.assertEqual(made.returncode, 3)
        self.assertIn("/nowhere.png", made.stderr)
        self.assertFalse((self.folder / "b.ndf.exr").exists())

    def test_memory_by_cmake(self):
        source = self.folder / "consumer"
        source.mkdir()
        example = next(e for e in EXAMPLES if e.name == "memory.c").resolve()
        (source / "CMakeLists.txt").write_text(CONSUMER.format(source=example))
        run("cmake", "-S", source, "-B", source / "build", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        run("cmake", "--build", source / "build")
        out = run(source / "build/memory")
        amplitudes = [float(v) for v in re.findall(r"amplitude (\d\.\d+)", out)]
        self.assertAlmostEqual(sum(amplitudes), 1.0, delta=0.03)

    def test_reading_and_shading_without_opencl(self):
        baked = self.folder / "c.ndf.exr"
        run(self.folder / "bake", self.map, baked)
        (self.folder / "no_opencl.c").write_text(NO_OPENCL)
        shim = self.folder / "no_opencl.so"
        run("cc", "-shared", "-fPIC", self.folder / "no_opencl.c", "-o", shim, "-ldl")
        environment = dict(os.environ, LD_PRELOAD=str(shim))
        self.assertIn("sampling lobes", run(self.folder / "shade", baked, env=environment))
        made = subprocess.run([self.folder / "bake", self.map, self.folder / "d.ndf.exr"], capture_output=True,
                              text=True, env=environment)
        self.assertEqual(made.returncode, 4, made.stderr)
        self.assertIn("no OpenCL device found", made.stderr)
        self.assertNotIn("libOpenCL", run("readelf", "-d", self.libraries / "libmultum.so.1"))

    def test_exports_only_the_functions_of_the_header(self):
        header = (SOURCE / "host/api/multum.h").read_text()
        declared = set(re.findall(r"^MULTUM_API[^;(]*?\b(multum_\w+)\(", header, re.MULTILINE))
        self.assertGreater(len(declared), 35)
        exported = run("nm", "-D", "--defined-only", "--format=posix", self.libraries / "libmultum.so.1").splitlines()
        names = {line.split()[0].split("@")[0] for line in exported if line.split()[1] != "A"}
        self.assertEqual(names, declared)
        for line in exported:
            if line.split()[1] != "A":
                self.assertTrue(line.split()[0].endswith("@@MULTUM_1"), line)

    def test_neither_ends_the_process_nor_changes_its_environment(self):
        imported = run("nm", "-D", "--undefined-only", "--format=posix", self.libraries / "libmultum.so.1")
        names = {line.split()[0].split("@")[0] for line in imported.splitlines()}
        for name in ("abort", "exit", "setenv", "putenv", "unsetenv", "printf", "puts", "perror"):
            self.assertTrue(name not in names, name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
