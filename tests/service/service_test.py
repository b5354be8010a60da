#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the service as clients see it: the stages of jobs, queues, events, refusals, and shutdown. MULTUM names the
program.

  MULTUM=build/release/bin/multum-drill service_test.py [-v] [ServiceTest.test_...]
"""
import contextlib
import json
import os
import pty
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from service_harness import MULTUM, QUICK, ClientCase, Service, resident_bytes  # noqa: E402


class ServiceTest(ClientCase):
    checks_answers = True

    def on_terminal(self, *arguments):
        """Returns the bytes that a client's terminal receives."""
        try:
            terminal, inner = pty.openpty()
        except OSError:
            self.skipTest("there are no pseudo terminals")
        client = subprocess.Popen([MULTUM, "jobs", *arguments], stdin=inner, stdout=inner, stderr=inner,
                                  env=dict(os.environ, MULTUM_SERVER=f"http://127.0.0.1:{self.service.port}"))
        os.close(inner)
        shown = b""
        with contextlib.suppress(OSError):  # Linux reports EIO when the client has ended
            while part := os.read(terminal, 65536):
                shown += part
        os.close(terminal)
        client.wait(60)
        return shown

    def refused_path(self, path, job, is_outside=True):
        """Checks that the message names the file. For a file outside the allowed folders, the message must also name
        these folders."""
        message = self.refused(400, "usage", [], "POST", "/v1/jobs", job)
        self.assertTrue(message.startswith(f"{path}: "), message)
        self.assertEqual(self.results() in message, is_outside, message)

    # ---- The stages of a job

    def test_a_list_has_a_line_for_each_job(self):
        service = self.start()
        lines = "b\u00e4d line\n" * 3 + "x" * 500
        ids = [self.drill(), self.drill(then="refuse")]
        for number in ids:
            service.wait_for(number)
        service.stop()
        with contextlib.closing(sqlite3.connect(os.path.join(service.data, "jobs.sqlite"))) as ledger:
            ledger.execute("UPDATE jobs SET message = ? WHERE id = ?", (lines, ids[1]))
            ledger.commit()
        service.start()
        listed = self.client("list").splitlines()
        self.assertEqual(len(listed), 2, listed)
        self.assertIn("(b\u00e4d line ...)", listed[0])
        self.assertLess(max(map(len, listed)), 250)
        shown = json.loads(self.client("show", str(ids[1]), "--json"))["jobs"][0]
        self.assertEqual(shown["message"], lines, "all of it")

    def test_systemd_is_told(self):
        path = os.path.join(self.folder, "notify")
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notify:
            notify.bind(path)
            notify.settimeout(30)
            service = self.start(environment={"NOTIFY_SOCKET": path, "WATCHDOG_USEC": "600000"})

            def told(word):
                deadline = time.monotonic() + 30
                while time.monotonic() < deadline:
                    if notify.recv(4096).decode() == word:
                        return
                self.fail(f"systemd was not told {word}")

            told("READY=1")
            told("WATCHDOG=1")
            told("WATCHDOG=1")
            service.process.send_signal(signal.SIGHUP)
            told("RELOADING=1")
            told("READY=1")
            service.process.send_signal(signal.SIGTERM)
            told("STOPPING=1")
            self.assertEqual(service.process.wait(30), 0)

    def test_failures_are_tried_again_and_then_dead(self):
        service = self.start()
        crash = self.drill(then="crash", attempt_max=3)
        refuse = self.drill(then="refuse", attempt_max=3)
        job = service.wait_for(crash)
        self.assertEqual(job["state"], "dead")
        self.assertEqual([one["outcome"] for one in job["attempts"]], ["lost"] * 3)
        self.assertIn("signal 9", job["message"])
        job = service.wait_for(refuse)
        self.assertEqual([one["outcome"] for one in job["attempts"]], ["refused"])
        self.assertEqual(job["exit_code"], 3)
        self.client("wait", str(crash), str(refuse), code=1)
        self.assertRegex(self.client("retry", "--all-dead"), r"\A2 ")
        self.assertEqual(service.wait_for(refuse)["attempt"], 2)

    def test_a_decoder_that_dies_fails_its_job_alone(self):
        folder = os.path.join(self.folder, "bin")
        os.makedirs(folder)
        built = os.path.dirname(os.path.abspath(MULTUM))
        shutil.copy(MULTUM, os.path.join(folder, "multum"))
        shutil.copy(os.path.join(built, "failing_helper"), os.path.join(folder, "multum-decode"))
        service = self.service = Service(os.path.join(folder, "multum"), self.folder, config=QUICK).start()
        subprocess.run([MULTUM, "testmap", "--size", "16", self.output("q")], check=True, capture_output=True)
        for name, code, words in (("segfault", 3, "terminated by signal 11"), ("exit", 3, "ended with exit code 7"),
                                  ("missing", 4, "multum-decode: cannot be started")):
            if name == "missing":
                os.remove(os.path.join(folder, "multum-decode"))
            shutil.copy(self.output("q_normal.png"), self.output(name + ".png"))
            job = service.wait_for(service.submit(type="bake", parameters={"input": self.output(name + ".png")},
                                                  output=self.output(name + ".ndf.exr"), attempt_max=1))
            self.assertEqual((job["state"], job["exit_code"]), ("dead", code), job)
            self.assertIn(words, job["message"])
        self.assertEqual([name for name in os.listdir(service.root) if name.endswith(".exr")], [])
        self.assertEqual(service.wait_for(self.drill())["state"], "succeeded")

    def test_who_hangs_or_stalls_is_killed(self):
        service = self.start(QUICK + "lease_s = 2\nno_progress_s = 3\n")
        hang = self.drill(then="hang", attempt_max=1)
        stall = self.drill(then="stall", attempt_max=1)
        self.assertIn("2000 ms", service.wait_for(hang)["message"])
        self.assertIn("3000 ms", service.wait_for(stall)["message"])
        self.assertEqual(service.wait_for(self.drill())["state"], "succeeded")

    def test_control_characters_do_not_reach_a_terminal(self):
        service = self.start()
        source = self.output("q\u009b31m\u007f.png")
        with open(source, "wb") as file:
            file.write(b"no picture")
        job = service.wait_for(service.submit(type="bake", parameters={"input": source},
                                              output=self.output("a.ndf.exr")))
        self.assertEqual(job["state"], "dead")
        self.assertIn(source, job["message"])
        for command in ("show", "tail", "list"):
            arguments = [command] if command == "list" else [command, "1"]
            with self.subTest(command=command):
                shown = self.on_terminal(*arguments)
                self.assertFalse(any(byte in shown for byte in (b"\x9b", b"\x7f")), shown)
                self.assertIn(b"31m", shown)
        # A pipe receives the log unchanged.
        self.assertIn(source, self.client("tail", "1", code=1))
        self.assertEqual(json.loads(self.client("show", "1", "--json"))["jobs"][0]["message"], job["message"])

    def test_cancelled_in_any_state(self):
        service = self.start(QUICK + "workers = 1\ncancel_grace_s = 1\n")
        running = self.drill(30, output=self.output("a.txt"))
        queued = self.drill()
        waiting = self.drill(needs=[queued])
        service.wait_for(running, ["running"])
        self.client("cancel", str(queued), str(running))
        self.assertEqual(service.wait_for(running)["state"], "cancelled")
        self.assertEqual(service.job(queued)["state"], "cancelled")
        self.assertIn(f"needs job {queued}", service.job(waiting)["message"])
        self.refused(409, "too_late", ["cancelled"], "POST", f"/v1/jobs/{queued}/cancel")
        stall = self.drill(then="stall")
        service.wait_for(stall, ["running"])
        self.client("cancel", str(stall))
        self.assertEqual(service.wait_for(stall)["state"], "cancelled")
        self.assertEqual(os.listdir(service.root), [], "no unfinished file may be left")

    def test_a_cancelled_job_that_is_retried_runs(self):
        service = self.start(QUICK + "workers = 1\n")
        job = self.drill(5)
        service.wait_for(job, ["running"])
        self.assertEqual(service.ask("POST", f"/v1/jobs/{job}/cancel")[0], 202)
        service.wait_for(job, ["cancelled"])
        self.client("retry", str(job))
        job = service.wait_for(job)
        self.assertEqual([one["outcome"] for one in job["attempts"]], ["cancelled", "succeeded"], job)

    def test_workers_hold_no_connection_of_the_daemon(self):
        service = self.start(QUICK + "workers = 1\n")
        service.wait_for(self.drill())
        with socket.create_connection(("127.0.0.1", service.port)) as client:
            client.sendall(b"GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
            client.recv(100)
            old = service.workers()
            os.kill(old[0], signal.SIGKILL)
            service.wait_for(self.drill())
            worker = next(pid for pid in service.workers() if pid not in old)
            files = os.listdir(f"/proc/{worker}/fd")
            sockets = [file for file in files if os.readlink(f"/proc/{worker}/fd/{file}").startswith("socket:")]
        self.assertEqual(sockets, ["3"], "only its own socket")

    def test_dependencies_deadlines_and_order(self):
        service = self.start(QUICK + "workers = 1\n")
        service.ask("POST", "/v1/queues/default/pause")
        low = self.drill(priority=-1)
        first = self.drill(0.2, priority=5)
        after = self.drill(0.05, needs=[first], priority=9)
        late = self.drill(deadline_s=1)
        time.sleep(1.2)
        service.ask("POST", "/v1/queues/default/resume")
        job = service.wait_for(late)
        self.assertIn("deadline", job["message"])
        self.assertEqual(job["attempts"], [])
        self.assertEqual(service.wait_until_idle()["succeeded"], 3)
        times = {number: service.job(number)["started"] for number in (low, first, after)}
        self.assertLess(times[first], times[after])
        self.assertLess(times[after], times[low])
        overdue = self.drill(30, deadline_s=1)
        job = service.wait_for(overdue)
        self.assertIn("deadline", job["message"])
        self.assertEqual(len(job["attempts"]), 1, "it had begun")

    def test_who_waits_misses_no_end_and_outlives_a_restart(self):
        service = self.start()
        # Jobs may end while the client sends its request. The client must not wait for events that have already
        # happened.
        for _ in range(20):
            self.assertIn("succeeded", self.client("submit", "drill", "--wait"))
        deadline = time.monotonic() + 5  # shorter than a heartbeat
        while service.metric("multum_http_event_streams") > 0:
            self.assertLess(time.monotonic(), deadline, "the daemon still keeps listeners that have left")
        number = self.drill(20)
        environment = dict(os.environ, MULTUM_SERVER=f"http://127.0.0.1:{service.port}")
        with subprocess.Popen([MULTUM, "jobs", "wait", str(number)], env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as waiting:
            deadline = time.monotonic() + 30
            while service.metric("multum_http_event_streams") != 1:
                self.assertLess(time.monotonic(), deadline, "nobody waits")
            service.kill()
            time.sleep(0.7)
            service.start(port=service.port)
            self.client("cancel", str(number))
            out, err = waiting.communicate(timeout=60)
        self.assertEqual(waiting.returncode, 1, err)
        self.assertIn("cancelled", out)
        self.assertIn("Trying again", err)

    def test_queues_limits_and_purge(self):
        service = self.start(QUICK + 'workers = 3\n[[queue]]\nname = "default"\njobs = 1\n[[queue]]\nname = "night"\n')
        jobs = [self.drill(0.3), self.drill(0.3), self.drill(0.3, queue="night")]
        service.wait_for(jobs[2], ["running"])
        self.assertEqual(service.counts()["running"], 1)
        service.wait_until_idle()
        service.wait_for(jobs[2])
        self.refused(400, "usage", ["queue", '"day"', "default, night"], "POST", "/v1/jobs",
                     {"type": "drill", "queue": "day"})
        self.assertRegex(self.client("purge", "--older-than", "0"), r"\A3 ")
        self.refused(404, "not_found", ["1"], "GET", "/v1/jobs/1")
        self.assertEqual(os.listdir(os.path.join(service.data, "logs")), [])

    # ---- Events

    def test_events_tell_every_change_and_go_on_after_a_break(self):
        service = self.start()
        one = socket.create_connection(("127.0.0.1", service.port))
        one.sendall(b"GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
        number = self.drill(0.3)
        service.wait_for(number)
        data, deadline = b"", time.monotonic() + 10
        while b'"succeeded"' not in data and time.monotonic() < deadline:
            data += one.recv(65536)
        text = data.decode()
        for state in ("queued", "running", "succeeded"):
            self.assertIn(f'"state":"{state}"', text)
        self.assertIn("event: progress", text)
        for event in text.split("\n\n"):
            fields = dict(line.split(": ", 1) for line in event.splitlines() if ": " in line and not line[0] == ":")
            if "data" in fields and len(fields) == 3:  # the last event may be cut off
                name = {"job": "Job", "progress": "ProgressEvent"}[fields["event"]]
                self.assertEqual(service.checker.errors({"$ref": f"#/components/schemas/{name}"},
                                                        json.loads(fields["data"])), [])
        first = int(text.split("id: ")[1].split("\n")[0])
        other = socket.create_connection(("127.0.0.1", service.port))
        other.sendall(f"GET /v1/events HTTP/1.1\r\nHost: localhost\r\nLast-Event-ID: {first}\r\n\r\n".encode())
        data, deadline = b"", time.monotonic() + 10
        while b'"succeeded"' not in data and time.monotonic() < deadline:
            data += other.recv(65536)
        self.assertIn(f"id: {first + 1}\n", data.decode())

    # ---- Stops and starts of the daemon

    def test_sigterm_lets_jobs_end_or_hands_them_back(self):
        service = self.start(QUICK + "workers = 2\nshutdown_grace_s = 1.5\n")
        short, long = self.drill(0.7, output=self.output("a.txt")), self.drill(60)
        service.wait_for(short, ["running"])
        service.wait_for(long, ["running"])
        begun = time.monotonic()
        self.assertEqual(service.stop(), 0)
        self.assertLess(time.monotonic() - begun, 20)
        service.start()
        self.assertEqual(service.job(short)["state"], "succeeded")
        job = service.job(long)
        self.assertEqual([one["outcome"] for one in job["attempts"]][0], "returned")
        self.assertIn(job["state"], ("queued", "running"))

    def test_settings_are_read_again_and_wrong_ones_kept_out(self):
        service = self.start(QUICK)
        path = os.path.join(self.folder, "serve.toml")
        with open(path, "a", encoding="utf-8") as file:
            file.write('[[queue]]\nname = "default"\n[[queue]]\nname = "night"\n')
        service.process.send_signal(signal.SIGHUP)
        service.wait_for_log("read again")
        service.wait_for(self.drill(queue="night"))
        with open(path, "a", encoding="utf-8") as file:
            file.write("[[queue]]\nnmae = 3\n")
        service.process.send_signal(signal.SIGHUP)
        service.wait_for_log("previous settings remain in use")
        self.assertIn("serve.toml:", service.log_text().splitlines()[-1])
        service.wait_for(self.drill(queue="night"))

    def test_reading_the_settings_again_leaves_paused_what_was_paused(self):
        queues = '[[queue]]\nname = "default"\n[[queue]]\nname = "night"\npaused = true\n'
        service = self.start(QUICK + queues)
        path = os.path.join(self.folder, "serve.toml")

        def paused():
            return [queue["name"] for queue in service.ask("GET", "/v1/queues")[1]["queues"] if queue["paused"]]

        def reload(text):
            with open(path, "w", encoding="utf-8") as file:
                file.write(QUICK + text)
            before = service.log_text().count("read again")
            service.process.send_signal(signal.SIGHUP)
            deadline = time.monotonic() + 10
            while service.log_text().count("read again") == before and time.monotonic() < deadline:
                time.sleep(0.02)

        self.assertEqual(paused(), ["night"])
        service.ask("POST", "/v1/queues/default/pause")
        service.ask("POST", "/v1/queues/night/resume")
        reload(queues)
        self.assertEqual(paused(), ["default"])
        reload(queues.replace("paused = true", "paused = false"))  # the settings contradict each other
        self.assertEqual(paused(), ["default"])
        reload(queues)
        self.assertEqual(paused(), ["default", "night"])

    # ---- Refusals

    def test_requests_that_make_no_sense(self):
        self.start()
        for body, values in (([], ["JSON"]),
                             ({"type": "bkae"}, ["type", '"bkae"', "bake, scene, infer, pack, export, drill"]),
                             ({"type": "drill", "colour": 1}, ['"colour"']),
                             ({"type": "drill", "parameters": {"seconds": -1}}, ["seconds", "-1", "0", "86400"]),
                             ({"type": "drill", "parameters": {"then": 7}}, ["then", "7", "succeed"]),
                             ({"type": "drill", "priority": 1e30}, ["priority", "-1000", "1000"]),
                             ({"type": "drill", "needs": [99]}, ["needs", "99"]),
                             ({"type": "drill", "label": "a\u009b31m"}, ["label"]),
                             ({"type": "drill", "parameters": {"text": "a\u0085"}}, ["text"]),
                             ({"type": "bake", "parameters": {}, "output": "/a"}, ["parameters.input"])):
            with self.subTest(body=body):
                self.refused(400, "usage", values, "POST", "/v1/jobs", body)
        self.refused(404, "not_found", [], "GET", "/v2")
        self.refused(404, "not_found", ["x"], "GET", "/v1/jobs/x")
        self.refused(405, "method", ["GET"], "DELETE", "/v1/jobs/1")
        self.refused(403, "origin", [], "POST", "/v1/jobs", {"type": "drill"}, headers={"Origin": "http://evil"})
        self.refused(403, "origin", [], "POST", "/v1/jobs", {"type": "drill"}, headers={"Host": "evil:80"})
        status, _ = self.service.ask("PUT", "/v1/uploads/a.bin", headers={"Content-Length": str(1 << 40)})
        self.assertEqual(status, 413)

    def test_paths_of_requests_are_read_as_they_are(self):
        config = QUICK + '[[queue]]\nname = "default"\n[[queue]]\nname = "a+b"\n[[queue]]\nname = "a b"\n'
        service = self.start(config)
        for target, name in (("a+b", "a+b"), ("a%2Bb", "a+b"), ("a%20b", "a b")):
            status, answer = service.ask("POST", f"/v1/queues/{target}/pause")
            self.assertEqual((status, answer["name"]), (200, name))
        for target in ("/v1/jobs%00", "/%00", "/v1/queues/default%00/pause", "/v1/jobs?queue=a%00b",
                       "/v1/jobs?%00=1"):
            self.refused(400, "usage", [], "POST" if "pause" in target else "GET", target)
        # A NUL character does not end a text. The service refuses it everywhere.
        job = {"type": "drill", "parameters": {}}
        for body in (dict(job, label="a\0b"), dict(job, queue="default\0"), dict(job, type="drill\0"),
                     dict(job, output="a\0b"), dict(job, parameters={"text": "a\0"}), dict(job, **{"lab\0el": "a"}),
                     {"type": "bake", "parameters": {"input": "/a\0b"}, "output": "a.ndf.exr"}):
            self.refused(400, "usage", ["NUL"], "POST", "/v1/jobs", body)
        self.refused(400, "usage", ["NUL"], "POST", "/v1/retry", {"queue": "default\0"})

    def test_it_is_not_ready_without_a_driver(self):
        empty = os.path.join(self.folder, "empty")
        os.mkdir(empty)
        service = self.start(environment={"OCL_ICD_VENDORS": empty, "OCL_ICD_FILENAMES": ""})
        status, answer = service.ask("GET", "/readyz")
        self.assertEqual((status, answer["ready"], answer["driver"]), (503, False, False), answer)
        self.assertIn("OpenCL", answer["message"])
        self.assertEqual(service.wait_for(self.drill())["state"], "succeeded", "other jobs must still be done")
        service.stop()
        service = self.start()
        status, answer = service.ask("GET", "/readyz", timeout=60)
        self.assertEqual((status, answer["ready"], answer["driver"]), (200, True, True), answer)

    def test_files_outside_of_the_roots(self):
        service = self.start()
        secret = os.path.join(self.folder, "secret.png")
        with open(secret, "w", encoding="utf-8") as file:
            file.write("secret")
        os.symlink(secret, self.output("link.png"))
        os.symlink(self.folder, self.output("door"))
        with open(self.output("mine.png"), "w", encoding="utf-8") as file:
            file.write("mine")
        for source in ("/etc/passwd", secret, self.output("link.png"), self.output("door/secret.png"),
                       self.output("../secret.png"), "/nowhere/at/all"):
            with self.subTest(source=source):
                self.refused_path(source, {"type": "bake", "parameters": {"input": source},
                                           "output": self.output("a.ndf.exr")})
        for result in ("/etc/a.ndf.exr", self.output("door/a.ndf.exr"), self.output("../a.ndf.exr")):
            with self.subTest(result=result):
                self.refused_path(result, {"type": "bake", "parameters": {"input": self.output("mine.png")},
                                           "output": result})
        self.refused_path(self.output("link.png"), {"type": "drill", "output": self.output("link.png")},
                          is_outside=False)
        # The job of a scene may also name files.
        with open(self.output("job.toml"), "w", encoding="utf-8") as file:
            file.write('geometry = "../secret.png"\n')
        self.refused(400, "usage", ["secret.png", self.results()], "POST", "/v1/jobs",
                     {"type": "infer", "parameters": {"job": self.output("job.toml")}, "output": self.output("out")})
        self.assertEqual(service.counts()["queued"], 0)

    def test_a_token_where_others_can_reach_it(self):
        done = subprocess.run([MULTUM, "serve", "--data", os.path.join(self.folder, "d"), "--listen", "0.0.0.0:0"],
                              capture_output=True, text=True, check=False, timeout=30)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--token-file", done.stderr)
        token = os.path.join(self.folder, "token")
        with open(token, "w", encoding="utf-8") as file:
            file.write("a token of many letters\n")
        os.chmod(token, 0o600)
        self.start(options=["--token-file", token])
        self.refused(401, "token", [], "GET", "/v1/jobs")
        wrong = {"Authorization": "Bearer a token of many letterz"}
        self.refused(401, "token", [], "GET", "/v1/jobs", headers=wrong)
        bearer = {"Authorization": "Bearer a token of many letters"}
        self.assertEqual(self.service.ask("GET", "/v1/jobs", headers=bearer)[0], 200)
        for public in ("/healthz", "/openapi.json"):
            self.assertEqual(self.service.ask("GET", public)[0], 200)
        # The case of the scheme does not matter, and another scheme is refused. If a browser cannot send headers, the
        # query can contain the token.
        for scheme, status in (("bearer", 200), ("BEARER ", 200), ("Basic", 401), ("Bearera", 401), ("", 401)):
            given = {"Authorization": f"{scheme} a token of many letters"}
            self.assertEqual(self.service.ask("GET", "/v1/jobs", headers=given)[0], status, scheme)
        query = "access_token=a+token%20of+many+letters"
        self.assertEqual(self.service.ask("GET", f"/v1/jobs?{query}")[0], 200)
        for method, target in (("POST", "/v1/purge"), ("POST", "/v1/jobs"), ("PUT", "/v1/uploads/a")):
            self.refused(401, "token", [], method, f"{target}?{query}")
        self.assertIn("token", self.client("list", code=2))
        self.assertEqual(self.client("list", "--token-file", token), "")

    def test_a_unix_socket_is_its_owners(self):
        path = os.path.join(self.folder, "socket")
        self.service = Service(MULTUM, self.folder)
        os.makedirs(self.service.data)
        process = subprocess.Popen([MULTUM, "serve", "--data", self.service.data, "--root", self.service.root,
                                    "--listen", "unix:" + path], stderr=subprocess.DEVNULL)
        self.service.process = process
        deadline = time.monotonic() + 60
        while not os.path.exists(os.path.join(self.service.data, "address")):
            self.assertIsNone(process.poll(), "the daemon ended")
            self.assertLess(time.monotonic(), deadline, "the daemon does not listen")
            time.sleep(0.02)
        self.assertEqual(os.stat(path).st_mode & 0o777, 0o600)
        done = subprocess.run([MULTUM, "jobs", "submit", "drill", "--wait", "--server", "unix:" + path],
                              capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        process.terminate()
        self.assertEqual(process.wait(30), 0)
        self.assertFalse(os.path.exists(path))

    def test_who_is_slow_or_talks_nonsense_costs_nothing(self):
        service = self.start(QUICK + "connections_max = 200\n")
        slow = []
        for _ in range(100):
            one = socket.create_connection(("127.0.0.1", service.port))
            one.sendall(b"POST /v1/jobs HTTP/1.1\r\nHost: lo")
            slow.append(one)
        self.assertEqual(service.wait_for(self.drill())["state"], "succeeded")
        for nonsense in (b"\x16\x03\x01\x02\x00", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\r\n" * 100,
                         b"GET /%zz HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 10000 + b"\r\n",
                         b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n{\"a\"",
                         b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n",
                         b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 200000\r\n\r\n"
                         + b"[" * 200000):
            with socket.create_connection(("127.0.0.1", service.port)) as one:
                one.settimeout(5)
                try:
                    one.sendall(nonsense)
                    one.shutdown(socket.SHUT_WR)
                    while one.recv(65536):
                        pass
                except OSError:  # the service closed the connection before the request was complete
                    pass
        self.assertEqual(service.ask("GET", "/healthz")[0], 200)
        deadline = time.monotonic() + 30
        while slow and time.monotonic() < deadline:
            slow[0].settimeout(30)
            with slow.pop(0) as one:
                self.assertTrue(one.recv(100).startswith(b"HTTP/1.1 408"), "slow clients are disconnected")
        before = resident_bytes(service.process.pid)
        for _ in range(2000):
            status, _ = service.ask("POST", "/v1/jobs", {"type": "drill", "parameters": {"seconds": "x" * 1000}})
            self.assertEqual(status, 400)
        self.assertLess(resident_bytes(service.process.pid), before + (8 << 20))


if __name__ == "__main__":
    unittest.main(verbosity=2)
