#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests refusals of multum-bench, which must leave no files: check_bench_refusals.py PROGRAM BAKE_RESULT.json"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

PROGRAM, RESULT = sys.argv[1:]


def expect(exit_code, parts, arguments, **options):
    """Checks that the program exits with `exit_code` and prints all of `parts` on stderr."""
    run = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, **options)
    assert run.returncode == exit_code, f"{arguments}: exit code {run.returncode}, expected {exit_code}: {run.stderr}"
    for part in parts:
        assert part in run.stderr, f"{arguments}: no '{part}' in: {run.stderr}"


def check_programs(folder):
    here = ["--folder", str(folder)]
    # multum-bench finds maketx through PATH, and finds multum in its own folder.
    expect(4, ["maketx", "openimageio-tools"], ["bake", "--size", "16", *here],
           env={**os.environ, "PATH": str(folder)})
    expect(2, ["exit code 2", "--nonsense"], ["bake", "--size", "16", *here, "--", "--nonsense"])
    expect(2, ["exit code 2", "--nonsense"],
           ["scale", "--size-min", "16", "--size-max", "16", *here, "--", "--nonsense"])


def check_options():
    expect(2, ["--size", "17"], ["bake", "--size", "17"])
    expect(2, ["--size-max", "32", "--size-min", "64"], ["scale", "--size-min", "64", "--size-max", "32"])
    expect(2, ["--context"], ["load", "--context", "window"])
    expect(4, ["no such folder"], ["load", "--size", "16", "--json", "no such folder/x.json"])


def check_documents(folder):
    output = folder / "out.md"
    for text, parts in (("{", []), ("{}", ["benchmark"]), ('{"benchmark": "boke"}', ["boke", "em, bake"])):
        bad = folder / "bad.json"
        bad.write_text(text)
        expect(3, [str(bad), *parts], ["document", "-o", str(output), "--json", RESULT, "--json", str(bad)])
    cut = json.loads(pathlib.Path(RESULT).read_text())
    del cut["ratio"]["cpu"]
    bad.write_text(json.dumps(cut))
    expect(3, [str(bad), "cpu", "--json"],
           ["document", "-o", str(output), "--json", str(bad)])
    expect(3, ["none.json"], ["document", "-o", str(output), "--json", str(folder / "none.json")])
    expect(2, [str(bad)], ["document", "-o", str(bad), "--json", str(bad)])
    # Results of uncommitted sources are refused unless an option allows them. In that case the document says so.
    dirty = folder / "dirty.json"
    for commit in ("0123abc-dirty", "unknown"):
        dirty.write_text(json.dumps({**json.loads(pathlib.Path(RESULT).read_text()), "commit": commit}))
        expect(2, [str(dirty), commit, "--allow-dirty"], ["document", "-o", str(output), "--json", str(dirty)])
        assert not output.exists(), "a document was written although it was refused"
        expect(0, [], ["document", "-o", str(output), "--allow-dirty", "--json", str(dirty)])
        assert f"commit {commit} (--allow-dirty: " in output.read_text()
        output.unlink()
    expect(2, ["unknown", "--allow-dirty"],
           ["accuracy", "-o", str(output), "--commit", "unknown", "--size", "16", "--section", "quarters"])
    assert not output.exists(), "a document was written although it was refused"


def check_cancelling(folder):
    run = subprocess.Popen([PROGRAM, "bake", "--size", "16", "--repetitions", "1000", "--folder", str(folder)],
                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    while not any(folder.iterdir()):
        assert run.poll() is None, "the program ended before it made a folder"
        time.sleep(0.01)
    run.send_signal(signal.SIGTERM)
    message = run.communicate()[1]
    assert run.returncode == 130, f"exit code {run.returncode}, expected 130: {message}"


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_options()
        check_programs(folder)
        check_cancelling(folder)
        assert not any(folder.iterdir()), f"left behind: {list(folder.iterdir())}"
        check_documents(folder)


if __name__ == "__main__":
    main()
