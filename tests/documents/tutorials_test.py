#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the commands of one tutorial and compares what they print with the page.

  tutorials_test.py PAGE PROGRAMS      # PROGRAMS: folder of multum; exit code 77: skipped, with the reason on stdout

- All ```sh blocks run in order, in one shell (bash -eu), in one empty folder.
- A ```text block right after a ```sh block shows its output. Each line must be a line of the real output. Numbers, and
  runs of spaces and dashes, may differ. A line that ends in " ..." shows only its beginning; "..." stands for any
  lines.
- <!-- page: URL title: TEXT --> opens URL in headless Chromium. The page's title must become TEXT, without errors.
- <!-- needs: PROGRAM... --> skips the test where one of these programs is missing.
- Ports on this machine, such as 127.0.0.1:8000, are replaced by free ones.
- `npm install` finds the packages of tests/service/web in a registry that this script serves: no network is used.
"""
import http.server
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tarfile
import tempfile
import threading

HERE = pathlib.Path(__file__).resolve().parent
MODULES = HERE.parent / "service/web/node_modules"
SKIPPED = 77
SECONDS_MAX = 540
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$|^<!-- (page|needs): (.*?) -->$", re.DOTALL | re.MULTILINE)
PORT = re.compile(r"(?:127\.0\.0\.1:|localhost:|http\.server )(\d{4,5})\b")


def parse(text):
    """Returns [kind, text, expected] for each step: commands with the lines that they must print, pages to open, and
    programs needed."""
    steps, last_end = [], None
    for found in BLOCK.finditer(text):
        kind, body = found[1] or found[3], found[2] if found[2] is not None else found[4]
        if kind in ("sh", "page", "needs"):
            steps.append([kind, body, []])
        elif kind == "text" and steps and steps[-1][0] == "sh" and text[last_end:found.start()].strip() == "":
            steps[-1][2] += body.splitlines()
        last_end = found.end()
    return steps


def plain(line):
    """Returns the line without the parts that may differ: numbers, and the spaces and dashes that align columns."""
    return re.sub(r"[\s-]+", " ", re.sub(r"\d+(\.\d+)?(e[+-]?\d+)?", "#", line)).strip()


def missing_lines(expected, output):
    found = [plain(line) for line in output.splitlines()]
    for line in expected:
        want = plain(line)
        if want in ("", "..."):
            continue
        if want.endswith("..."):
            if not any(one.startswith(want[:-3].rstrip()) for one in found):
                yield line
        elif want not in found:
            yield line


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return str(one.getsockname()[1])


def with_free_ports(text):
    ports = {port: free_port() for port in sorted(set(PORT.findall(text)))}
    for port, free in ports.items():
        text = re.sub(rf"\b{port}\b", free, text)
    return text


class Registry(http.server.BaseHTTPRequestHandler):
    """Answers npm with the packages of MODULES, as a registry does."""

    def log_message(self, *_):
        pass

    def do_GET(self):  # noqa: N802, the name that http.server requires
        name = self.path.strip("/").replace("%2f", "/")
        package = MODULES / name.removesuffix(".tgz") / "package.json"
        if ".." in name or not package.is_file():
            return self.send_error(404)
        facts = json.loads(package.read_text(encoding="utf-8"))
        if name.endswith(".tgz"):
            return self.answer("application/octet-stream", self.packed(package.parent))
        url = f"http://127.0.0.1:{self.server.server_port}/{name}.tgz"
        versions = {facts["version"]: {**facts, "dist": {"tarball": url}}}
        known = {"name": name, "dist-tags": {"latest": facts["version"]}, "versions": versions}
        return self.answer("application/json", json.dumps(known).encode())

    def answer(self, kind, body):
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def packed(self, folder):
        with tempfile.TemporaryFile() as file:
            with tarfile.open(fileobj=file, mode="w:gz", compresslevel=1) as archive:
                archive.add(folder, "package")
            file.seek(0)
            return file.read()


def reason_to_skip(steps, programs):
    commands = "\n".join(text for kind, text, _ in steps if kind == "sh")
    words = [word for kind, text, _ in steps if kind == "needs" for word in text.split()]
    for word in words:
        if not shutil.which(word) and not (programs / word).is_file():
            return f"no {word}"
    for word in sorted(set(re.findall(r"^(?:time )?(multum[\w-]*)", commands, re.MULTILINE))):
        if not (programs / word).is_file():
            return f"no {word} was built"
    if re.search(r"^npm ", commands, re.MULTILINE):
        if not shutil.which("npm"):
            return "no npm (Debian package npm)"
        for package in re.findall(r"(?<=\s)([a-z][\w-]*)@[\d.]+", commands):
            if not (MODULES / package).is_dir():
                return f"no npm package {package}: tools/install_dependencies test"
    if any(kind == "page" for kind, _, _ in steps):
        if not shutil.which("chromium-headless-shell") and not shutil.which("chromium"):
            return "no Chromium (Debian package chromium-headless-shell)"
        if not shutil.which("node") or not (MODULES / "playwright-core").is_dir():
            return "no Node.js or no playwright-core: tools/install_dependencies test"
    return None


def script_of(steps):
    """Returns one bash script. After each step, the script prints the number of the step, which separates the
    outputs."""
    lines = ["set -eu", "exec 2>&1"]
    for number, (kind, text, _) in enumerate(steps):
        if kind == "sh":
            lines.append(text)
        elif kind == "page":
            url, title = (word.strip() for word in text.split(" title: "))
            host, port = re.search(r"//([\w.]+):(\d+)", url).groups()
            lines.append(f"for i in {{1..100}}; do (: < /dev/tcp/{host}/{port}) && break; sleep 0.1; done 2> /dev/null")
            lines.append(shlex.join(["node", str(HERE / "open_page.mjs"), url, title]))
        lines.append(f"echo; echo '=== step {number} done'")
    return "\n".join(lines) + "\n"


def failures(steps, output):
    for number, (_, text, expected) in enumerate(steps):
        before, mark, after = output.partition(f"\n=== step {number} done\n")
        if not mark:
            yield f"failed:\n{text}\nIt printed:\n{before}"
            return
        output = after
        for line in missing_lines(expected, before):
            yield f"the page says:\n  {line}\nwhich is not printed by:\n{text}\nIt printed:\n{before}"


def run(steps, programs, folder, registry):
    environment = {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "HOME": str(folder.parent),
                   "npm_config_registry": registry, "npm_config_audit": "false", "npm_config_fund": "false",
                   "npm_config_update_notifier": "false", "LC_ALL": "C.UTF-8"}
    with subprocess.Popen(["bash", "-c", script_of(steps)], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, start_new_session=True) as shell:
        late = threading.Timer(SECONDS_MAX, os.killpg, (shell.pid, signal.SIGKILL))
        late.start()
        try:
            output = read_until_exit(shell)
        finally:
            late.cancel()
            try:
                os.killpg(shell.pid, signal.SIGKILL)  # servers that the page's commands left running
            except ProcessLookupError:
                pass
    return output


def read_until_exit(shell):
    """Returns the output until the shell ends. Does not wait for its servers, which may keep the pipe open."""
    pieces = []
    reader = threading.Thread(target=lambda: pieces.extend(iter(lambda: shell.stdout.read1(65536), b"")), daemon=True)
    reader.start()
    shell.wait()
    reader.join(timeout=2)
    return b"".join(pieces).decode(errors="replace")


def main():
    page, programs = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    steps = parse(with_free_ports(page.read_text(encoding="utf-8")))
    if not any(kind == "sh" for kind, _, _ in steps):
        sys.exit(f"{page.name}: has no ```sh block")
    reason = reason_to_skip(steps, programs)
    if reason:
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Registry) as registry, \
            tempfile.TemporaryDirectory(prefix="multum-tutorial-", ignore_cleanup_errors=True) as made:
        threading.Thread(target=registry.serve_forever, daemon=True).start()
        folder = pathlib.Path(made) / "empty"
        folder.mkdir()
        found = list(failures(steps, run(steps, programs, folder, f"http://127.0.0.1:{registry.server_port}/")))
        registry.shutdown()
    for failure in found:
        print(f"{page.name}: {failure}\n")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
