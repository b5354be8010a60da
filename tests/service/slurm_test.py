#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the service with a real Slurm with two nodes (slurm_harness.py). Jobs run in chunks and maps in shares, and
each result must be published exactly once, whatever fails. If Slurm cannot be started, the test is skipped and prints
the reason. MULTUM names the program.

  MULTUM=build/release/bin/multum-drill slurm_test.py [-v] [SlurmTest.test_...]
"""
import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from service_harness import MULTUM, ClientCase  # noqa: E402
from slurm_harness import Slurm, why_not  # noqa: E402

NOT_HERE = why_not()
CONFIG = """
workers = 1
back_off_first_s = 0.05
back_off_max_s = 0.2
[[queue]]
name = "default"
[[queue]]
name = "farm"
priority = 10
[slurm]
folder = "{folder}"
queues = ["farm"]
cpus = 1
poll_s = {poll}
visible_s = 0.5
{more}
"""
# This is a wrapper for Slurm's sbatch. If a test asks for it, the wrapper kills the controller as soon as the
# controller has accepted a job. On request, the wrapper also answers with the number of another user's job.
SBATCH = """#!/bin/sh
if [ -e {flag}.other ]; then
  rm {flag}.other; set -- --parsable --job-name=other --output=/dev/null --wrap 'sleep 60'
fi
answer=$({sbatch} "$@"); code=$?
if [ -e {flag} ]; then rm {flag}; kill -9 $(cat {flag}.pid); fi
printf '%s\\n' "$answer"
exit $code
"""
# This is a wrapper for scancel, which records the cancelled jobs.
SCANCEL = """#!/bin/sh
echo "$@" >>{flag}.cancelled
exec {scancel} "$@"
"""
# Replaces multum on nodes. Share 1 exits before it does any work, as often as the test requests.
PROGRAM = """#!/bin/sh
if [ "$SLURM_ARRAY_TASK_ID" = 1 ] && [ -e {folder}/fail-1 ]; then mv {folder}/fail-1 {folder}/failed-1; exit 7; fi
if [ "$SLURM_ARRAY_TASK_ID" = 1 ] && [ -e {folder}/fail-always ]; then exit 7; fi
exec {multum} "$@"
"""
# Replaces multum on nodes. Share 1 waits until the test lets it continue.
SLOW_PROGRAM = """#!/bin/sh
[ "$SLURM_ARRAY_TASK_ID" != 1 ] || [ -e {folder}/go ] || sleep 60
exec {multum} "$@"
"""


def write_program(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    os.chmod(path, 0o755)
    return path


@unittest.skipIf(NOT_HERE, NOT_HERE)
class SlurmTest(ClientCase):
    checks_answers = True

    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.holder)
        cls.slurm = Slurm(os.path.join(cls.holder, "slurm"))
        cls.addClassCleanup(cls.slurm.stop)
        cls.slurm.start()
        cls.map = os.path.join(cls.holder, "map")
        subprocess.run([MULTUM, "testmap", cls.map, "--size", "256"], check=True, capture_output=True)
        cls.flag = os.path.join(cls.holder, "kill-controller")
        folder = os.path.join(cls.holder, "bin")
        os.mkdir(folder)
        write_program(os.path.join(folder, "sbatch"),
                      SBATCH.format(sbatch=shutil.which("sbatch", path=cls.slurm.environment["PATH"]), flag=cls.flag))
        scancel = shutil.which("scancel", path=cls.slurm.environment["PATH"])
        write_program(os.path.join(folder, "scancel"), SCANCEL.format(scancel=scancel, flag=cls.flag))
        cls.path = folder + ":" + cls.slurm.environment["PATH"]

    def setUp(self):
        super().setUp()
        for name in ("", ".other", ".cancelled"):
            with contextlib.suppress(FileNotFoundError):
                os.remove(self.flag + name)
        self.shared = os.path.join(self.folder, "shared")
        os.mkdir(self.shared, mode=0o700)

    def tearDown(self):
        self.slurm.run("scancel", "--user=root")
        super().tearDown()

    def start_slurm(self, more="", poll=0.1, **settings):
        environment = dict(self.slurm.environment, PATH=self.path)
        config = CONFIG.format(folder=self.shared, more=more, poll=poll)
        service = self.start(config=config, environment=environment, **settings)
        with open(os.path.join(service.data, "instance"), encoding="utf-8") as file:
            self.instance = file.read().strip()
        return service

    def farm(self, name, seconds=0, **job):
        """Submits a small job that writes its name."""
        return self.drill(seconds, queue="farm", text=name, output=self.output(name), **job)

    def parts(self, number):
        return self.service.job(number)["parts"]

    def first_part(self, number):
        """Returns "" as long as nothing is sent."""
        return next(iter(self.parts(number)), {"node": "", "progress": None})

    def kill_controller_when_it_accepts(self):
        with open(self.flag + ".pid", "w", encoding="utf-8") as file:
            file.write(str(self.slurm.processes["slurmctld"].pid))
        open(self.flag, "w", encoding="utf-8").close()

    def cancelled(self):
        """Returns the arguments of each scancel call, one line each."""
        with contextlib.suppress(FileNotFoundError), open(self.flag + ".cancelled", encoding="utf-8") as file:
            return file.read().splitlines()
        return []

    def submitted_count(self):
        return self.service.metric("multum_slurm_submitted_total")

    def succeed(self, number, name, attempts=1, timeout=30):
        job = self.service.wait_for(number, timeout=timeout)
        self.assertEqual(job["state"], "succeeded", (job, self.service.log_text()[-2000:]))
        with open(self.output(name), encoding="utf-8") as file:
            self.assertEqual(file.read(), name + "\n")
        self.assertEqual(len(job["attempts"]), attempts, job)
        return job

    def nothing_is_left(self):
        """Checks that no job is left in Slurm, and no file in the shared folder or next to results."""
        place = os.path.join(self.shared, "multum-" + self.instance)
        self.slurm.wait_until("Slurm is empty", lambda: not self.slurm.jobs())
        self.slurm.wait_until("the shared folder is empty", lambda: os.listdir(place) == ["task.sh"])
        self.assertEqual([name for name in os.listdir(self.service.root) if name.startswith(".")], [])

    def daemon_rests(self):
        """Returns the daemon's own processor time, without the commands that it runs."""
        def seconds():
            with open(f"/proc/{self.service.process.pid}/stat", encoding="utf-8") as file:
                fields = file.read().rsplit(")", 1)[1].split()
            return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")

        before = seconds()
        time.sleep(1)
        self.assertLess(seconds() - before, 0.3)

    # ---- Normal operation

    def test_small_jobs_share_tasks(self):
        service = self.start_slurm("chunk_s = 2")
        service.ask("POST", "/v1/queues/farm/pause")
        numbers = {f"job{i}": self.farm(f"job{i}", 0.1, priority=i % 3) for i in range(24)}
        service.ask("POST", "/v1/queues/farm/resume")
        for name, number in numbers.items():
            job = self.succeed(number, name)
            self.assertEqual([(part["part"], part["state"]) for part in job["parts"]], [("", "succeeded")])
            self.assertIn(job["parts"][0]["node"], self.slurm.nodes)
            self.assertIn("drill: done", service.ask("GET", f"/v1/jobs/{number}/log")[1].decode())
        self.assertLessEqual(self.submitted_count(), 3)
        self.assertEqual(service.metric("multum_slurm_up"), 1)
        here = self.drill(text="here", output=self.output("here"))  # a job of the other queue
        self.assertEqual(self.succeed(here, "here")["parts"], [])
        self.nothing_is_left()
        self.daemon_rests()

    def test_types_of_a_queue(self):
        self.start_slurm('types = ["bake"]')
        self.assertEqual(self.succeed(self.farm("here"), "here")["parts"], [])
        bake = self.service.submit(type="bake", parameters={"input": self.copy_of_map(), "lobes": 1}, queue="farm",
                                   output=self.output("one.ndf.exr"))
        self.assertEqual(len(self.service.wait_for(bake)["parts"]), 1)

    def copy_of_map(self):
        path = os.path.join(self.service.root, "map.png")
        shutil.copy(self.map + "_normal.png", path)
        return path

    def bake(self, **job):
        return self.service.submit(type="bake", parameters={"input": self.copy_of_map(), "no_measure": True},
                                   queue="farm", output=self.output("map.ndf.exr"), **job)

    def whole(self):
        """Returns the bake of the map by one process."""
        path = os.path.join(self.holder, "whole.ndf.exr")
        if not os.path.exists(path):
            subprocess.run([MULTUM, "bake", self.copy_of_map(), "-o", path, "--no-measure"], check=True,
                           capture_output=True)
        with open(path, "rb") as file:
            return file.read()

    def shared_bake(self, service, number):
        job = service.wait_for(number)
        self.assertEqual(job["state"], "succeeded", (job, service.log_text()[-2000:]))
        with open(self.output("map.ndf.exr"), "rb") as file:
            self.assertEqual(file.read(), self.whole())
        return [(part["round"], part["part"], part["state"]) for part in job["parts"]]

    def test_a_large_map_in_shares(self):
        service = self.start_slurm("share_s = 0.7")
        number = self.bake()
        parts = self.shared_bake(service, number)
        count = len(parts) - 2
        self.assertGreaterEqual(count, 2)
        self.assertEqual(parts, [(1, f"{i}/{count}", "succeeded") for i in range(count + 1)] +
                         [(1, f"merge {count}", "succeeded")])
        log = service.ask("GET", f"/v1/jobs/{number}/log")[1].decode()
        for prefix in (f"share 0/{count}: ", f"share {count}/{count}: ", "merge: "):
            self.assertIn("\n" + prefix, "\n" + log)
        self.nothing_is_left()

    def test_a_share_that_is_missing_is_asked_for_again(self):
        program = write_program(os.path.join(self.folder, "node-program"),
                                PROGRAM.format(folder=self.folder, multum=os.path.abspath(MULTUM)))
        service = self.start_slurm(f'share_s = 0.7\nrounds = 2\nprogram = "{program}"')
        open(os.path.join(self.folder, "fail-1"), "w", encoding="utf-8").close()
        parts = self.shared_bake(service, self.bake())
        count = int(parts[0][1].split("/")[1])
        self.assertIn((1, f"1/{count}", "lost"), parts)
        self.assertEqual([part for part in parts if part[0] == 2],
                         [(2, f"1/{count}", "succeeded"), (2, f"merge {count}", "succeeded")])
        self.assertEqual(service.metric("multum_slurm_rounds_total"), 1)
        # The share always fails. After a number of attempts, the job fails and lists the failures.
        open(os.path.join(self.folder, "fail-always"), "w", encoding="utf-8").close()
        job = service.wait_for(self.bake(again=True, attempt_max=1))
        self.assertEqual(job["state"], "dead")
        self.assertIn(f"after 2 rounds, shares 1/{count} are missing", job["message"])
        self.nothing_is_left()

    def test_a_share_that_is_cancelled_is_asked_for_again(self):
        program = write_program(os.path.join(self.folder, "node-program"),
                                SLOW_PROGRAM.format(folder=self.folder, multum=os.path.abspath(MULTUM)))
        service = self.start_slurm(f'share_s = 0.7\nprogram = "{program}"')
        number = self.bake()
        self.slurm.wait_until("share 1 runs", lambda: any(
            part["part"].startswith("1/") and part["slurm_state"] == "RUNNING" for part in self.parts(number)))
        share = next(part["part"] for part in self.parts(number) if part["part"].startswith("1/"))
        open(os.path.join(self.folder, "go"), "w", encoding="utf-8").close()
        self.assertEqual(service.ask("POST", f"/v1/jobs/{number}/cancel", {"part": share})[0], 202)
        parts = self.shared_bake(service, number)
        self.assertIn((1, share, "lost"), parts)
        self.assertIn((2, share, "succeeded"), parts)
        self.refused(409, "too_late", [share], "POST", f"/v1/jobs/{number}/cancel", {"part": share})

    def test_a_map_that_cannot_be_baked_is_refused_at_once(self):
        service = self.start_slurm("share_s = 0.7")
        path = self.copy_of_map()
        with open(path, "r+b") as file:
            file.truncate(2000)
        job = service.wait_for(service.submit(type="bake", parameters={"input": path}, queue="farm",
                                              output=self.output("map.ndf.exr")))
        self.assertEqual((job["state"], len(job["attempts"]), job["exit_code"]), ("dead", 1, 3), job)
        self.nothing_is_left()

    # ---- Cancelling

    def test_cancelled_jobs_end(self):
        service = self.start_slurm()
        # Two nodes are busy with two chunks. The test cancels a job of the second chunk that has not begun, and the
        # running job of the first chunk. A third job waits in Slurm.
        service.ask("POST", "/v1/queues/farm/pause")
        first = [self.farm(f"first{i}", 15) for i in range(2)]
        second = [self.farm(f"second{i}", 1) for i in range(20)]
        third = self.farm("third", 40)
        service.ask("POST", "/v1/queues/farm/resume")
        service.wait_for(first[0], ("running",))
        self.slurm.wait_until("the first runs", lambda: self.first_part(first[0])["node"])
        self.slurm.wait_until("the third waits", lambda: any(" PENDING" in line for line in self.slurm.jobs()))
        for number in (first[0], second[15], third):
            self.assertEqual(service.ask("POST", f"/v1/jobs/{number}/cancel")[0], 202)
            self.assertEqual(service.wait_for(number, timeout=15)["state"], "cancelled")
        self.assertEqual(service.job(first[1])["state"], "running")
        for number in first + second:
            service.ask("POST", f"/v1/jobs/{number}/cancel")
        for number in first + second:
            self.assertIn(service.wait_for(number)["state"], ("cancelled", "succeeded"))
        self.nothing_is_left()

    def test_who_has_a_forgotten_number_is_not_cancelled(self):
        # Simulates a controller that has forgotten the daemon's job and gives its number to the next job.
        service = self.start_slurm(poll=4)  # so that the daemon cancels the job before it learns that the job has ended
        with open(self.flag + ".other", "w", encoding="utf-8"):
            pass
        number = self.farm("forgotten", 30)
        self.slurm.wait_until("another has its number", lambda: [line.split()[1] for line in self.slurm.jobs()] ==
                              ["other"])
        [other] = [line.split()[0] for line in self.slurm.jobs()]
        self.slurm.wait_until("it is sent", lambda: self.submitted_count() == 1)
        self.assertEqual(service.ask("POST", f"/v1/jobs/{number}/cancel")[0], 202)
        self.slurm.wait_until("it is cancelled", self.cancelled)
        [asked] = self.cancelled()
        self.assertIn(f"--name=multum-{self.instance}-", asked)
        self.assertEqual(asked.split()[-1], other)
        time.sleep(0.5)
        self.assertEqual([line.split()[1] for line in self.slurm.jobs("PENDING,RUNNING")], ["other"])
        self.slurm.run("scancel", other)
        self.slurm.wait_for_nodes()

    # ---- Processes that end unexpectedly

    def test_a_controller_that_dies_when_it_has_accepted(self):
        service = self.start_slurm()
        self.kill_controller_when_it_accepts()
        number = self.farm("forgotten", 0.2)
        self.slurm.wait_until("it is dead", lambda: not os.path.exists(self.flag))
        self.slurm.processes["slurmctld"].wait()
        service.wait_for_log("Slurm does not answer")
        other = self.farm("while-away", 0.1)
        time.sleep(0.5)
        self.assertEqual(service.job(number)["state"], "running")  # the daemon cannot know how the job ended
        self.slurm.start_controller()
        self.succeed(number, "forgotten")
        self.succeed(other, "while-away")
        self.assertEqual(service.metric("multum_slurm_parts_lost_total"), 0)
        self.nothing_is_left()
        self.slurm.wait_for_nodes()

    def test_a_daemon_that_dies(self):
        service = self.start_slurm("chunk_s = 0")
        numbers = {f"job{i}": self.farm(f"job{i}", 2) for i in range(4)}
        self.slurm.wait_until("all jobs must be sent, and two must run", lambda: self.submitted_count() == 4 and sum(
            " RUNNING" in line for line in self.slurm.jobs()) == 2)
        service.kill()
        self.slurm.wait_until("they have ended", lambda: len(self.slurm.jobs()) <= 2)
        service.start()
        for name, number in numbers.items():
            self.succeed(number, name)
        self.assertEqual(self.submitted_count(), 0)
        # A daemon that is asked to end leaves its jobs running in Slurm.
        number = self.farm("last", 2)
        self.slurm.wait_until("it runs", lambda: any(" RUNNING" in line for line in self.slurm.jobs()))
        begun = time.monotonic()
        self.assertEqual(service.stop(), 0)
        self.assertLess(time.monotonic() - begun, 2)
        service.start()
        self.succeed(number, "last")
        self.nothing_is_left()

    def test_what_only_one_side_knows(self):
        service = self.start_slurm()
        number = self.farm("mine", 3)
        self.slurm.wait_until("it runs", lambda: any(" RUNNING" in line for line in self.slurm.jobs()))
        service.kill()
        self.slurm.run("scancel", "--user=root")
        name = f"multum-{self.instance}-12345"
        script = os.path.join(self.shared, f"multum-{self.instance}", "task.sh")
        alien, other = (self.slurm.run("sbatch", "--parsable", f"--job-name={one}", "--output=/dev/null", script,
                                       "sleep", "60") for one in (name, "other"))
        service.start()
        self.succeed(number, "mine", attempts=2)
        self.slurm.wait_until("the alien is cancelled",
                              lambda: [line.split()[0] for line in self.slurm.jobs()] == [other.strip()])
        self.assertIn(f"Slurm has job {alien.strip()}, which is not in the ledger", service.log_text())
        self.assertEqual(service.metric("multum_slurm_unknown_cancelled_total"), 1)
        self.slurm.run("scancel", other.strip())
        self.nothing_is_left()

    def test_a_node_that_crashes(self):
        service = self.start_slurm("lease_s = 2\nchunk_s = 0")
        number = self.farm("moved", 3)
        self.slurm.wait_until("it runs", lambda: (self.first_part(number)["progress"] or {}).get("stage") == "drill")
        node = self.first_part(number)["node"]
        self.slurm.crash_node(node)
        job = self.succeed(number, "moved", attempts=2)
        self.assertIn("task sent nothing", job["attempts"][0]["message"])
        self.assertNotEqual(job["parts"][-1]["node"], node)
        self.slurm.return_node(node)
        self.slurm.wait_for_nodes()
        self.nothing_is_left()
        self.assertEqual(service.job(number)["state"], "succeeded")

    def test_a_node_that_is_drained(self):
        self.start_slurm("chunk_s = 0")
        first = self.farm("before", 2)
        self.slurm.wait_until("it runs", lambda: self.first_part(first)["node"])
        node = self.first_part(first)["node"]
        self.slurm.run("scontrol", "update", f"NodeName={node}", "State=DRAIN", "Reason=test")
        with contextlib.ExitStack() as stack:
            stack.callback(self.slurm.run, "scontrol", "update", f"NodeName={node}", "State=RESUME")
            others = {f"job{i}": self.farm(f"job{i}", 0.1) for i in range(4)}
            for name, number in others.items():
                self.assertNotEqual(self.succeed(number, name)["parts"][0]["node"], node)
            self.succeed(first, "before")
        self.slurm.wait_for_nodes()
        self.nothing_is_left()

    def test_a_worker_that_crashes_on_its_node(self):
        service = self.start_slurm()
        crash = self.drill(queue="farm", then="crash", attempt_max=2)
        fine = self.farm("fine")
        job = service.wait_for(crash)
        self.assertEqual((job["state"], [one["outcome"] for one in job["attempts"]]), ("dead", ["lost", "lost"]))
        self.assertIn("signal 9", job["message"])
        self.succeed(fine, "fine")
        self.nothing_is_left()

    # ---- Refusals

    def test_what_slurm_refuses(self):
        service = self.start_slurm('partition = "nowhere"')
        job = service.wait_for(self.farm("never", attempt_max=1))
        self.assertEqual(job["state"], "dead")
        self.assertIn("sbatch: ", job["message"])
        self.assertIn("nvalid partition", job["message"])
        self.nothing_is_left()

    def test_files_that_nodes_do_not_see(self):
        service = self.start_slurm()
        self.refused(400, "usage", ["output", "Slurm"], "POST", "/v1/jobs",
                     {"type": "drill", "queue": "farm", "output": "here.txt"})
        with open(self.map + "_normal.png", "rb") as file:
            connection = service.connection()
            connection.request("PUT", "/v1/uploads/map.png", file.read())
            path = json.loads(connection.getresponse().read())["path"]
            connection.close()
        self.refused(400, "usage", ["parameters.input", "Slurm"], "POST", "/v1/jobs",
                     {"type": "bake", "queue": "farm", "parameters": {"input": path},
                      "output": self.output("a.ndf.exr")})


class SlurmSettingsTest(ClientCase):
    """Contains tests that do not need Slurm."""

    def refused_settings(self, expected, more="", folder=None):
        shared = folder or os.path.join(self.folder, "shared")
        config = os.path.join(self.folder, "serve.toml")
        with open(config, "w", encoding="utf-8") as file:
            file.write(CONFIG.format(folder=shared, more=more, poll=0.1))
        os.makedirs(os.path.join(self.folder, "root"), exist_ok=True)
        done = subprocess.run([MULTUM, "serve", "--data", os.path.join(self.folder, "data"), "--root",
                               os.path.join(self.folder, "root"), "--listen", "127.0.0.1:0", "--config", config],
                              capture_output=True, text=True, check=False, timeout=30)
        self.assertIn(done.returncode, (2, 3), done.stderr)
        self.assertIn(expected, done.stderr)

    def test_refusals(self):
        self.refused_settings("expected a folder with the same path on all nodes")
        shared = os.path.join(self.folder, "shared")
        os.mkdir(shared)
        os.chmod(shared, 0o777)
        self.refused_settings("other users own it or can write to it")
        os.chmod(shared, 0o700)
        self.refused_settings("where jobs could write to it", folder=os.path.join(self.folder, "root", "shared"))
        self.refused_settings("unknown key 'slurm.partitions'", 'partitions = "a"')
        self.refused_settings("slurm.jobs", "jobs = 0")
        self.refused_settings("is less than time_min_s", "time_max_s = 100")
        self.refused_settings('type is "cook"', 'types = ["cook"]')


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    unittest.main()
