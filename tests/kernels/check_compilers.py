#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles every kernel with compilers other than PoCL's, as OpenCL C 1.2 and 3.0. clang compiles to SPIR-V, which
SPIR-V's validator checks, and to NVPTX, whose listing shows the GPU resources that a kernel needs.

Usage: check_compilers.py KERNEL_FOLDER FLATTENED_FOLDER [--ptxas PTXAS] [--table]
A kernel may keep STACK_MAX bytes outside registers; if ptxas is installed, it may spill nothing. --table prints
the resources of each kernel. A missing compiler is reported and skipped. The exit code is 1 if a kernel fails.
"""
import argparse
import concurrent.futures
import functools
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
# movmf_bin_axes counts 63 bins and movmf_bin_cells stores 64 cells in arrays. The sums of 8 lobes take 320 bytes.
STACK_MAX = 512
# movmf_refine solves for 4 numbers per lobe. It stores the triangle of 32 x 32 sums of 8 lobes, and five sets of lobes:
# the lobes of EM, the lobes of the neighbours, the lobes of the step, the best lobes, and the pooled lobes with their
# derivatives.
STACK_MAX_OF = {"movmf_refine": 5120}
REGISTERS_MAX = 255  # the number of registers per work-item on NVIDIA's GPUs
CLANG = ["clang", "-x", "cl", "-Xclang", "-finclude-default-header", "-Wall", "-Werror", "-Wno-unused-function"]


def variants(name, text):
    """Yields names and definitions of the scalar variants that GPUs run. Options that the text lacks have one value."""
    if name.startswith("movmf_") and name != "movmf_shade":
        for lobes in (4, 8) if "MULTUM_LOBES" in text else (4,):
            for weighted in (0, 1) if "MULTUM_WEIGHTED" in text else (0,):
                for planar in (0, 1) if "MULTUM_PLANAR" in text else (0,):
                    yield f"{lobes} lobes, weighted {weighted}, planar {planar}", [
                        f"-DMULTUM_LOBES={lobes}", f"-DMULTUM_WEIGHTED={weighted}", f"-DMULTUM_PLANAR={planar}"]
    elif name.startswith("sh_"):
        for order in (4, 8, 20):
            yield f"order {order}", [f"-DMULTUM_SH_ORDER={order}"]
    else:
        yield "the only one", []


def run(command):
    return subprocess.run(command, capture_output=True, text=True)


@functools.cache
def spirv_translator():
    """Returns the path of the translator of clang's own version, or of any translator, or None."""
    version = re.search(r"version (\d+)", run(["clang", "--version"]).stdout)
    return (version and shutil.which(f"llvm-spirv-{version[1]}")) or shutil.which("llvm-spirv")


def spirv(source, definitions, standard, folder):
    """Returns the error of a kernel compiled to SPIR-V, or ''."""
    bitcode, module = folder / "kernel.bc", folder / "kernel.spv"
    steps = [CLANG + [f"-cl-std={standard}", "-target", "spir64-unknown-unknown", "-O0", "-emit-llvm", "-c",
                      "-DMULTUM_VECTOR_WIDTH=1", *definitions, str(source), "-o", str(bitcode)]]
    translator = spirv_translator()
    if translator:
        # This is not an OpenCL profile, because such profiles lack 64-bit atomics, an extension that movmf_bin_add
        # uses.
        version, environment = ("1.0", "spv1.0") if standard == "CL1.2" else ("1.2", "spv1.2")
        steps.append([translator, f"--spirv-max-version={version}", str(bitcode), "-o", str(module)])
        if shutil.which("spirv-val"):
            steps.append(["spirv-val", "--target-env", environment, str(module)])
    for step in steps:
        result = run(step)
        if result.returncode != 0:
            return f"{os.path.basename(step[0])}: {(result.stderr or result.stdout).strip()[:2000]}"
    return ""


def nvptx(source, definitions, ptxas, folder):
    """Returns (error or '', rows of kernel, bytes of stack, registers, bytes spilled)."""
    listing = folder / "kernel.ptx"
    # clang does not know any extensions of this target, but the driver's compiler supports this one.
    definitions = [*definitions, "-DMULTUM_VECTOR_WIDTH=1", "-include", str(HERE / "nvptx_builtins.clh")]
    result = run(CLANG + ["-cl-std=CL1.2", "-target", "nvptx64-unknown-unknown", "-Xclang", "-target-cpu", "-Xclang",
                          "sm_75", "-O2", "-S", *definitions, str(source), "-o", str(listing)])
    if result.returncode != 0:
        return f"clang for NVPTX: {result.stderr.strip()[:2000]}", []
    rows = []
    for entry in re.finditer(r"\.entry (\w+)\((.*?)^}", listing.read_text(), re.DOTALL | re.MULTILINE):
        depot = re.search(r"__local_depot\d+\[(\d+)\]", entry.group(2))
        rows.append([entry.group(1), int(depot.group(1)) if depot else 0, None, None])
    wrong = "; ".join(f"{row[0]} keeps {row[1]} bytes outside registers, at most {STACK_MAX_OF.get(row[0], STACK_MAX)}"
                      for row in rows if row[1] > STACK_MAX_OF.get(row[0], STACK_MAX))
    if ptxas:
        result = run([ptxas, "-arch=sm_75", "-v", str(listing), "-o", str(folder / "kernel.cubin")])
        if result.returncode != 0:
            return f"ptxas: {result.stderr.strip()[:2000]}", rows
        found = re.findall(r"Compiling entry function '(\w+)'.*?(\d+) bytes spill stores.*?Used (\d+) registers",
                           result.stderr, re.DOTALL)
        for name, spilled, registers in found:
            for row in rows:
                if row[0] == name:
                    row[2:] = [int(registers), int(spilled)]
        bad = [row for row in rows if row[3]]
        wrong += "; ".join(f"{row[0]} spills {row[3]} bytes of {row[2]} registers" for row in bad)
    return wrong, rows


def check(job):
    source, name, label, definitions, ptxas = job
    failures = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for standard in ("CL1.2", "CL3.0"):
            wrong = spirv(source, definitions, standard, folder)
            if wrong:
                failures.append(f"{name}, {label}, {standard}: {wrong}")
        wrong, rows = nvptx(source, definitions, ptxas, folder)
        if wrong:
            failures.append(f"{name}, {label}: {wrong}")
    return failures, [(name, label, *row) for row in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kernels", type=pathlib.Path)
    parser.add_argument("flattened", type=pathlib.Path,
                        help="folder of the same kernels with their includes expanded, as the programs embed them")
    parser.add_argument("--ptxas", default=shutil.which("ptxas"))
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    if not spirv_translator():
        print("check_compilers: llvm-spirv of clang's version is not installed: no SPIR-V was compiled")
    if not shutil.which("spirv-val"):
        print("check_compilers: spirv-val is not installed: SPIR-V was not validated")
    if not options.ptxas:
        print("check_compilers: ptxas is not installed: counted LLVM's stack frames, but no registers")
    jobs = [(options.flattened / source.name, source.stem, label, definitions, options.ptxas)
            for source in sorted(options.kernels.glob("*.cl"))
            for label, definitions in variants(source.stem, (options.flattened / source.name).read_text())]
    failures, rows = [], []
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for failed, taken in pool.map(check, jobs):
            failures += failed
            rows += taken
    if options.table:
        print("| kernel | variant | stack, bytes | registers | spilled, bytes |\n|---|---|---|---|---|")
        for _, label, kernel, stack, registers, spilled in rows:
            print(f"| `{kernel}` | {label} | {stack} | {'-' if registers is None else registers} | "
                  f"{'-' if spilled is None else spilled} |")
    for failure in failures:
        print(f"check_compilers: {failure}", file=sys.stderr)
    most = max((row[4] or 0 for row in rows), default=0)
    print(f"check_compilers: {len(jobs)} variants of {len({job[1] for job in jobs})} files, {len(rows)} kernels for "
          f"NVPTX, {max((row[3] for row in rows), default=0)} bytes of stack and {most} registers at most, "
          f"{len(failures)} failures")
    sys.exit(1 if failures or not rows else 0)


main()
