# SPDX-License-Identifier: Apache-2.0
"""Makes a wheel that holds the Python package, libmultum, multum-decode and every library that they need, except for
the C library and the drivers of OpenCL.

  multum/                 the package; _multum.*.so finds the libraries in lib/
  multum/lib/             libmultum.so.1, multum-decode, and their libraries with their licences
  multum/lib/system/      libraries that are used only where the system lacks them
"""
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "archive"))
import stand_in_libraries  # noqa: E402
from gathered_libraries import (COMPILED_IN, SYSTEM_FIRST, SYSTEM_FOLDERS, closure, copy_licences, fail,  # noqa: E402
                                library_path, packages_of, place_with_path, version)

METADATA = """Metadata-Version: 2.1
Name: multum
Version: {version}
Summary: Bakes, reads and shades textures that look right at every distance
License: Apache-2.0
Requires-Python: =={python}.*
Requires-Dist: numpy>=1.20
Provides-Extra: progress
Requires-Dist: tqdm; extra == "progress"
Description-Content-Type: text/markdown

Bakes normal maps and height fields into mipmaps of distributions of normals, whose highlights neither sparkle nor go
dull when they are seen from afar. Bakes need an OpenCL driver of the machine, such as PoCL; reading and shading do not.
"""


def place_of(libraries, soname):
    return libraries / "system" / soname if SYSTEM_FIRST.match(soname) else libraries / soname


def fill(folder, build):
    """Fills the folder with the contents of a wheel, from a finished build."""
    source, package = build / "python/multum", folder / "multum"
    libraries = package / "lib"
    if not source.is_dir():
        fail(f"{source}: not found; build it first: cmake --build {build}")
    (libraries / "system").mkdir(parents=True)
    module = next(source.glob("_multum.*.so"))
    for file in sorted(source.iterdir()):
        if file.suffix in (".py", ".pyi", ".typed"):
            shutil.copyfile(file, package / file.name)
    place_with_path(module, package / module.name, ["$ORIGIN/lib", *SYSTEM_FOLDERS, "$ORIGIN/lib/system"])
    decoder = ("multum-decode", "multum-decode-libraries.so")
    real, stand_ins = closure([module, build / "lib/libmultum.so.1", *(build / "bin" / name for name in decoder)],
                              opened=("libOpenCL.so.1",), given=("libmultum.so.1",))
    # Drivers of OpenCL need the system's own copies of these libraries, which come first (tools/bundle).
    own = ["$ORIGIN", *SYSTEM_FOLDERS, "$ORIGIN/system"]
    place_with_path(build / "lib/libmultum.so.1", libraries / "libmultum.so.1", own)
    for name in decoder:
        place_with_path(build / "bin" / name, libraries / name, own)
    for soname, path in real.items():
        place_with_path(path, place_of(libraries, soname), own)
    for soname, user in stand_ins.items():
        stand_in_libraries.write_stand_in(user, library_path(soname), soname, place_of(libraries, soname))
    copy_licences(packages_of(real.values()) | set(COMPILED_IN), libraries / "licences")
    (libraries / "LICENSE").unlink(missing_ok=True)


def make_wheel(build, output):
    """Writes output/multum-VERSION-...whl and returns its path."""
    python = sysconfig.get_config_var("py_version_short")
    tag = f"cp{python.replace('.', '')}-cp{python.replace('.', '')}-manylinux_2_36_x86_64"
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "wheel"
        fill(folder, build)
        information = folder / f"multum-{version()}.dist-info"
        information.mkdir()
        (information / "METADATA").write_text(METADATA.format(version=version(), python=python))
        (information / "WHEEL").write_text(
            f"Wheel-Version: 1.0\nGenerator: multum\nRoot-Is-Purelib: false\nTag: {tag}\n")
        shutil.copyfile(pathlib.Path(__file__).resolve().parents[2] / "LICENSE", information / "LICENSE")
        subprocess.run([sys.executable, "-m", "wheel", "pack", "--dest-dir", str(output), str(folder)], check=True,
                       stdout=subprocess.DEVNULL)
    return output / f"multum-{version()}-{tag}.whl"
