#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sends requests made from the service's own OpenAPI file, some valid and most invalid. Each answer must match the
file: 400 for what its schemas refuse, success for what they accept, 404 for what does not exist, and never 500. At the
end the service must run and have no more memory, files or threads than before.

  fault_injection/fuzz.py MULTUM_DRILL [--requests 10000] [--seed 1]
"""
import argparse
import collections
import http.client
import json
import os
import random
import sys
import time
import tempfile
import urllib.parse

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from openapi_check import OpenapiCheck  # noqa: E402
from service_harness import Service, fail, process_state, with_drill  # noqa: E402

# These are reasons that the OpenAPI file cannot express, such as which queues, jobs and files exist.
REASONS = ("expected one of default", "which does not exist", "which is ", "not below a folder",
           "expected the absolute", "not a valid name for a result", "there is no such file",
           "its folder does not exist", "expected a name ending in", "unknown state", "not a file")
STRANGE_TEXTS = ("", " ", "default", "../../etc/passwd", "%2e%2e", "a" * 1000, "a" * 1001, "\u00e9" * 1000,
                 "\u00e9" * 1001, "\U0001f9f1" * 300, "line\nbreak and more", "nul\x00nul", "<script>alert(1)</script>",
                 "' OR 1=1 --", "-1")
STRANGE_NUMBERS = (0, -1, 1, 1.0, 1.5, -0.0, 1e308, 1e-320, 2**31, 2**53 + 1, 2**63 - 1, 2**63, 2**64, -2**63, 10**30)
STRANGE = (None, True, False, [], {}, [[]], {"a": {"b": []}}) + STRANGE_TEXTS + STRANGE_NUMBERS
RAW = (b"", b"{", b"}", b"[]", b"null", b"{\"type\":", b"\xff\xfe", b"{\"type\":\"\xc3\x28\"}", b"NaN",
       b"{\"type\":\"drill\",}",
       b"[" * 5000, b"{\"a\":" * 3000, b"\x00" * 64, b"1e999", b"{\"type\":\"drill\"} trailing", b"\xef\xbb\xbf{}")


class Fuzzer:
    def __init__(self, document, check, seed):
        self.document, self.check, self.random = document, check, random.Random(seed)
        self.operations = [(path, method, operation) for path, methods in document["paths"].items()
                           for method, operation in methods.items() if not path.endswith("/events")
                           for _ in range(5 if "requestBody" in operation else 1)]

    def value_of(self, schema):
        """Returns a value that the schema usually accepts."""
        schema = self.check.resolved(schema)
        choose = self.random
        if "const" in schema:
            return schema["const"]
        if "anyOf" in schema:
            schema = choose.choice(schema["anyOf"])
        if "enum" in schema:
            return choose.choice(schema["enum"])
        kind = schema.get("type", "string")
        if kind == "object":
            properties, required = schema.get("properties", {}), schema.get("required", [])
            return {name: self.value_of(one) for name, one in properties.items()
                    if name in required or choose.random() < 0.3}
        if kind == "array":
            return [self.value_of(schema["items"]) for _ in range(choose.choice((0, 1, 3)))]
        if kind in ("integer", "number"):
            least, most = schema.get("minimum", -1000), schema.get("maximum", 1000)
            value = choose.choice((least, most, choose.uniform(least, most)))
            return int(value) if kind == "integer" else value
        if kind == "boolean":
            return choose.random() < 0.5
        return choose.choice(("a", "some text", "\u00e4\u00f6\u00fc", "x" * choose.randrange(1, 100)))

    def submission(self):
        types = [one for one in self.document["components"]["schemas"]["Submission"]["properties"]["type"]["enum"]]
        name = self.random.choice(types + ["drill"] * 6)
        job = self.value_of({"$ref": "#/components/schemas/Submission"})
        job["type"] = name
        job["parameters"] = self.value_of({"$ref": f"#/components/schemas/{name.capitalize()}Parameters"})
        if self.random.random() < 0.7:  # a value that is accepted
            for key in ("needs", "queue", "output", "device"):
                job.pop(key, None)
        return job

    def spoil(self, value):
        """Returns the value with one part changed."""
        choose = self.random
        if isinstance(value, dict) and value and choose.random() < 0.8:
            key = choose.choice(list(value))
            changed = dict(value)
            what = choose.random()
            if what < 0.2:
                del changed[key]
            elif what < 0.35:
                changed[choose.choice(("colour", "", "__proto__", "x" * 500, "type\u0000"))] = choose.choice(STRANGE)
            else:
                changed[key] = self.spoil(value[key])
            return changed
        if isinstance(value, list) and value and choose.random() < 0.7:
            return [self.spoil(value[0])] * choose.choice((1, 2, 1001))
        return choose.choice(STRANGE)

    def body(self, operation):
        """Returns bytes, and whether the schema accepts them."""
        content = operation["requestBody"]["content"]
        if "application/json" not in content:
            return self.random.randbytes(self.random.randrange(2000)), True
        schema = content["application/json"]["schema"]
        value = self.submission() if schema["$ref"].endswith("/Submission") else self.value_of(schema)
        if self.random.random() < 0.15:
            data = self.random.choice(RAW)
            try:
                value = json.loads(data.decode("utf-8-sig") or "{}", parse_constant=lambda _: 1 / 0)
            except (ValueError, ZeroDivisionError, RecursionError):
                return data, False
            return data, not self.check.errors(schema, value)
        if self.random.random() < 0.7:
            value = self.spoil(value)
        return json.dumps(value, ensure_ascii=self.random.random() < 0.5).encode(), not self.check.errors(schema, value)

    def path_part(self, jobs):
        choose = self.random
        part = choose.choice((str(choose.randint(1, max(1, jobs))), str(10**9), "0", "-1", "1.5", "x", "default", "..",
                              ".", "a.png", "1e3", "9" * 40, choose.choice(STRANGE_TEXTS)[:300]))
        return urllib.parse.quote(part, safe="")

    def target(self, path, operation, jobs):
        parts = [self.path_part(jobs) if part.startswith("{") else part for part in path.split("/")]
        target = "/".join(parts)
        names = [one["name"] for one in operation.get("parameters", []) if one.get("in") == "query"]
        if names and self.random.random() < 0.7:
            target += "?" + "&".join(
                f"{self.random.choice(names + ['colour'])}="
                f"{urllib.parse.quote(str(self.random.choice(STRANGE + ('queued', 'dead', 'default', 10, 1000))))}"
                for _ in range(self.random.choice((1, 1, 2, 5))))
        return target

    def next(self, jobs):
        """Returns (method, target, body, accepted statuses)."""
        choose = self.random
        path, method, operation = choose.choice(self.operations)
        target = self.target(path, operation, jobs)
        what = choose.random()
        if what < 0.06:
            return choose.choice(("DELETE", "PATCH", "OPTIONS", "BREW")), target, None, (404, 405)
        if what < 0.12:
            longer = target.rstrip("/") + "/" + self.path_part(jobs)
            return method.upper(), longer, None, (400, 404, 405, 409, 200, 201, 202)
        if path == "/v1/queues/{queue}/resume":
            return "POST", "/v1/queues/nobody/resume", None, (404,)  # the jobs of the fuzzer must not run
        if "requestBody" not in operation:
            if "?" in target:
                return method.upper(), target, None, (200, 400)
            return method.upper(), target, None, (200, 202, 404, 409) if "{" in path else (200,)
        body, is_taken = self.body(operation)
        if not is_taken:
            refused = (400, 404) if "{" in path else (400,)  # a target may not match any route
            return method.upper(), target, body, refused if len(body) <= 1 << 20 else (413,)
        right = tuple(int(one) for one in operation["responses"] if one.isdigit() and one < "300")
        return method.upper(), target, body, right + ((400, 404, 409) if "{" in path else (REASONS,))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("multum")
    parser.add_argument("--requests", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(f"seed {options.seed}")
    with tempfile.TemporaryDirectory() as folder:
        service = Service(options.multum, folder, config='[[queue]]\nname = "default"\npaused = true\n').start()
        check = OpenapiCheck(with_drill(service.ask("GET", "/openapi.json")[1], service.ask("GET", "/v1/types")[1]))
        fuzzer = Fuzzer(check.document, check, options.seed)
        statuses, jobs = collections.Counter(), 0

        def state():
            return process_state(service.process.pid)

        before = None
        connection = service.connection()
        for number in range(options.requests):
            if number == options.requests // 5:  # all caches are filled by this time
                connection.close()
                before = state()
            method, target, body, right = fuzzer.next(jobs)
            try:
                connection.request(method, target, body)
                response = connection.getresponse()
            except (http.client.HTTPException, OSError):  # the daemon closes a connection after a refusal
                connection.close()
                connection.request(method, target, body)
                response = connection.getresponse()
            text = response.read()
            if response.will_close:
                connection.close()
            statuses[response.status] += 1
            request = f"request {number}: {method} {target[:200]} {(body or b'')[:300]}"
            try:
                check.check(method, target, response.status, response.headers, text)
            except AssertionError as wrong:
                fail(f"{request}: {wrong}")
            reasons = next((one for one in right if isinstance(one, tuple)), ())
            is_right = response.status in right or (response.status == 400 and "%00" in target) or (
                response.status == 431 and len(target) > 15000)
            if not is_right and response.status == 400 and reasons:
                is_right = any(reason in json.loads(text)["error"]["message"] for reason in reasons)
            if not is_right:
                fail(f"{request}: {response.status}, expected {right}: {text[:300]}")
            if response.status == 201 and target == "/v1/jobs":
                jobs = json.loads(text)["id"]
        connection.close()
        assert service.ask("GET", "/healthz")[0] == 200 and service.process.poll() is None
        after = state()
        end = time.monotonic() + 10  # the daemon closes connections only after a delay
        while after[1] > before[1] and time.monotonic() < end:
            time.sleep(0.05)
            after = state()
        print(f"{options.requests} requests, {jobs} jobs accepted, by status: {dict(sorted(statuses.items()))}")
        print(f"resident {before[0] >> 10} -> {after[0] >> 10} KiB, files {before[1]} -> {after[1]}, threads "
              f"{before[2]} -> {after[2]}")
        described = {(method, path, status) for path, methods in check.document["paths"].items() for method, one
                     in methods.items() for status in one["responses"] if status.isdigit()}
        print(f"{len(check.seen)} kinds of answers; described successes that never occurred: " + ", ".join(sorted(
            f"{method.upper()} {path} {status}" for method, path, status in described
            if int(status) < 300 and (method, path, int(status)) not in check.seen)))
        if after[0] > before[0] + (8 << 20) or after[1] > before[1] or after[2] > before[2]:
            fail("something is left behind")
        if min(statuses[one] for one in (200, 201, 202, 400, 404, 405)) == 0:
            fail("a kind of answer never occurred")
        assert service.stop() == 0


if __name__ == "__main__":
    main()
