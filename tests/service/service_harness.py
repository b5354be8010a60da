# SPDX-License-Identifier: Apache-2.0
"""Runs a daemon in its own folder, and its clients, for tests of the service. Uses only the standard library."""
import atexit
import hmac
import http.client
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

MULTUM = os.environ.get("MULTUM", "multum-drill")  # multum with a job type for tests, drill/drill_job.h
QUICK = "back_off_first_s = 0.05\nback_off_max_s = 0.2\n"


class Service:
    """Runs `multum serve` on a free loopback port."""

    def __init__(self, multum, folder, options=(), config=None, environment=None):
        self.multum = multum
        self.folder = folder
        self.data = os.path.join(folder, "data")
        self.root = os.path.join(folder, "root")
        os.makedirs(self.root, exist_ok=True)
        self.options = list(options)
        if config is not None:
            path = os.path.join(folder, "serve.toml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(config)
            self.options += ["--config", path]
        # Runs without multum's program cache, for which all kernels of a program would be compiled. PoCL has its own
        # cache and compiles only the kernels that are launched.
        self.environment = dict(os.environ, MULTUM_CACHE_DIR="", **(environment or {}))
        self.log_path = os.path.join(folder, "serve.log")
        self.process = None
        self.port = 0
        self.checker = None  # an OpenapiCheck that checks every answer

    def start(self, wait=True, port=0):
        address = os.path.join(self.data, "address")
        if os.path.exists(address):
            os.remove(address)
        with open(self.log_path, "ab") as log:
            self.process = subprocess.Popen(
                [self.multum, "serve", "--data", self.data, "--root", self.root, "--listen", f"127.0.0.1:{port}"]
                + self.options,
                stdout=log, stderr=log, cwd=self.folder, env=self.environment)
        atexit.register(self.end, self.process)
        deadline = time.monotonic() + 30
        while wait and time.monotonic() < deadline:
            if os.path.exists(address):
                with open(address, encoding="utf-8") as file:
                    self.port = int(file.read().strip().rsplit(":", 1)[1])
                return self
            if self.process.poll() is not None:
                raise AssertionError(f"the daemon ended with {self.process.returncode}: {self.log_text()[-2000:]}")
            time.sleep(0.01)
        assert not wait, f"the daemon does not listen: {self.log_text()[-2000:]}"
        return self

    def log_text(self):
        with open(self.log_path, encoding="utf-8", errors="replace") as file:
            return file.read()

    def wait_for_log(self, words, timeout=10):
        deadline = time.monotonic() + timeout
        while words not in self.log_text():
            assert time.monotonic() < deadline, f"the log does not say {words!r}: {self.log_text()[-1000:]}"
            time.sleep(0.02)

    @staticmethod
    def end(process):
        """Ends the daemon, even after a failed test."""
        if process.poll() is None:
            process.kill()
            process.wait()

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def stop(self, timeout=60):
        """Sends SIGTERM and returns the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout)

    def workers(self):
        """Returns the process numbers of the workers."""
        path = f"/proc/{self.process.pid}/task/{self.process.pid}/children"
        try:
            with open(path, encoding="utf-8") as file:
                return [int(pid) for pid in file.read().split()]
        except FileNotFoundError:
            return []

    def connection(self, timeout=30):
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)

    def ask(self, method, target, body=None, headers=None, connection=None, timeout=30):
        """Returns the status and the answer, which is parsed if it is JSON. Other answers are returned as bytes."""
        use = connection or self.connection(timeout)
        data = None if body is None else json.dumps(body)
        use.request(method, target, data, headers or {})
        response = use.getresponse()
        text = response.read()
        if connection is None:
            use.close()
        if self.checker is not None:
            self.checker.check(method, target, response.status, response.headers, text)
        if response.headers.get("Content-Type", "").startswith("application/json"):
            return response.status, json.loads(text)
        return response.status, text

    def metric(self, name):
        text = self.ask("GET", "/metrics")[1].decode()
        return next(float(line.split()[-1]) for line in text.splitlines() if line.startswith(name + " "))

    def submit(self, **job):
        status, answer = self.ask("POST", "/v1/jobs", job)
        assert status in (200, 201), (status, answer)
        return answer["id"]

    def job(self, number):
        status, answer = self.ask("GET", f"/v1/jobs/{number}")
        assert status == 200, (status, answer)
        return answer

    def counts(self, queue="default"):
        status, answer = self.ask("GET", "/v1/queues")
        assert status == 200, (status, answer)
        return next(one["jobs"] for one in answer["queues"] if one["name"] == queue)

    def wait_for(self, number, states=("succeeded", "dead", "cancelled"), timeout=60):
        deadline = time.monotonic() + timeout
        while True:
            job = self.job(number)
            if job["state"] in states:
                return job
            assert time.monotonic() < deadline, f"job {number} is still {job['state']}: {job}"
            time.sleep(0.02)

    def wait_until_idle(self, timeout=300):
        deadline = time.monotonic() + timeout
        while True:
            counts = self.counts()
            if all(counts[state] == 0 for state in ("waiting", "queued", "running", "publishing")):
                return counts
            assert time.monotonic() < deadline, f"jobs are left: {counts}"
            time.sleep(0.05)


class ServiceCase(unittest.TestCase):
    """A test with its own folder and its own daemon. `start()` of the subclass starts the daemon, which ends with the
    test."""

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.service = None

    def tearDown(self):
        if self.service is not None and self.service.process.poll() is None:
            self.service.kill()
        shutil.rmtree(self.folder)


class ClientCase(ServiceCase):
    """Contains helpers for tests that use the daemon as clients do."""

    checks_answers = False  # if true, each answer is checked against docs/reference/openapi.json

    def start(self, config=QUICK, **more):
        self.service = Service(MULTUM, self.folder, config=config, **more).start()
        if self.checks_answers:
            from openapi_check import OpenapiCheck  # this import needs a package that is not available to all tests
            self.service.checker = OpenapiCheck(self.service.ask("GET", "/openapi.json")[1])
        return self.service

    def output(self, name):
        return os.path.join(self.service.root, name)

    def results(self):
        return os.path.join(os.path.realpath(self.service.data), "results")

    def drill(self, seconds=0, **job):
        """Submits a job that does nothing and ends as its parameters say."""
        parameters = {"seconds": seconds}
        for name in ("then", "text"):
            if name in job:
                parameters[name] = job.pop(name)
        return self.service.submit(type="drill", parameters=parameters, **job)

    def client(self, *arguments, code=0):
        done = subprocess.run([MULTUM, "jobs", *arguments], capture_output=True, text=True, check=False, timeout=60,
                              env=dict(os.environ, MULTUM_SERVER=f"http://127.0.0.1:{self.service.port}"))
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout + done.stderr

    def refused(self, status, code, values, *question, **more):
        """Checks that the message contains all `values` (keys, names and numbers), whatever its wording is. Returns
        the message."""
        found, answer = self.service.ask(*question, **more)
        self.assertEqual((found, answer["error"]["code"]), (status, code), answer)
        for value in values:
            self.assertIn(value, answer["error"]["message"])
        return answer["error"]["message"]


def with_drill(document, types):
    """Returns docs/reference/openapi.json, which describes multum, with the additional job type of multum-drill.
    `types` is the answer of /v1/types."""
    schemas = document["components"]["schemas"]
    schemas["DrillParameters"] = next(one["parameters"] for one in types["types"] if one["name"] == "drill")
    schemas["Submission"]["properties"]["type"]["enum"].append("drill")
    schemas["Submission"]["allOf"].append({
        "if": {"properties": {"type": {"const": "drill"}}, "required": ["type"]},
        "then": {"properties": {"parameters": {"$ref": "#/components/schemas/DrillParameters"}}}})
    return document


def seal_listing(data, folder, lines):
    """Writes the list of files in a published folder as the daemon with these DATA would write it."""
    with open(os.path.join(data, "seal"), encoding="utf-8") as file:
        key = file.read().strip().encode()
    text = f"multum-result {os.stat(folder).st_ino}\n{lines}".encode("utf-8", "surrogateescape")
    with open(os.path.join(folder, ".multum-result"), "w", encoding="utf-8", errors="surrogateescape") as file:
        file.write(f"{lines}seal {hmac.new(key, text, 'sha256').hexdigest()}\n")


def listed_files(folder):
    """Returns the lines of such a list that name files."""
    with open(os.path.join(folder, ".multum-result"), encoding="utf-8", errors="surrogateescape") as file:
        return "".join(line for line in file if not line.startswith("seal "))


def resident_bytes(pid):
    with open(f"/proc/{pid}/statm", encoding="utf-8") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


def process_state(pid):
    """Returns resident bytes, open files and threads."""
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        threads = int(file.read().rsplit(")", 1)[1].split()[17])
    return resident_bytes(pid), len(os.listdir(f"/proc/{pid}/fd")), threads


def is_sanitized(pid):
    """Returns whether the program was built with a sanitizer, which needs additional memory."""
    with open(f"/proc/{pid}/maps", encoding="utf-8") as file:
        text = file.read()
    return "libasan" in text or "libtsan" in text


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def fail(message):
    print(f"FAILED: {message}")
    sys.exit(1)
