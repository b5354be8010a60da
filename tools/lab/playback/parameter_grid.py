# SPDX-License-Identifier: Apache-2.0
"""Changes the parameters of a job of `multum infer`: splits one parameter into several parameters, or keeps only the
first parameters, with the middle samples of the others. Jobs are TOML texts as `multum animation` writes them, and the
rest of the text does not change."""
import json
import math
import re
import sys


def tables(job):
    """Splits a job into the text before the first [[...]], and each [[...]] with its lines."""
    return re.split(r"^(?=\[\[)", job, flags=re.MULTILINE)


def is_a(table, kind):
    return table.startswith(f"[[{kind}]]")


def name_of(table):
    return re.search(r'^name = "(.*)"', table, re.MULTILINE).group(1)


def count_of(table):
    return int(re.search(r"^count = (\d+)", table, re.MULTILINE).group(1))


def with_value(table, key, value):
    """Sets a key. `value` is written as JSON, which TOML can read."""
    changed, count = re.subn(rf"^{key} = (\[.*?\]|\"[^\"]*\"|\S+)", lambda _: f"{key} = {json.dumps(value)}", table,
                             count=1, flags=re.MULTILINE)
    if count != 1:
        sys.exit(f"the job has no {key} in {table.splitlines()[0]}")
    return changed


def list_of(table, key):
    return json.loads(re.search(rf"^{key} = (\[.*?\])", table, re.MULTILINE).group(1))


def with_split_parameter(job, name, parts):
    """Replaces the parameter `name` with `parts`, (name, count). The last part changes fastest."""
    parameters = [table for table in tables(job) if is_a(table, "parameter")]
    place = next((k for k, table in enumerate(parameters) if name_of(table) == name), None)
    if place is None:
        sys.exit(f"the job has no parameter {name}")
    counts = [count for _, count in parts]
    if math.prod(counts) != count_of(parameters[place]):
        sys.exit(f"{name} has {count_of(parameters[place])} samples, expected the product of {counts}")
    result = []
    for table in tables(job):
        if is_a(table, "parameter") and name_of(table) == name:
            result += [with_value(with_value(table, "name", part), "count", count) for part, count in parts]
            continue
        if is_a(table, "layer"):
            names = [one for old in list_of(table, "depends_on")
                     for one in ([part for part, _ in parts] if old == name else [old])]
            table = with_value(table, "depends_on", names)
        elif is_a(table, "sample"):
            at = list_of(table, "at")
            rest, digits = at[place], []
            for count in reversed(counts):
                digits.insert(0, rest % count)
                rest //= count
            table = with_value(table, "at", at[:place] + digits + at[place + 1:])
        result.append(table)
    return "".join(result)


def with_leading_parameters(job, kept):
    """Keeps only the first `kept` parameters, at the middle samples of the others."""
    parameters = [table for table in tables(job) if is_a(table, "parameter")]
    names = [name_of(table) for table in parameters]
    middle = [count_of(table) // 2 for table in parameters]
    result = []
    for table in tables(job):
        if is_a(table, "parameter") and name_of(table) in names[kept:]:
            continue
        if is_a(table, "layer"):
            left = [one for one in list_of(table, "depends_on") if one in names[:kept]]
            table = with_value(table, "depends_on", left)
        if is_a(table, "sample"):
            at = list_of(table, "at")
            if at[kept:] != middle[kept:]:
                continue
            table = with_value(table, "at", at[:kept])
        result.append(table)
    return "".join(result)
