# SPDX-License-Identifier: Apache-2.0
"""Contains JSON schemas for Open Job Description's "Template Schemas", revision 2023-09, sections 1 to 7, and for RFC
0001 (TASK_CHUNKING). The schemas cover the parts that multum's bundles use, and refuse everything else in a
template."""

IDENTIFIER = {"type": "string", "pattern": r"^[A-Za-z_][A-Za-z0-9_]{0,63}$"}  # 7.2
NAME = {"type": "string", "minLength": 1, "maxLength": 128, "pattern": r"^[^\x00-\x1f\x7f-\x9f]+$"}
STEP_NAME = {**NAME, "maxLength": 64}
FORMAT_STRING = {"type": "string", "minLength": 1}


def closed(required, **optional):
    """An object with these properties and no others."""
    return {"type": "object", "required": sorted(required), "additionalProperties": False,
            "properties": {**required, **optional}}


PATH_PARAMETER = closed(  # 2.3
    {"name": IDENTIFIER, "type": {"const": "PATH"}}, description={"type": "string", "maxLength": 2048},
    default={"type": "string", "minLength": 1, "maxLength": 1024}, objectType={"enum": ["FILE", "DIRECTORY"]},
    dataFlow={"enum": ["NONE", "IN", "OUT", "INOUT"]})
STRING_PARAMETER = closed(  # 2.1
    {"name": IDENTIFIER, "type": {"const": "STRING"}}, description={"type": "string", "maxLength": 2048},
    default={"type": "string", "maxLength": 1024})
CHUNKS = closed(  # RFC 0001
    {"defaultTaskCount": {"type": "integer", "minimum": 1},
     "rangeConstraint": {"enum": ["CONTIGUOUS", "NONCONTIGUOUS"]}},
    targetRuntimeSeconds={"type": "integer", "minimum": 0})
CHUNKED_PARAMETER = closed(
    {"name": IDENTIFIER, "type": {"const": "CHUNK[INT]"},
     "range": {"type": "string", "pattern": r"^\d+(-\d+(:\d+)?)?$"}, "chunks": CHUNKS})
INT_PARAMETER = closed({"name": IDENTIFIER, "type": {"const": "INT"},  # 3.4.1
                        "range": {"type": "string", "pattern": r"^\d+(-\d+(:\d+)?)?$"}})
CANCELATION = closed(  # 5.1.2
    {"mode": {"const": "NOTIFY_THEN_TERMINATE"}},
    notifyPeriodInSeconds={"type": "integer", "minimum": 1, "maximum": 600})
ACTION = closed({"command": FORMAT_STRING}, args={"type": "array", "minItems": 1, "items": {"type": "string"}},
                timeout={"type": "integer", "minimum": 1}, cancelation=CANCELATION)
HOST = closed({"amounts": {"type": "array", "minItems": 1, "maxItems": 50, "items": closed(
    {"name": {"type": "string", "pattern": r"^amount\.(worker\.(vcpu|memory|gpu|gpu\.memory|disk\.scratch)|[a-z.]+)$"}},
    min={"type": "number", "minimum": 0}, max={"type": "number", "exclusiveMinimum": 0})}})
STEP = closed(  # 3
    {"name": STEP_NAME, "script": closed({"actions": closed({"onRun": ACTION})})},
    parameterSpace=closed({"taskParameterDefinitions": {
        "type": "array", "minItems": 1, "maxItems": 16, "items": {"oneOf": [CHUNKED_PARAMETER, INT_PARAMETER]}}}),
    dependencies={"type": "array", "minItems": 1, "items": closed({"dependsOn": STEP_NAME})}, hostRequirements=HOST)
TEMPLATE = {"$schema": "http://json-schema.org/draft-07/schema#", **closed(  # 1.1
    {"specificationVersion": {"const": "jobtemplate-2023-09"}, "name": NAME,
     "steps": {"type": "array", "minItems": 1, "items": STEP}},
    extensions={"type": "array", "minItems": 1, "uniqueItems": True, "items": {"enum": ["TASK_CHUNKING"]}},
    description={"type": "string", "maxLength": 2048},
    parameterDefinitions={"type": "array", "minItems": 1, "maxItems": 50,
                          "items": {"oneOf": [PATH_PARAMETER, STRING_PARAMETER]}})}
# All paths are absolute, as in the job bundles of AWS Deadline Cloud.
PATHS = {"type": "array", "items": {"type": "string", "pattern": "^/"}}
VALUES = closed({"parameterValues": {"type": "array", "items": closed(
    {"name": IDENTIFIER, "value": {"type": "string", "maxLength": 1024}})}})
ASSETS = closed({"assetReferences": closed(
    {"inputs": closed({"filenames": PATHS, "directories": PATHS}), "outputs": closed({"directories": PATHS}),
     "referencedPaths": PATHS})})
