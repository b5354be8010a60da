#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks what multum-bench wrote: check_bench_output.py SUBCOMMAND FILE. Never judges a time."""
import json
import re
import sys


def parse_result(text, benchmark):
    """The result, its first part checked: what was run on what."""
    result = json.loads(text)
    assert result["benchmark"] == benchmark, result["benchmark"]
    assert result["command"].startswith(f"multum-bench {benchmark} --") and "json" not in result["command"], result
    for key in ("commit", "compiler", "processor", "system", "device"):
        assert isinstance(result[key], str) and result[key], f"{key}: {result[key]}"
    assert result["cores"] >= 1 and result["memory_bytes"] > 2**20 and result["repetitions"] >= 1
    assert re.fullmatch("[0-9a-f]{64}", result["result_hash"]), result["result_hash"]
    return result


def check_spread(spread):
    low, high = spread["quartiles"]
    assert 0 < low <= spread["median"] <= high, spread


def check_em(text):
    result = parse_result(text, "em")
    levels = [row["level"] for row in result["levels"]]
    assert levels == list(range(levels[0], 0, -1)), f"levels {levels}: expected each from the second coarsest to 1"
    assert 2 ** (levels[0] + 1) == result["size"]
    assert result["ratio"] > 0 and result["kernels_ms"] > 0 and result["evaluations_per_s"] > 0
    for row in result["levels"]:
        check_spread({"median": row["ratio"], "quartiles": row["ratio_quartiles"]})
        assert row["mean_difference"] < 2e-3, f"kernels and yardstick did different work: {row}"


def check_accuracy(text):
    # The first figure of a summary line is s = 100 at the centres of level 3.
    error = {name: float(value) for name, value in re.findall(r"^\| ([^|]+) \| ([0-9.]+) /", text, re.MULTILINE)}
    assert error["8 lobes"] < error["4 lobes"] < error["2 lobes"] < error["1 lobe"], error
    midway = {name: float(value) for name, value in re.findall(r"^\| ([^|]+) \| [^|]+ \| ([0-9.]+) /", text,
                                                               re.MULTILINE)}
    assert midway["4 lobes"] < 0.5 * midway["4 lobes, every texel by itself"], midway
    assert "nan" not in text and "inf" not in text


if __name__ == "__main__":
    checks = {"em": check_em, "accuracy": check_accuracy}
    checks[sys.argv[1]](open(sys.argv[2], encoding="utf-8").read())
