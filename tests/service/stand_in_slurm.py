#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Replaces Slurm's commands in tests: stand_in_slurm.py sbatch|squeue|scancel ... SLURM_STAND_IN is a folder that
controls it. The file `array_max` contains MaxArraySize. The lines of `refusals` are sbatch's messages at its first
calls. An empty line accepts the job, and a last line of "*" repeats the line before it forever. `calls` gets a line
for each call of sbatch. Tasks run on this machine, one after another. Uses only the standard library."""
import fcntl
import json
import os
import subprocess
import sys
import time

FOLDER = os.environ["SLURM_STAND_IN"]
SECONDS_MAX = 120


def path(name):
    return os.path.join(FOLDER, name)


def text(name):
    if not os.path.exists(path(name)):
        return ""
    with open(path(name), encoding="utf-8") as file:
        return file.read()


def write_job(number, job):
    with open(path(f"new-{number}"), "w", encoding="utf-8") as file:
        json.dump(job, file)
    os.rename(path(f"new-{number}"), path(f"job-{number}"))


def read_job(number):
    return json.loads(text(f"job-{number}"))


def numbers():
    return sorted(int(name[4:]) for name in os.listdir(FOLDER) if name.startswith("job-"))


def refusal(calls):
    """Returns sbatch's message at its n-th call, from 0."""
    lines = text("refusals").splitlines()
    if lines and lines[-1] == "*":
        return lines[min(calls, len(lines) - 2)]
    return lines[calls] if calls < len(lines) else ""


def run(number, options, words):
    os.setsid()
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    job = read_job(number)
    before = [int(one) for one in options.get("dependency", "").split(":")[1:]]
    end = time.monotonic() + SECONDS_MAX
    while any(set(read_job(one)["states"].values()) != {"COMPLETED"} for one in before) and time.monotonic() < end:
        time.sleep(0.02)
    for item in job["states"]:
        job["states"][item] = "RUNNING"
        write_job(number, job)
        environment = dict(os.environ, SLURM_JOB_ID=str(number), SLURMD_NODENAME="here", SLURM_RESTART_COUNT="0")
        output = options["output"].replace("%A", str(number)).replace("%j", str(number)).replace("%a", item)
        if item != "N/A":
            environment.update(SLURM_ARRAY_JOB_ID=str(number), SLURM_ARRAY_TASK_ID=item)
        with open(output, "ab") as said:
            subprocess.run(["/bin/sh", *words], env=environment, stdout=said, stderr=said, check=False,
                           timeout=SECONDS_MAX)
        job["states"][item] = "COMPLETED"
        write_job(number, job)
    os._exit(0)


def sbatch(words):
    options = {}
    while words and words[0].startswith("--"):
        name, _, value = words.pop(0)[2:].partition("=")
        options[name] = value
    items = options["array"].split(",") if options.get("array") else ["N/A"]
    with open(path("calls"), "a+", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        file.seek(0)
        calls = len(file.readlines())
        file.write(options.get("array", "-") + "\n")
    said = refusal(calls)
    if not said and items[-1] != "N/A" and max(map(int, items)) >= int(text("array_max") or 1001):
        said = "Invalid job array specification"
    if said:
        sys.exit(f"sbatch: error: Batch job submission failed: {said}")
    number = calls + 1
    write_job(number, {"name": options["job-name"], "states": {item: "PENDING" for item in items}})
    if os.fork() == 0:
        run(number, options, words)
    print(number)


def squeue():
    for number in numbers():
        job = read_job(number)
        for item, state in job["states"].items():
            print(f"{number}|{item}|{state}|here|{job['name']}|None")


if __name__ == "__main__":
    name = sys.argv[1]
    if name == "sbatch":
        sbatch(sys.argv[2:])
    elif name == "squeue":
        squeue()
