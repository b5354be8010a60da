#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests tools/check_advice.py on sources with and without options in their messages: check_advice_test.py TOOLS"""
import pathlib
import subprocess
import sys
import tempfile

TOOL = pathlib.Path(sys.argv[1]) / "check_advice.py"


def check(source):
    """Returns the lines that the tool prints for a source of a shared folder."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "host" / "image"
        path.mkdir(parents=True)
        (path / "a.cpp").write_text(source)
        run = subprocess.run([sys.executable, str(TOOL), "--root", folder], capture_output=True, text=True, check=False)
    assert run.returncode == (1 if run.stdout else 0), run
    return run.stdout


def main():
    found = check('int a;\nvoid f() {\n  warn("dark: "\n       "give --green up");\n}\n')
    assert found.startswith("host" "/image/a.cpp:4: --green"), found
    assert "--two-channel" in check('const char* const kOption = "--two-channel";\n')
    for fine in ('warn("dark" + advice(", give <green up>"));\n', '// --green up\nint a;\n',
                 'throw Error(ErrorCode::kUsage, "--green is 7, expected up or down");\n',
                 'refuse("expected a file of lobes (multum bake --ndf vmf or gmm)");\n',
                 'refuse("was baked with --surface texels");\n', 'refuse("run oiiotool --autoorient IN -o OUT");\n'):
        assert check(fine) == "", fine


if __name__ == "__main__":
    main()
