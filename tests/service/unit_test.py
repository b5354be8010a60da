#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks how much of the machine the systemd unit exposes to the service, by `systemd-analyze security`.

Usage: unit_test.py UNIT
Exits with 77 (skipped) without systemd-analyze.
"""
import re
import shutil
import subprocess
import sys

EXPOSURE_MAX = 2.0  # 10 is the end of systemd's scale

if shutil.which("systemd-analyze") is None:
    print("unit_test: skipped: systemd-analyze is not installed (Debian package systemd)")
    sys.exit(77)
scored = subprocess.run(["systemd-analyze", "security", "--no-pager", "--offline=true", sys.argv[1]],
                        capture_output=True, text=True, check=False)
found = re.search(r"Overall exposure level for \S+: ([0-9.]+)", scored.stdout)
if found is None:
    sys.exit(f"FAILED: no score: {scored.stdout[-500:]}{scored.stderr[-500:]}")
print(f"exposure {found.group(1)} of 10, at most {EXPOSURE_MAX}")
verified = subprocess.run(["systemd-analyze", "verify", sys.argv[1]], capture_output=True, text=True, check=False)
wrong = [line for line in verified.stderr.splitlines() if "multum.service" in line and "not executable" not in line]
if float(found.group(1)) > EXPOSURE_MAX or wrong:
    sys.exit("FAILED: " + "; ".join(wrong or ["it is exposed more"]))
