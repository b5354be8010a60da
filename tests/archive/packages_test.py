#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the Debian packages, the wheel and the packages for npm from a finished build, and checks them.

  packages_test.py BUILD

The wheel bakes in a new virtual environment. A second run of tools/package, with other settings of the user, must write
the same bytes. Checks the hardening of all programs and libraries if the build is hardened (preset "package"). Without
the tools of tools/package, exits with code 77 (skipped).
"""
import json
import os
import pathlib
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
HARDENED = "MULTUM_HARDENING:BOOL=ON" in (BUILD / "CMakeCache.txt").read_text()
VERSION = re.search(r"project\(multum VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
RELEASE = platform.freedesktop_os_release()["VERSION_ID"]
UNIT = f"{'' if RELEASE == '12' else '/usr'}/lib/systemd/system/multum.service"
# Each package with files that it must contain. LIB is the folder of libraries, which depends on the build.
CONTENTS = {
    "multum": ("/usr/bin/multum", "/usr/bin/multum-view", "/usr/share/man/man1/multum-bake.1.gz",
               UNIT, "/usr/lib/sysusers.d/multum.conf", "/etc/multum/serve.toml",
               "/usr/share/bash-completion/completions/multum", "/usr/share/zsh/vendor-completions/_multum",
               "/usr/share/fish/vendor_completions.d/multum.fish",
               "/usr/share/multum/engines/import_into_unreal.py"),
    "libmultum1": ("/LIB/libmultum.so.1", "/LIB/libmultum.so.1.0.0", "/usr/libexec/multum/multum-decode",
                   "/usr/libexec/multum/multum-decode-libraries.so"),
    "libmultum-dev": ("/usr/include/multum.h", "/LIB/libmultum.so", "/LIB/pkgconfig/multum.pc",
                      "/LIB/cmake/multum/multumConfig.cmake", "/usr/share/doc/libmultum-dev/examples/bake.c"),
    "python3-multum": ("/usr/lib/python3/dist-packages/multum/__init__.py",
                       "/usr/lib/python3/dist-packages/multum/reader.py",
                       "/usr/lib/python3/dist-packages/multum/py.typed"),
    "multum-doc": ("/usr/share/doc/multum-doc/README.md",
                   "/usr/share/doc/multum-doc/docs/how-to/install_packages.md"),
}
WHEEL_BAKE = """
import sys, multum
assert multum.__file__.startswith(sys.prefix), multum.__file__
print(multum.bake("map_normal.png", "wheel.ndf.exr", green="up").content_hash)
print(multum.load("program.ndf.exr").content_hash)
"""


def run(*command, **options):
    made = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    if made.returncode != 0:
        raise AssertionError(f"{command}: exit code {made.returncode}\n{made.stdout[-3000:]}{made.stderr[-3000:]}")
    return made.stdout


def make_packages(output, **options):
    run(ROOT / "tools/package", "deb", "wheel", "npm", "--build", BUILD, "--output", output, **options)
    return sorted(output.iterdir())


def is_elf(file):
    with file.open("rb") as opened:
        return opened.read(4) == b"\x7fELF"


class PackagesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="multum-packages-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.files = make_packages(cls.folder / "packages")
        cls.unpacked = {}
        for file in cls.files:
            if file.suffix == ".deb":
                target = cls.folder / "unpacked" / file.name.split("_")[0]
                target.mkdir(parents=True)
                run("dpkg-deb", "-R", file, target)
                cls.unpacked[target.name] = target

    @classmethod
    def file(cls, pattern):
        found = [file for file in cls.files if file.match(pattern)]
        assert len(found) == 1, (pattern, cls.files)
        return found[0]

    def test_debian_packages_contain_their_files(self):
        self.assertEqual(sorted(self.unpacked), sorted(CONTENTS))
        library = next(self.unpacked["libmultum1"].rglob("libmultum.so.1")).parent
        library = str(library.relative_to(self.unpacked["libmultum1"]))
        for package, names in CONTENTS.items():
            for name in names:
                path = self.unpacked[package] / name.replace("/LIB", library).lstrip("/")
                self.assertTrue(path.is_symlink() or path.is_file(), f"{package}: {path}")
        self.assertEqual(len(list(self.unpacked["python3-multum"].rglob("_multum.*.so"))), 1)
        pages = {page.name for page in self.unpacked["multum"].rglob("*.1.gz")}
        commands = re.findall(r"^  ([a-z][a-z-]*)  ", run(BUILD / "bin/multum", "--help"), re.MULTILINE)
        self.assertGreater(len(commands), 20)
        for command in commands:
            self.assertIn(f"multum-{command}.1.gz", pages)

    def test_debian_packages_name_their_own_paths(self):
        unit = (self.unpacked["multum"] / UNIT.lstrip("/")).read_text()
        self.assertIn("\nExecStart=/usr/bin/multum serve ", unit)
        self.assertIn("\nReadWritePaths=-/srv/maps\n", unit)
        pkgconfig = next(self.unpacked["libmultum-dev"].rglob("multum.pc")).read_text()
        self.assertTrue(pkgconfig.startswith("prefix=/usr\n"), pkgconfig)

    def test_debian_packages_depend_on_each_other_in_one_version(self):
        revised = f"{VERSION}-1" if RELEASE == "12" else f"{VERSION}-1+deb{RELEASE}"
        for package, folder in self.unpacked.items():
            control = (folder / "DEBIAN/control").read_text()
            self.assertIn(f"\nVersion: {revised}\n", control)
            if package in ("multum", "libmultum-dev", "python3-multum"):
                self.assertIn(f"libmultum1 (= {revised})", control)

    def test_lintian_finds_no_error(self):
        if not shutil.which("lintian"):
            self.skipTest("lintian is not installed (Debian package lintian)")
        debs = [file for file in self.files if file.suffix == ".deb"]
        made = subprocess.run(["lintian", "--no-cfg", "--fail-on", "error", *debs], capture_output=True, text=True)
        self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
        print(made.stdout, end="")

    def test_programs_are_hardened(self):
        if not HARDENED:
            self.skipTest("this build is not hardened; the build of the preset package is")
        if not shutil.which("hardening-check"):
            self.skipTest("hardening-check is not installed (Debian package devscripts)")
        files = [file for folder in self.unpacked.values() for file in folder.rglob("*")
                 if file.is_file() and not file.is_symlink() and is_elf(file)]
        self.assertEqual(len(files), 5, files)
        for file in files:
            # No program of Debian 12 can have control-flow integrity, because its start-up code (crt1.o) has none. The
            # Python module calls only functions whose sizes are unknown to the compiler, so none can be fortified.
            left_out = ["--nocfprotection", *(["--nofortify"] if file.name.startswith("_multum.") else [])]
            made = subprocess.run(["hardening-check", *left_out, file], capture_output=True, text=True)
            self.assertEqual(made.returncode, 0, made.stdout)

    def test_no_file_contains_the_path_of_the_build(self):
        if not HARDENED:
            self.skipTest("only the preset package removes these paths")
        for folder in self.unpacked.values():
            for file in folder.rglob("*"):
                if file.is_file() and not file.is_symlink():
                    self.assertNotIn(str(ROOT).encode(), file.read_bytes(), file)

    def test_wheel_bakes_in_a_new_environment(self):
        place = self.folder / "venv_work"
        place.mkdir()
        run("/usr/bin/python3", "-m", "venv", "--system-site-packages", self.folder / "venv")
        python = self.folder / "venv/bin/python"
        run(python, "-m", "pip", "install", "--no-index", "--disable-pip-version-check", self.file("*.whl"))
        run(BUILD / "bin/multum", "testmap", "map", "--size", "64", cwd=place)
        run(BUILD / "bin/multum", "bake", "map_normal.png", "-o", "program.ndf.exr", "--green", "up", cwd=place)
        environment = {name: value for name, value in os.environ.items()
                       if name not in ("PYTHONPATH", "LD_LIBRARY_PATH")}
        hashes = run(python, "-c", WHEEL_BAKE, cwd=place, env=environment).split()
        self.assertEqual(len(hashes), 2)
        self.assertEqual(hashes[0], hashes[1])

    def test_npm_packages_contain_their_modules(self):
        place = self.folder / "npm"
        place.mkdir()
        for name in ("three", "gltf-transform"):
            source = ROOT / "runtime_gl/web" / name.replace("-", "_")
            archive = self.file(f"multum-{name}-*.tgz")
            with tarfile.open(archive) as tar:
                names = {file.removeprefix("package/") for file in tar.getnames()}
                description = json.load(tar.extractfile("package/package.json"))
            self.assertEqual(names, {str(path.relative_to(source)) for path in source.rglob("*") if path.is_file()})
            self.assertEqual((description["name"], description["version"]), (f"@multum/{name}", VERSION))
            # The packages that it extends are not installed; npm must not search for them.
            run("npm", "install", "--offline", "--legacy-peer-deps", "--no-audit", "--no-fund", "--prefix", place,
                archive)
            self.assertTrue((place / "node_modules/@multum" / name / "index.js").is_file())

    def test_bill_lists_every_licence_of_the_wheel(self):
        bill = json.loads(self.file("*.spdx.json").read_text())
        self.assertEqual(bill["spdxVersion"], "SPDX-2.3")
        listed = {package["name"] for package in bill["packages"]}
        with tempfile.TemporaryDirectory() as temporary:
            shutil.unpack_archive(self.file("*.whl"), temporary, "zip")
            licences = {text.stem for text in pathlib.Path(temporary).glob("multum/lib/licences/*.txt")}
        self.assertGreater(len(licences), 20)
        self.assertEqual(licences - listed, set())
        self.assertLessEqual({"libopenexr-3-1-30", "pybind11-dev"}, listed)
        self.assertTrue(any(name.startswith("libopenimageio2.") for name in listed), listed)

    def test_a_second_run_gives_the_same_bytes(self):
        environment = dict(os.environ, TZ="Asia/Kathmandu", LC_ALL="C", HOME=str(self.folder))
        again = make_packages(self.folder / "again", env=environment, umask=0o077)
        self.assertEqual([file.name for file in again], [file.name for file in self.files])
        for first, second in zip(self.files, again):
            self.assertEqual(first.read_bytes(), second.read_bytes(), first.name)


if __name__ == "__main__":
    for tool in ("dh", "dh_python3", "fakeroot", "patchelf", "npm"):
        if not shutil.which(tool):
            print(f"packages_test: skipped: {tool} is not installed")
            sys.exit(77)
    sys.exit(unittest.main(argv=sys.argv[:1] + sys.argv[2:], verbosity=2))
