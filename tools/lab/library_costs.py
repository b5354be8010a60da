#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what a call of libmultum costs, and writes docs/evidence/LIBRARY.md.

  library_costs.py [--build build/release] [--sizes 512,4096] [--pairs 5] [--output docs/evidence/LIBRARY.md]

The program and a Python call bake the same map alternately. The Python process has loaded the package and opened the
device before its first call; the program starts anew for each bake, as it always does. Also measures calls that need
nothing but the call itself, and the sizes of packages in out/packages if they exist.
"""
import argparse
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent

WORKER = """
import sys, time, resource
import multum
multum.bake(sys.argv[1], sys.argv[2])
print("ready", flush=True)
for line in sys.stdin:
    begin, cpu = time.perf_counter(), resource.getrusage(resource.RUSAGE_SELF)
    baked = multum.bake(sys.argv[1], sys.argv[2], force=True)
    end = resource.getrusage(resource.RUSAGE_SELF)
    print(time.perf_counter() - begin, end.ru_utime + end.ru_stime - cpu.ru_utime - cpu.ru_stime, baked.content_hash,
          flush=True)
"""
SMALL = r"""
#include <multum.h>
#include <stdio.h>
#include <time.h>
static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}
int main(int argc, char** argv) {
  multum_map* map = 0; multum_brdf* brdf = 0; multum_lobes lobes; multum_view view;
  double rgb[3], light[3] = {0.6, 0, 0.8}, v[3] = {0, 0, 1}, sum = 0;
  if (argc != 2 || multum_map_open(argv[1], &map, 0) || multum_brdf_new("ggx:0.4", &brdf, 0)) return 1;
  enum { N = 200000 };
  multum_map_lookup(map, 0, 0, 1.5, &lobes, 0);
  multum_map_level(map, 1, MULTUM_LOBES, &view, 0);
  double t0 = now();
  for (int i = 0; i < N; ++i) sum += multum_map_info(map).width;
  double t1 = now();
  for (int i = 0; i < N; ++i) { multum_map_level(map, 1, MULTUM_LOBES, &view, 0); sum += view.width; }
  double t2 = now();
  for (int i = 0; i < N; ++i) { multum_map_lookup(map, 1e-3 * i, 0.3, 1.5, &lobes, 0); sum += lobes.lobes[0][3]; }
  double t3 = now();
  for (int i = 0; i < N; ++i) { multum_shade(&lobes, brdf, light, v, rgb); sum += rgb[0]; }
  double t4 = now();
  printf("%g %g %g %g %g\n", 1e6 * (t1 - t0) / N, 1e6 * (t2 - t1) / N, 1e6 * (t3 - t2) / N, 1e6 * (t4 - t3) / N, sum);
  return 0;
}
"""


def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    return names[0] if names else platform.machine()


def spread(values):
    return f"{statistics.median(values):.3f} ({min(values):.3f} to {max(values):.3f})"


def compare(build, folder, size, pairs):
    """Returns the ratios Python / program of wall and processor time, and whether all content hashes are equal."""
    program = build / "bin/multum"
    subprocess.run([program, "testmap", "--size", str(size), "--write-green", "up", "-o", folder / "map"], check=True,
                   capture_output=True)
    source = folder / "map_normal.png"
    environment = dict(os.environ, PYTHONPATH=str(build / "python"))
    walls, works, hashes = [], [], set()
    with subprocess.Popen([sys.executable, "-c", WORKER, str(source), str(folder / "python.ndf.exr")], text=True,
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment) as worker:
        worker.stdout.readline()
        for _ in range(pairs):
            begin, before = time.perf_counter(), os.times()
            subprocess.run([program, "bake", source, "-o", folder / "program.ndf.exr", "--force", "-q"], check=True)
            after = os.times()
            wall = time.perf_counter() - begin
            work = after.children_user + after.children_system - before.children_user - before.children_system
            worker.stdin.write("\n")
            worker.stdin.flush()
            python_wall, python_work, content = worker.stdout.readline().split()
            walls.append(float(python_wall) / wall)
            works.append(float(python_work) / work)
            hashes.add(content)
        worker.stdin.close()
    sys.path.insert(0, str(build / "python"))
    import multum
    hashes.add(multum.load(folder / "program.ndf.exr").content_hash)
    return walls, works, len(hashes) == 1


def small_calls(build, folder):
    """Returns microseconds of processor time per call: info, level, lookup, shade."""
    (folder / "small.c").write_text(SMALL)
    subprocess.run(["cc", "-O2", "-I", ROOT / "host/api", folder / "small.c", "-o", folder / "small", "-L",
                    build / "lib", "-lmultum", f"-Wl,-rpath,{build / 'lib'}"], check=True)
    return [float(v) for v in subprocess.run([folder / "small", folder / "program.ndf.exr"], check=True,
                                             capture_output=True, text=True).stdout.split()[:4]]


def page(options, rows, small, hashes_equal, packages):
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout
    lines = ["# Calls of libmultum", "",
             "This page shows what a call of the library costs, compared with the program `multum`.", "",
             f"Processor: {processor()}, {os.cpu_count()} processors. Commit {commit.strip()}. Command: "
             f"`tools/lab/library_costs.py --sizes {options.sizes} --pairs {options.pairs}`.",
             "",
             "## A bake from Python", "",
             "The program and a Python process bake the test map alternately. The Python process has already opened "
             "its device. A ratio below 1 means that the Python call is faster. The table shows the median ratio, with "
             "the smallest and the largest:", "",
             "|size|time, Python / program|processor time, Python / program|", "|---|---|---|"]
    lines += [f"|{size} x {size}|{spread(walls)}|{spread(works)}|" for size, walls, works in rows]
    lines += ["", f"The checksums of the texels are {'equal' if hashes_equal else 'DIFFERENT'} in all runs.", "",
              "## Small calls", "", "Processor time per call from C, in microseconds:", "",
              "|call|time|", "|---|---|"]
    names = ("`multum_map_info`", "`multum_map_level` of a level in memory", "`multum_map_lookup`, two levels, 4 lobes",
             "`multum_shade`, GGX, 4 lobes")
    lines += [f"|{name}|{value:.3f}|" for name, value in zip(names, small)]
    lines += ["", "Levels are NumPy views of the library's memory: no byte is copied (test `api.python`)."]
    if packages:
        lines += ["", "## Sizes of packages", "", "|file|MiB|", "|---|---|"]
        lines += [f"|{file.name}|{file.stat().st_size / 2**20:.2f}|" for file in packages]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--sizes", default="512,4096")
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/evidence/LIBRARY.md")
    options = parser.parse_args()
    rows, equal = [], True
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for size in map(int, options.sizes.split(",")):
            walls, works, same = compare(options.build.resolve(), folder, size, options.pairs)
            rows.append((size, walls, works))
            equal &= same
        small = small_calls(options.build.resolve(), folder)
    packages = sorted((ROOT / "out/packages").glob("*")) if (ROOT / "out/packages").is_dir() else []
    options.output.write_text(page(options, rows, small, equal, packages))
    print(options.output.read_text())


if __name__ == "__main__":
    main()
