#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests tools/lab/committed_tree.py on repositories of its own: committed_tree_test.py TOOLS"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

TOOL = pathlib.Path(sys.argv[1]) / "committed_tree.py"


def git(root, *arguments):
    subprocess.run(["git", "-C", str(root), "-c", "user.name=a", "-c", "user.email=a@example.org", *arguments],
                   check=True, capture_output=True)


def ask(root, *options):
    run = subprocess.run([sys.executable, str(TOOL), "--root", str(root), *options], capture_output=True, text=True,
                         check=False)
    return run.returncode, run.stdout + run.stderr


def expect_refusal(root, part):
    code, said = ask(root)
    assert code == 1 and part in said and "--allow-dirty" in said, (code, said)
    code, said = ask(root, "--allow-dirty")
    assert code == 0 and part in said and "(--allow-dirty: " in said, (code, said)


def main():
    if shutil.which("git") is None:
        print("skipped: git is not installed")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder) / "repository"
        (root / "docs").mkdir(parents=True)
        expect_refusal(root, "unknown")
        git(root.parent, "init", "-q", str(root))
        (root / "host.cpp").write_text("1")
        (root / "docs" / "A.md").write_text("1")
        (root / "README.md").write_text("1")
        git(root, "add", ".")
        git(root, "commit", "-qm", "first")
        code, said = ask(root)
        assert code == 0 and said.startswith("commit ") and "dirty" not in said, (code, said)
        # Documents are made one after another, so other documents may have uncommitted changes.
        (root / "docs" / "A.md").write_text("2")
        (root / "README.md").write_text("2")
        assert ask(root)[0] == 0
        (root / "host.cpp").write_text("2")
        expect_refusal(root, "-dirty")
        git(root, "commit", "-qam", "second")
        assert ask(root)[0] == 0
        (root / "kernel.cl").write_text("new, and in no commit")
        expect_refusal(root, "-dirty")
        # A folder inside another repository is not a repository.
        (root / "inner").mkdir()
        expect_refusal(root / "inner", "unknown")


if __name__ == "__main__":
    main()
