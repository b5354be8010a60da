# SPDX-License-Identifier: Apache-2.0
"""Runs a program and measures its costs."""
import dataclasses
import os
import subprocess
import sys
import tempfile
import time


@dataclasses.dataclass
class Run:
    """The costs of one run of a program. The processor seconds include the children of the program. The memory is the
    peak of one process."""
    code: int
    text: str
    seconds: float
    processor_seconds: float
    memory_bytes: int


def run(command):
    begin = time.monotonic()
    with tempfile.TemporaryFile("w+") as said:
        child = subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL, stdout=said, stderr=said)
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        return Run(child.returncode, said.read(), time.monotonic() - begin, used.ru_utime + used.ru_stime,
                   1024 * used.ru_maxrss)


def succeed(command):
    done = run(command)
    if done.code != 0:
        last = "\n".join(done.text.splitlines()[-20:])
        sys.exit(f"exit code {done.code}: {' '.join(map(str, command))}\n{last}")
    return done
