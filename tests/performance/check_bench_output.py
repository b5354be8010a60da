#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks what multum-bench wrote: check_bench_output.py em FILE.json | accuracy FILE.md. Never judges a time."""
import json
import re
import sys


def check_em(text):
    result = json.loads(text)
    levels = [row["level"] for row in result["levels"]]
    assert levels == list(range(levels[0], 0, -1)), f"levels {levels}: expected each from the second coarsest to 1"
    assert 2 ** (levels[0] + 1) == result["size"]
    assert result["ratio"] > 0 and result["kernels_ms"] > 0 and result["device"] and result["processor"]
    for row in result["levels"]:
        low, high = row["ratio_quartiles"]
        assert 0 < low <= row["ratio"] <= high, row
        assert row["mean_difference"] < 2e-3, f"kernels and yardstick did different work: {row}"


def check_accuracy(text):
    # The first figure of a summary line is s = 100 at the centres of level 3.
    error = {name: float(value) for name, value in re.findall(r"^\| ([^|]+) \| ([0-9.]+) /", text, re.MULTILINE)}
    assert error["8 lobes"] < error["4 lobes"] < error["2 lobes"] < error["1 lobe"], error
    midway = {name: float(value) for name, value in re.findall(r"^\| ([^|]+) \| [^|]+ \| ([0-9.]+) /", text,
                                                               re.MULTILINE)}
    assert midway["4 lobes"] < 0.5 * midway["4 lobes, every texel by itself"], midway
    rows = re.findall(r"^\| ([012]) \| (20|100|500) \|(.*)\|$", text, re.MULTILINE)
    assert [row[:2] for row in rows] == [(level, s) for level in "012" for s in ("20", "100", "500")], rows
    stored = {row[:2]: [float(cell) for cell in row[2].split("|")] for row in rows}
    for s in ("20", "100", "500"):
        # Level 2 is stored whatever L is, level 1 up to L = 1; files get smaller.
        assert stored["0", s][6] == stored["1", s][6] == stored["2", s][6], rows
        assert stored["0", s][3:6] == stored["1", s][3:6], rows
        assert stored["0", s][7:] > stored["1", s][7:] > stored["2", s][7:], rows
    assert "nan" not in text and "inf" not in text


if __name__ == "__main__":
    {"em": check_em, "accuracy": check_accuracy}[sys.argv[1]](open(sys.argv[2], encoding="utf-8").read())
