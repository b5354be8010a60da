# SPDX-License-Identifier: Apache-2.0
"""Runs a job bundle as the specification of Open Job Description says ("How Jobs Are Run"). Supports parameters, steps
that run after their dependencies, tasks and chunks of tasks, cancelation, and the messages that tasks print."""
import dataclasses
import pathlib
import re
import signal
import subprocess
import time

import yaml


@dataclasses.dataclass
class Task:
    """Describes a task or a chunk of tasks that was run."""
    values: dict
    code: int
    text: str
    progress: list
    statuses: list
    failures: list


def loaded(path):
    return yaml.safe_load(pathlib.Path(path).read_text())


def resolved(text, values):
    """Replaces format strings: {{ NAME }}."""
    return re.sub(r"\{\{\s*([\w.]+)\s*\}\}", lambda found: values[found.group(1)], text)


def numbers(expression):
    first, _, rest = expression.partition("-")
    last, _, step = rest.partition(":")
    return list(range(int(first), int(last or first) + 1, int(step or 1)))


def chunks(values, count):
    """Returns contiguous ranges of `count` values, such as "2-4" or "5"."""
    groups = [values[i:i + count] for i in range(0, len(values), count)]
    return [f"{group[0]}-{group[-1]}" if len(group) > 1 else f"{group[0]}" for group in groups]


class Bundle:
    def __init__(self, folder):
        folder = pathlib.Path(folder)
        self.template = loaded(folder / "template.yaml")
        self.values = {f"Param.{one['name']}": one["default"]
                       for one in self.template.get("parameterDefinitions", []) if "default" in one}
        self.values |= {f"Param.{one['name']}": one["value"]
                        for one in loaded(folder / "parameter_values.yaml")["parameterValues"]}
        self.assets = loaded(folder / "asset_references.yaml")["assetReferences"]

    def set(self, name, value):
        self.values[f"Param.{name}"] = value

    def steps(self):
        """Returns the steps in an order in which each comes after its dependencies."""
        left, done = list(self.template["steps"]), set()
        while left:
            ready = [step for step in left if {one["dependsOn"] for one in step.get("dependencies", [])} <= done]
            assert ready, "steps depend on one another"
            for step in ready:
                yield step
                done.add(step["name"])
                left.remove(step)

    def task_values(self, step, chunk_size):
        space = step.get("parameterSpace")
        if space is None:
            return [{}]
        [one] = space["taskParameterDefinitions"]
        return [{f"Task.Param.{one['name']}": text} for text in chunks(numbers(one["range"]), chunk_size)]

    def command(self, step, values):
        run = step["script"]["actions"]["onRun"]
        everything = {**self.values, **values}
        return [resolved(word, everything) for word in [run["command"], *run.get("args", [])]]

    def run(self, chunk_size=1, again=(), order=lambda tasks: tasks):
        """Runs every task once, and runs the tasks in `again` twice. After a failed task, later steps do not run."""
        tasks = []
        for step in self.steps():
            for values in order(self.task_values(step, chunk_size)):
                tasks += [self.run_task(step, values) for _ in range(2 if values in again else 1)]
            if any(task.code for task in tasks):
                break
        return tasks

    def run_task(self, step, values, cancel_at=None):
        """`cancel_at` is the percentage at which the task is canceled."""
        task = Task(values, 0, "", [], [], [])
        with subprocess.Popen(self.command(step, values), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True) as child:
            for line in child.stdout:
                task.text += line
                if found := re.match(r"openjd_progress:\s*(\S+)", line):
                    task.progress.append(float(found.group(1)))
                    if cancel_at is not None and task.progress[-1] >= cancel_at:
                        self.cancel(step, child)
                elif found := re.match(r"openjd_status:\s*(.*)", line):
                    task.statuses.append(found.group(1))
                elif found := re.match(r"openjd_fail:\s*(.*)", line):
                    task.failures.append(found.group(1))
            task.code = child.wait()
        return task

    @staticmethod
    def cancel(step, child):
        """Sends a notice, and ends the task after the period."""
        period = step["script"]["actions"]["onRun"]["cancelation"]["notifyPeriodInSeconds"]
        child.send_signal(signal.SIGTERM)
        end = time.monotonic() + period
        while child.poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        if child.poll() is None:
            child.kill()
