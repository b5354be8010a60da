#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the service's page in Debian's headless Chromium: starts web_test.mjs, and the daemons that the script asks
for.

  web_test.py MULTUM SCREENSHOTS [--only STEP]      exits with 77 (skipped) without Chromium, Node or playwright-core
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from service_harness import Service  # noqa: E402
from slurm_harness import Slurm, why_not  # noqa: E402
from slurm_test import CONFIG as FARM_CONFIG, SLOW_PROGRAM, write_program  # noqa: E402
from tiny_animation import write_animation  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
CONFIG = """back_off_first_s = 0.05
back_off_max_s = 0.2
workers = 2
shutdown_grace_s = 1
[[queue]]
name = "default"
[[queue]]
name = "night"
jobs = 1
memory_max = "2G"
priority = -5
"""
TOKEN = "a token of many letters"


def browser():
    """Prefers the headless shell. Without the windows of the browser, the test takes half of the time."""
    return shutil.which("chromium-headless-shell") or shutil.which("chromium")


def missing():
    if shutil.which("node") is None:
        return "node"
    if browser() is None:
        return "chromium-headless-shell"
    return None if os.path.isdir(os.path.join(HERE, "web/node_modules/playwright-core")) else "playwright-core"


class Driver:
    """Runs the daemons that web_test.mjs asks for."""

    def __init__(self, multum, folder):
        self.multum = multum
        self.folder = folder
        self.services = {}
        self.slurm = None

    def start(self, name):
        folder = os.path.join(self.folder, name)
        os.makedirs(folder, exist_ok=True)
        service = self.services.get(name)
        if service is None:
            options = []
            if name == "guarded":
                path = os.path.join(folder, "token")
                with open(path, "w", encoding="utf-8") as file:
                    file.write(TOKEN + "\n")
                os.chmod(path, 0o600)
                options = ["--token-file", path]
            service = self.services[name] = Service(self.multum, folder, options, CONFIG)
        service.start(port=service.port)  # keeps the same port after a restart
        return {"url": f"http://127.0.0.1:{service.port}", "root": service.root, "token": TOKEN}

    def stop(self, name):
        return self.services[name].stop()

    def farm(self):
        """Starts a service with a Slurm with two nodes, on which share 1 of a map waits for the file `go`."""
        if why_not():
            return {"why": why_not()}
        folder = os.path.join(self.folder, "farm")
        shared = os.path.join(folder, "shared")
        os.makedirs(shared, mode=0o700)
        self.slurm = Slurm(os.path.join(folder, "slurm")).start()
        program = write_program(os.path.join(folder, "node-program"),
                                SLOW_PROGRAM.format(folder=folder, multum=self.multum))
        config = FARM_CONFIG.format(folder=shared, more=f'share_s = 0.7\nprogram = "{program}"', poll=0.1)
        service = Service(self.multum, folder, (), config, self.slurm.environment).start()
        self.services["farm"] = service
        self.testmap(os.path.join(service.root, "map"), 256)
        return {"url": f"http://127.0.0.1:{service.port}", "root": service.root, "go": os.path.join(folder, "go")}

    def testmap(self, prefix, size=64):
        subprocess.run([self.multum, "testmap", "--size", str(size), prefix], check=True, capture_output=True)

    def field(self, folder):
        """Writes an inferred animation of one sample to FOLDER/field."""
        write_animation(folder, 0.25)
        subprocess.run([self.multum, "infer", os.path.join(folder, "animation.toml"), "-o",
                        os.path.join(folder, "field"), "--context=osmesa", "--no-frames", "--no-comparison"],
                       check=True, capture_output=True)

    def close(self):
        for service in self.services.values():
            if service.process.poll() is None:
                service.kill()
        if self.slurm is not None:
            self.slurm.stop()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("multum")
    parser.add_argument("screenshots")
    parser.add_argument("--only", default="", help="a step's name, or a part of it")
    arguments = parser.parse_args()
    if missing() is not None:
        print(f"{missing()} is not installed: tools/install_dependencies test")
        return 77
    os.makedirs(arguments.screenshots, exist_ok=True)
    folder = tempfile.mkdtemp()
    driver = Driver(os.path.abspath(arguments.multum), folder)
    # HOME is a temporary folder, because Chromium writes there. The user who runs the tests may not have a writable
    # home folder.
    environment = dict(os.environ, HOME=folder)
    try:
        with subprocess.Popen(["node", os.path.join(HERE, "web_test.mjs"), browser(),
                               os.path.abspath(arguments.screenshots), arguments.only], env=environment, text=True,
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE) as node:
            for line in node.stdout:
                if not line.startswith("@"):
                    print(line, end="", flush=True)
                    continue
                name, *words = json.loads(line[1:])
                node.stdin.write(json.dumps(getattr(driver, name)(*words)) + "\n")
                node.stdin.flush()
        return node.returncode
    finally:
        driver.close()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
