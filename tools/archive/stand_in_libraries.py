#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes stand-ins for shared libraries that a library links but multum never calls.

Debian's OpenImageIO links the decoders of every format that it knows, such as films, medical images and volumes. They
are 220 libraries with a total size of 320 MB. OpenImageIO's symbols are bound when a program starts, so each symbol
that it uses in these libraries must exist. multum uses it only for PNG, JPEG, WebP, TIFF and OpenEXR
(host/formats/image/files/image_container.h). A stand-in has the same name, symbols and symbol versions as the library.
Its functions print that they are stand-ins and end the process, except for functions that return a version as text.
"""
import pathlib
import re
import subprocess
import tempfile

SYMBOL = re.compile(r"^\s*\d+:\s+\S+\s+(\d+)\s+(\w+)\s+(\w+)\s+\w+\s+(?:\[.*\]\s+)?(\S+)\s+(\S+?)(?:\s+\(\d+\))?$")
# OpenImageIO's list of formats contains the version of each decoder as text.
ASKED_ALWAYS = re.compile(r"^libraw_version$")


def symbols(library):
    """Returns rows (name, version or '', kind, size, is_defined) of a library's dynamic symbols."""
    text = subprocess.run(["readelf", "--dyn-syms", "--wide", str(library)], check=True, capture_output=True,
                          text=True).stdout
    for line in text.splitlines():
        found = SYMBOL.match(line)
        if found is None:
            continue
        size, kind, _, section, name = found.groups()
        name, _, version = name.partition("@")
        yield name, version.lstrip("@"), kind, int(size), section != "UND"


def source_of(soname, wanted, defined):
    """Returns C source that defines every wanted symbol, and the linker's version script."""
    lines = ["#include <stdlib.h>", "#include <unistd.h>", "static void refuse(void) {",
             f'  static const char text[] = "{soname}: not part of this archive, since multum reads no file that needs '
             'it\\n";',
             "  if (write(2, text, sizeof text - 1) < 0) abort();", "  abort();", "}",
             'static const char* version(void) { return "none"; }']
    versions = {}
    for name in sorted(wanted):
        version, kind, size = defined[name]
        versions.setdefault(version, []).append(name)
        if kind in ("FUNC", "IFUNC"):
            alias = "version" if ASKED_ALWAYS.search(name) else "refuse"
            lines.append(f'void {name}(void) __attribute__((alias("{alias}")));')
        else:
            lines.append(f"char {name}[{max(size, 8)}] __attribute__((aligned(32)));")
    script = []
    for version, names in versions.items():
        if version:  # a symbol without a version is global by default
            script.append(version + " { global: " + " ".join(f"{n};" for n in names) + " };")
    return "\n".join(lines) + "\n", "\n".join(script)


def write_stand_in(user, library, soname, output):
    """Writes `output`, a stand-in for `library` with the symbols that `user` needs. This function requires gcc and
    binutils."""
    defined = {}
    for name, version, kind, size, is_defined in symbols(library):
        if is_defined and kind in ("FUNC", "IFUNC", "OBJECT", "NOTYPE"):
            defined.setdefault(name, (version, kind, size))
    wanted = {name for name, _, _, _, is_defined in symbols(user) if not is_defined} & defined.keys()
    source, script = source_of(soname, wanted, defined)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "stand_in.c").write_text(source)
        (folder / "stand_in.map").write_text(script)
        command = ["gcc", "-shared", "-fPIC", "-O1", "-w", f"-Wl,-soname,{output.name}", "-Wl,-z,noexecstack", "-s",
                   "-o", str(output), str(folder / "stand_in.c")]
        if script:
            command.append(f"-Wl,--version-script,{folder / 'stand_in.map'}")
        subprocess.run(command, check=True)
