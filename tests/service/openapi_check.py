# SPDX-License-Identifier: Apache-2.0
"""Compares answers with the OpenAPI 3.1 file of the service: the operation, its status, and the type and schema of the
body."""
import json
import re
import warnings

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # version 4.10 still has this resolver; newer versions have a
                                                         # different one
    from jsonschema import Draft202012Validator, FormatChecker, RefResolver

TIME = re.compile(r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z$")
FORMATS = FormatChecker(formats=[])
FORMATS.checks("date-time")(lambda value: not isinstance(value, str) or bool(TIME.match(value)))


class OpenapiCheck:
    """Records the checked answers. `seen` contains (method, path template, status)."""

    def __init__(self, document):
        self.document = document
        self.resolver = RefResolver("", document)
        self.validators = {}
        self.paths = [(re.compile("^" + re.sub(r"\\{\w+\\}", "[^/]*", re.escape(path)) + "$"), path)
                      for path in document["paths"]]
        self.seen = set()

    def resolved(self, node):
        while "$ref" in node:
            node = self.resolver.resolve(node["$ref"])[1]
        return node

    def errors(self, schema, value):
        """Returns messages about differences from the schema."""
        key = json.dumps(schema)
        if key not in self.validators:
            self.validators[key] = Draft202012Validator(schema, resolver=self.resolver, format_checker=FORMATS)
        return [f"{'/'.join(map(str, error.absolute_path))}: {error.message[:300]}"
                for error in self.validators[key].iter_errors(value)]

    def template_of(self, target):
        path = target.split("?")[0]
        # A path without placeholders takes precedence over a path with placeholders.
        found = [template for pattern, template in self.paths if pattern.match(path)]
        return min(found, key=lambda one: one.count("{"), default=None)

    def check(self, method, target, status, headers, body):
        """Raises AssertionError that names the difference from the file."""
        method = "get" if method == "HEAD" else method.lower()
        template = self.template_of(target)
        operation = self.document["paths"].get(template, {}).get(method)
        name = f"{method.upper()} {target[:100]} -> {status}"
        self.seen.add((method, template, status))
        if operation is None:
            assert status in (400, 403, 404, 405), f"{name}: is not described, expected 403, 404 or 405"
            schema, kind = {"$ref": "#/components/schemas/Refusal"}, "application/json"
        else:
            responses = operation["responses"]
            response = responses.get(str(status)) or responses.get(f"{status // 100}XX")
            assert response is not None, f"{name}: found an undescribed status, expected one of {sorted(responses)}"
            content = self.resolved(response).get("content", {})
            kind = headers.get("Content-Type", "")
            assert kind in content, f"{name}: is {kind!r}, expected one of {sorted(content)}"
            schema = content[kind]["schema"]
        assert headers.get("Content-Type") == kind, f"{name}: is {headers.get('Content-Type')!r}"
        if kind == "application/json":
            wrong = self.errors(schema, json.loads(body))
            assert not wrong, f"{name}: {'; '.join(wrong)}: {body[:500]}"
