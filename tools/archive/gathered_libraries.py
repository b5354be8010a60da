# SPDX-License-Identifier: Apache-2.0
"""Gathers the shared libraries that programs need, for archives and wheels that run on other machines."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import stand_in_libraries  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# The libraries that belong to the C library in glibc 2.36.
C_LIBRARY = re.compile(r"^(ld-linux-x86-64|libc|libm|libmvec|libdl|libpthread|librt|libresolv|libutil|libanl)\.so\b")
# The libraries that drivers of GL and OpenCL also load, and the loaders of both. The system's copies take precedence.
SYSTEM_FIRST = re.compile(
    r"^(libstdc\+\+|libgcc_s|libgomp|libz|libzstd|liblzma|liblz4|libbz2|libexpat|libcap|libsystemd|libgcrypt"
    r"|libgpg-error|libxml2|libicuuc|libOpenCL|libEGL|libGLdispatch)\.so\b")
SYSTEM_FOLDERS = ("/usr/lib/x86_64-linux-gnu", "/lib/x86_64-linux-gnu", "/usr/lib64", "/lib64", "/usr/lib", "/lib")
# The libraries that are opened by name. EGL's loader is the only one, because the loader of OpenCL is linked.
OPENED = ("libEGL.so.1",)
# The decoders that OpenImageIO links for formats that multum refuses (tools/archive/stand_in_libraries.py).
NEVER_CALLED = re.compile(
    r"^lib(opencv_\w+|avcodec|avformat|avutil|swscale|openvdb|heif|raw_r|icuuc)\.so\b")


def installed_as(name):
    """Returns the installed package whose name has a version in the place of `*`."""
    found = [path.name for path in pathlib.Path("/usr/share/doc").glob(name)
             if re.fullmatch(re.escape(name).replace(r"\*", r"[\d.]+"), path.name)]
    return max(found, key=lambda one: [int(part) for part in re.findall(r"\d+", one)], default=name)


# The packages that contain only headers or are linked statically, also into the decoder for browsers. No file in the
# archive shows that they are used.
COMPILED_IN = ("libglm-dev", "libcli11-dev", "nlohmann-json3-dev", "libtomlplusplus-dev", "libgtest-dev",
               "libeigen3-dev", installed_as("libboost*-dev"), "librapidcheck-dev", "pybind11-dev",
               "opencl-clhpp-headers", "wasi-libc", installed_as("libc++-*-dev-wasm32"),
               installed_as("libc++abi-*-dev-wasm32"), installed_as("libclang-rt-*-dev-wasm32"))


def fail(text):
    sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {text}")


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def needed(file):
    return re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-d", str(file)))


def library_path(soname, cache={}):
    """Returns the path at which ld.so finds a library."""
    if not cache:
        for line in run("/sbin/ldconfig", "-p").splitlines():
            found = re.match(r"\s*(\S+) \(libc6,x86-64.*\) => (\S+)", line)
            if found:
                cache.setdefault(found.group(1), found.group(2))
    if soname not in cache:
        fail(f"{soname}: not found by ldconfig -p, expected an installed library")
    return pathlib.Path(cache[soname])


def closure(files, opened=OPENED, given=()):
    """Returns (real, stand_ins): the paths of the libraries that the files need by soname, and stand_ins with the
    library that names each. `opened`: libraries that are opened by name. `given`: sonames that need no search."""
    real, stand_ins, waiting = {}, {}, [(file, soname) for file in files for soname in needed(file)]
    waiting += [(None, soname) for soname in opened]
    while waiting:
        user, soname = waiting.pop()
        if C_LIBRARY.match(soname) or soname in real or soname in stand_ins or soname in given:
            continue
        if NEVER_CALLED.match(soname):
            stand_ins[soname] = user
            continue
        real[soname] = library_path(soname)
        waiting += [(real[soname], other) for other in needed(real[soname])]
    return real, stand_ins


def place_with_path(source, target, path):
    """Copies a program or library, strips it, and sets its search path, which is a list of folders."""
    shutil.copyfile(source, target)
    target.chmod(0o755)
    subprocess.run(["strip", "--strip-unneeded", str(target)], check=True)
    subprocess.run(["patchelf", "--set-rpath", ":".join(path), str(target)], check=True)


def place(source, target, to_libraries):
    """Copies a file for an archive: `to_libraries` leads to lib/."""
    place_with_path(source, target, [to_libraries, *SYSTEM_FOLDERS, f"{to_libraries}/system"])


def packages_of(paths):
    """Returns the Debian packages to which files belong. dpkg may know a file in /usr by the path that it had before
    the /usr merge."""
    names = {path: [os.path.realpath(path), os.path.realpath(path).removeprefix("/usr")] for path in paths}
    # All names are in one query, because each query reads the file lists of every package.
    found = subprocess.run(["dpkg-query", "-S", *(name for both in names.values() for name in both)],
                           capture_output=True, text=True)
    owners = {}
    for line in found.stdout.splitlines():
        owner, _, name = line.partition(": ")
        owners[name] = owner.split(":")[0].split(",")[0]
    for path, both in names.items():
        if not any(name in owners for name in both):
            fail(f"{path}: no Debian package owns this file, so its licence is unknown")
    return {owners[name] for both in names.values() for name in both if name in owners}


def copy_licences(packages, folder):
    folder.mkdir()
    shutil.copyfile(ROOT / "LICENSE", folder.parent / "LICENSE")
    for package in sorted(packages):
        text = pathlib.Path(f"/usr/share/doc/{package}/copyright")
        if not text.is_file():
            fail(f"{text}: not found, expected the licence of {package}")
        shutil.copyfile(text, folder / f"{package}.txt")


def version():
    return re.search(r"project\(multum VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
