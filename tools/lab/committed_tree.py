#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Refuses to make documents from an uncommitted tree, because nobody could repeat the measurements.

    tools/lab/committed_tree.py [--allow-dirty] [--root DIR]    # prints the commit; exit code 1 if it is refused

Generators call add_option() and stated_commit(). Changed documents are allowed, because no figure depends on docs/ or
README.md. Documents can therefore be made one after another.
"""
import argparse
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
NO_SOURCE = (":!docs", ":!README.md")
DIRTY = "-dirty"


def git(root, *arguments):
    """Returns git's output in the repository of `root`, or None if git fails."""
    try:
        run = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True, check=False)
    except FileNotFoundError:  # git is not installed
        return None
    return run.stdout.strip() if run.returncode == 0 else None


def commit_of(root=ROOT):
    """Returns the abbreviated commit, with "-dirty" if sources differ or are new; "unknown" outside a repository."""
    top = git(root, "rev-parse", "--show-toplevel")
    if top is None or pathlib.Path(top).resolve() != pathlib.Path(root).resolve():
        return "unknown"
    commit = git(root, "rev-parse", "--short=12", "HEAD")
    changed = git(root, "status", "--porcelain", "--", ".", *NO_SOURCE)
    return commit + (DIRTY if changed or changed is None else "")


def is_committed(commit):
    return commit != "unknown" and not commit.endswith(DIRTY)


def add_option(parser):
    parser.add_argument("--allow-dirty", action="store_true",
                        help="accept uncommitted sources, and state this in the document")


def stated_commit(allow_dirty, root=ROOT):
    """Describes the commit for a document. Ends the program if there is no such commit."""
    commit = commit_of(root)
    if is_committed(commit):
        return f"commit {commit}"
    if not allow_dirty:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: the sources are at commit {commit}, expected a committed tree, "
                 "from which the same figures can be made again. Commit first, or use --allow-dirty, which the "
                 "document then states.")
    return f"commit {commit} (--allow-dirty: sources that are not committed)"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_option(parser)
    parser.add_argument("--root", default=ROOT, help="folder of the repository (default: this repository)")
    given = parser.parse_args()
    print(stated_commit(given.allow_dirty, given.root))


if __name__ == "__main__":
    main()
