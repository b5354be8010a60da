#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the output of multum-bench: check_bench_output.py SUBCOMMAND FILE. It does not judge times."""
import json
import re
import sys

ENCODINGS = ("snorm16", "half", "float")
COMPRESSIONS = ("none", "rle", "zips", "zip:1", "zip:4", "zip:9", "piz")


def parse_result(text, benchmark):
    """Checks the first part of the result, which says what was run and on which machine. Returns the result."""
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


def check_costs(costs, cores):
    for key in ("wall_s", "cpu_s", "peak_mib", "output_mb"):
        check_spread(costs[key])
    # The bounds are wide on purpose. With maps this small, libraries and sanitizers decide the peak.
    assert 1 < costs["peak_mib"]["median"] < 4096, costs
    assert costs["cpu_s"]["median"] <= costs["wall_s"]["median"] * cores + 0.1, costs


def check_em(text):
    result = parse_result(text, "em")
    levels = [row["level"] for row in result["levels"]]
    assert levels == list(range(levels[0], 0, -1)), f"levels {levels}: expected each from the second coarsest to 1"
    assert 2 ** (levels[0] + 1) == result["size"]
    if "--instructions avx2" in result["command"]: assert result["yardstick_instructions"] == "AVX2", result
    assert result["ratio"] > 0 and result["kernels_ms"] > 0 and result["evaluations_per_s"] > 0
    for row in result["levels"]:
        check_spread({"median": row["ratio"], "quartiles": row["ratio_quartiles"]})
        assert row["mean_difference"] < 2e-3, f"kernels and yardstick did different work: {row}"


def check_bake(text):
    result = parse_result(text, "bake")
    assert (result["size"], result["lobes"], result["repetitions"]) == (32, 2, 2)
    ours, theirs = result["programs"]
    assert ours["name"] == "multum bake" and theirs["name"] == "maketx" and theirs["version"]
    assert ours["command"] == ("multum bake map_normal.png -o map.ndf.exr --green up --lobes 2 --quiet --force "
                               "--no-measure --iterations 2"), ours["command"]
    assert theirs["command"].startswith("maketx --bumpslopes "), theirs["command"]
    for program in result["programs"]:
        check_costs(program, result["cores"])
    for key in ("wall", "cpu", "peak", "output"):
        check_spread(result["ratio"][key])


def check_batch(text):
    result = parse_result(text, "batch")
    assert [row["size"] for row in result["sizes"]] == [16, 32, 64] and result["count"] == 3, result
    assert result["multum_command"].startswith("multum bake ") and " --no-measure" in result["multum_command"], result
    for row in result["sizes"]:
        for program in ("multum", "maketx"):
            check_costs(row[program], result["cores"])
        rate, seconds = row["maps_per_s"]["median"], row["multum"]["wall_s"]["median"]
        assert abs(rate * seconds / 3 - 1) < 0.5, row  # medians of two runs, so not reciprocal
        for ratio in row["ratio"].values():
            check_spread(ratio)
    assert len({row["content_hash"] for row in result["sizes"]}) == 3, "maps of different sizes gave the same pixels"


def check_scale(text):
    result = parse_result(text, "scale")
    assert [row["size"] for row in result["sizes"]] == [16, 32, 64]
    hashes = set()
    for row in result["sizes"]:
        check_costs(row, result["cores"])
        assert abs(row["ns_per_texel"] * row["size"] ** 2 / 1e9 / row["wall_s"]["median"] - 1) < 1e-9, row
        hashes.add(row["content_hash"])
    assert len(hashes) == 3, "maps of different sizes gave the same pixels"


def check_load(text):
    result = parse_result(text, "load")
    files = {(row["encoding"], row["compression"]): row for row in result["files"]}
    assert list(files) == [(e, c) for e in ENCODINGS for c in COMPRESSIONS], list(files)
    texels = sum((32 >> level) ** 2 for level in range(6))
    for (encoding, compression), row in files.items():
        assert row["texture_bytes"] == texels * result["lobes"] * 4 * (4 if encoding == "float" else 2), row
        for key in ("write_s", "read_s", "read_threaded_s", "upload_s"):
            check_spread(row[key])
        assert 0 < row["file_bytes"] <= files[encoding, "none"]["file_bytes"], row
    assert files["half", "none"]["file_bytes"] < files["float", "none"]["file_bytes"]


def check_infer(text):
    result = parse_result(text, "infer")
    assert [row["system"] for row in result["systems"]] == ["one view", "one view, 4 x 4 sub-pixels", "2 views"]
    assert result["systems"][2]["solver"]["form"] == "A^T A"
    for row in result["systems"]:
        assert row["rows"] % (40 * 30) == 0 and row["texels"] == sum((32 >> level) ** 2 for level in range(6)), row
        solver = row["solver"]
        check_spread(solver["solve_ms"])
        check_spread(solver["yardstick_solve_ms"])
        assert solver["yardstick"].startswith("LSCG per colour"), solver
        # Both solvers take the same steps on the same system, so the texels are equal up to rounding.
        assert solver["at_bounds"] == 0 and solver["largest_difference"] < 1e-3, solver
        assert abs(solver["residual"] / solver["yardstick_residual"] - 1) < 1e-3, solver
        assert [product["product"] for product in row["products"]] == ["A", "A^T", "A^T A"]
        for product in row["products"]:
            check_spread(product["ms"])
            # Blocks are padded: at least 4 bytes per column and 4 per weight.
            entries = row["normal_entries" if product["product"] == "A^T A" else "entries"]
            assert product["bytes"] > 8 * entries and product["gb_per_s"] > 0, product
        assert len(row["convergence"]) == 8
        for count in row["convergence"]:
            assert count["iterations"] is None or 0 <= count["iterations"] <= 400, count
    assert {(row["views"], row["sub_pixels"]) for row in result["forms"]} >= {(1, 1), (2, 1), (1, 4)}
    for row in result["forms"]:
        assert row["entry_ratio"] == row["normal_entries"] / row["entries"] and row["time_ratio"] > 0, row


def check_document(text):
    sections = re.split(r"^## ", text, flags=re.MULTILINE)
    assert len(sections) == 7, f"{len(sections) - 1} sections, expected em, bake, batch, scale, load and infer"
    assert "commit " in sections[0] and " cores, " in sections[0], "equal conditions must be stated once, at the top"
    assert re.search(r"`multum-bench document -o docs/\S+ --json em.json --json bake.json", sections[0])
    for name, section in zip(("em", "bake", "batch", "scale", "load", "infer"), sections[1:]):
        assert section.count("\nMeasured by `multum-bench ") == 1 and f"`multum-bench {name} --" in section, section
        tables = re.findall(r"(?:^\|.*\n)+", section, re.MULTILINE)
        assert len(tables) == (4 if name == "infer" else 1), section
        for table in tables:
            rows = table.splitlines()
            assert len(rows) >= 5 and len({row.count("|") for row in rows}) == 1, table
    assert "/tmp" not in text and "nan" not in text, text
    assert not re.search(r"\b20\d\d-\d\d", text), "the document has a date; equal figures must give an equal document"


def check_accuracy(text):
    # The first figure of a summary line is the error for s = 100 at the texel centres of level 3.
    error = {name: float(value) for name, value in re.findall(r"^\| ([^|]+) \| ([0-9.]+) /", text, re.MULTILINE)}
    assert error["8 lobes"] < error["4 lobes"] < error["2 lobes"] < error["1 lobe"], error
    assert text.count("| fit, processor s | elapsed, s |") == 1, "only the summary may have times"
    times = re.findall(r"^\| (?:[1-8] lobes?)[^|]* \|.*\| ([0-9.]+) \| ([0-9.]+) \|$", text, re.MULTILINE)
    assert len(times) == 16 and all(float(one) >= 0 for row in times for one in row), times
    midway = {name: float(value) for name, value in re.findall(r"^\| ([^|]+) \| [^|]+ \| ([0-9.]+) /", text,
                                                               re.MULTILINE)}
    assert midway["4 lobes"] < 0.5 * midway["4 lobes, unaligned"], midway
    rows = re.findall(r"^\| ([012]) \| (20|100|500) \|(.*)\|$", text, re.MULTILINE)
    assert [row[:2] for row in rows] == [(level, s) for level in "012" for s in ("20", "100", "500")], rows
    stored = {row[:2]: [float(cell) for cell in row[2].split("|")] for row in rows}
    for s in ("20", "100", "500"):
        # Level 2 is stored for every L, and level 1 is stored for L up to 1. Files get smaller as L increases.
        assert stored["0", s][6] == stored["1", s][6] == stored["2", s][6], rows
        assert stored["0", s][3:6] == stored["1", s][3:6], rows
        assert stored["0", s][7:] > stored["1", s][7:] > stored["2", s][7:], rows
    assert "nan" not in text and "inf" not in text


def check_filters(text):
    result = parse_result(text, "filters")
    (study,) = result["maps"]
    assert study["noise"] <= result["noise_max"] and study["samples"] >= 128, study
    errors = {(row["method"], row["taps"], row["bias"], row["shades_taps"]): row["error"] for row in study["pictures"]
              if row["evaluations"] == 0}
    assert {key[0] for key in errors} == {"4 lobes", "6 lobes", "LEAN", "Toksvig", "averaged normals"}, errors.keys()
    for method in ("4 lobes", "LEAN", "Toksvig"):
        assert errors[method, 4, 0.0, False] < errors[method, 1, 0.0, False], errors
    evaluated = {(row["method"], row["evaluations"]): row["error"] for row in study["pictures"]
                 if row["evaluations"] > 0 and row["bias"] == -0.5}
    for count in (2, 4, 8, 16):
        assert evaluated["4 lobes", count] < min(evaluated[m, count] for m in ("LEAN", "Toksvig", "averaged normals"))
    motions = {(row["method"], row["motion"]) for row in study["motions"]}
    assert motions == {(m, k) for m in ("4 lobes", "LEAN", "Toksvig", "averaged normals") for k in
                       ("zoom", "pan", "turn")}, motions
    assert all(row["flicker"] > 0 for row in study["motions"])


if __name__ == "__main__":
    checks = {"em": check_em, "bake": check_bake, "batch": check_batch, "scale": check_scale, "load": check_load,
              "infer": check_infer, "filters": check_filters, "document": check_document, "accuracy": check_accuracy}
    checks[sys.argv[1]](open(sys.argv[2], encoding="utf-8").read())
