#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests multum-bench on-gpu with a processor in the role of the GPU: its output, too little time, and refusals.

Usage: check_on_gpu.py MULTUM_BENCH OUTPUT_PREFIX
"""
import json
import os
import pathlib
import subprocess
import sys

bench, output = sys.argv[1], sys.argv[2]
# Reuses the kernels that PoCL compiled for other tests, but not multum's own cache. tests/cli/program.h does the same.
cache = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
environment = {"POCL_CACHE_DIR": f"{cache}/pocl/kcache", **os.environ, "MULTUM_CACHE_DIR": ""}


def run(*arguments, expected):
    result = subprocess.run([bench, "on-gpu", *arguments], capture_output=True, text=True,
                            env=environment)
    assert result.returncode == expected, f"{arguments}: exit code {result.returncode}\n{result.stdout}{result.stderr}"
    return result


def read():
    return json.loads(pathlib.Path(output + ".json").read_text()), pathlib.Path(output + ".md").read_text()


# Runs every step at a small size.
run("--small", "--any-device", "--minutes", "5", "--output", output, expected=0)
result, page = read()
steps = {step["name"]: step for step in result["steps"]}
assert [name for name, step in steps.items() if step["status"] != "done"] == [], steps
assert result["devices"] and result["device"] in page
assert not result["is_gpu"] and "contains no GPU times" in page
for name in ("GL contexts", "first bake", "selftest", "bake 64 on the processor", "bake 128 on the processor",
             "em 64 on the processor", "frames", "texture inference", "tests kernel_test", "tests gl_test"):
    assert name in steps, sorted(steps)
contexts = steps["GL contexts"]["result"]["contexts"]
assert any(row["display"] == "OSMesa" and "llvmpipe" in row["description"] for row in contexts), contexts
assert steps["tests kernel_test"]["result"]["tests"] > 0
bake = steps["bake 128 on the processor"]["result"]
assert bake["bake"]["device_bytes_peak"] > 0 and bake["timed"]["launch_seconds"]["movmf_em_texels"] > 0
for title in ("## Devices", "## Steps", "## Checks", "## Whole bakes", "### Kernels of the bake", "## EM", "## Drawing",
              "## Texture inference"):
    assert title in page, title

# Writes the page again from the same measurements.
pathlib.Path(output + ".md").unlink()
run("--from", output + ".json", "--output", output, expected=0)
assert read()[1] == page

# If there is too little time, steps are left out, and the output names them.
run("--small", "--any-device", "--minutes", "0.1", "--output", output, expected=0)
result, page = read()
assert all(step["status"] in ("done", "left out", "failed") for step in result["steps"])
left_out = [step for step in result["steps"] if step["status"] == "left out"]
assert left_out and all("s were left" in step["reason"] for step in left_out), result["steps"]

# This device does not exist.
refused = run("--small", "--device", "no such device", "--output", output, expected=4)
assert "no such device" in refused.stderr and "--any-device" in refused.stderr, refused.stderr
print(f"on_gpu: {len(steps)} steps, then {len(left_out)} left out")
