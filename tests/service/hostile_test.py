#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests attacks on the service: by requests of clients, by files and folders that change during a job, and by the
settings of the service. Each test belongs to a kind of attack in docs/contributing/HOSTILE.md, "The service". MULTUM
names the program.

  MULTUM=build/release/bin/multum-drill hostile_test.py [-v] [HostileTest.test_...]
"""
import json
import os
import resource
import shutil
import signal
import socket
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from service_harness import MULTUM, QUICK, ClientCase, is_sanitized, resident_bytes  # noqa: E402

HOST = b"Host: localhost\r\n"


class HostileTest(ClientCase):
    def line(self, timeout=20):
        one = socket.create_connection(("127.0.0.1", self.service.port))
        one.settimeout(timeout)
        return one

    def said(self, *pieces, ends=True, timeout=20):
        """Returns the status and the whole text of the answer to these bytes. The status is 0 if there is no
        answer."""
        with self.line(timeout) as one:
            try:
                for piece in pieces:
                    one.sendall(piece)
                if ends:
                    one.shutdown(socket.SHUT_WR)
            except OSError:  # the connection was reset, possibly after an answer
                pass
            text = b""
            try:
                while piece := one.recv(65536):
                    text += piece
            except OSError:
                pass
        return (int(text.split()[1]) if text.startswith(b"HTTP/1.1 ") else 0), text

    def alive(self):
        self.assertEqual(self.service.ask("GET", "/healthz")[0], 200)
        self.assertIsNone(self.service.process.poll(), self.service.log_text()[-2000:])

    def upload(self, name, text):
        connection = self.service.connection()
        connection.request("PUT", f"/v1/uploads/{name}", text)
        response = connection.getresponse()
        answer = json.loads(response.read())
        connection.close()
        self.assertEqual(response.status, 201, answer)
        return answer["path"]

    def make_map(self, name="map"):
        subprocess.run([MULTUM, "testmap", self.output(name), "--size", "16"], check=True,
                       stdout=subprocess.DEVNULL)
        return self.output(name + "_normal.png")

    # ---- Requests that clients send

    def test_no_trailer_and_no_extension_of_a_chunk_ends_it(self):
        self.start()
        chunked = b" HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n"
        for size in (10, 16000, 65533, 65534, 70000, 1 << 20):
            value = b"x" * size
            for tail in (b"0\r\nA: " + value + b"\r\n\r\n", b"0;a=" + value + b"\r\n\r\n",
                         b"1;a=" + value + b"\r\nx\r\n0\r\n\r\n", b"0\r\n" + b"A: b\r\n" * (size // 6) + b"\r\n"):
                status, text = self.said(b"POST /v1/retry" + chunked + tail)
                self.assertIn(status, (202, 400) if size < 16000 else (0, 202, 400, 413, 431), (size, text[:200]))
                self.assertFalse(status == 202 and size > 16384, size)
                for method, path, expected in ((b"GET", b" /healthz", 413), (b"POST", b" /healthz", 405)):
                    self.assertEqual(self.said(method + path + chunked + tail)[0], expected, size)
        self.alive()

    def test_a_request_has_so_many_fields_and_parameters(self):
        self.start()
        for count, status in ((99, 200), (100, 431), (4000, 431)):
            fields = b"".join(b"a%d: b\r\n" % number for number in range(count))
            self.assertEqual(self.said(b"GET /healthz HTTP/1.1\r\n" + HOST + fields + b"\r\n")[0], status, count)
        for count, status in ((32, 200), (33, 400), (2000, 400)):
            query = b"&".join(b"q%d" % number for number in range(count))
            self.assertEqual(self.said(b"GET /healthz?" + query + b" HTTP/1.1\r\n" + HOST + b"\r\n")[0], status, count)
        self.assertEqual(self.said(b"GET /v1/jobs HTTP/1.1\r\n" + HOST + b"Content-Length: 5\r\n\r\nhello")[0], 413)

    def test_answers_and_events_have_their_part_of_memory(self):
        """Tests jobs with long parameters. Many clients list a thousand jobs at a time, and listeners do not read
        their events."""
        service = self.start(QUICK + 'request_memory_max = "16M"\nupload_max = "8M"\n')
        name = self.make_map()
        long_name = os.path.join(service.root, *(["x" * 200] * 15))
        os.makedirs(long_name)
        shutil.copy(name, long_name)
        service.ask("POST", "/v1/queues/default/pause")
        before = resident_bytes(service.process.pid)
        deaf = [self.line() for _ in range(20)]
        for one in deaf:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            one.sendall(b"GET /v1/events HTTP/1.1\r\n" + HOST + b"\r\n")
        for number in range(1000):
            service.submit(type="bake", parameters={"input": os.path.join(long_name, "map_normal.png")},
                           label="l" * 1000, output=self.output(f"{number}.ndf.exr"), again=True)
        self.assertEqual(service.ask("GET", "/v1/jobs?limit=100")[0], 200)
        self.assertEqual(service.ask("GET", "/v1/jobs?limit=1000")[0], 503)
        asking = [self.line() for _ in range(50)]
        for one in asking:
            one.sendall(b"GET /v1/jobs?limit=200 HTTP/1.1\r\n" + HOST + b"\r\n")
        self.alive()
        if not is_sanitized(service.process.pid):
            self.assertLess(resident_bytes(service.process.pid) - before, 96 << 20)
        statuses = {int(one.recv(100).split()[1]) for one in asking}
        self.assertLessEqual(statuses, {200, 503})
        for one in deaf + asking:
            one.close()

    def test_bodies_and_headers_share_one_budget(self):
        service = self.start(QUICK + 'request_memory_max = "32M"\nupload_max = "64M"\n')
        before = resident_bytes(service.process.pid)
        lines, endless = [], b";a=" + b"x" * (1 << 20)
        for number in range(60):
            one = self.line()
            kind = number % 3
            if kind == 0:  # a chunk extension that never ends
                one.sendall(b"POST /v1/jobs HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n5")
            elif kind == 1:  # a body that never arrives
                one.sendall(b"POST /v1/jobs HTTP/1.1\r\n" + HOST + b"Content-Length: 1000000\r\n\r\n" + b" " * 999999)
            else:  # an upload that stays open
                one.sendall(b"PUT /v1/uploads/a.bin HTTP/1.1\r\n" + HOST + b"Content-Length: 30000000\r\n\r\n")
                try:
                    one.sendall(b"x" * (20 << 20))
                except OSError:
                    pass
            try:
                if kind == 0:
                    for _ in range(64):
                        one.sendall(endless)
            except OSError:
                pass
            lines.append(one)
        self.alive()
        if not is_sanitized(service.process.pid):
            self.assertLess(resident_bytes(service.process.pid) - before, 64 << 20)
        self.assertLessEqual(service.metric("multum_http_memory_bytes"), 32 << 20)
        self.assertGreater(service.metric("multum_http_memory_bytes"), 10 << 20)
        for one in lines:
            one.close()
        self.assertEqual(service.wait_for(service.submit(type="drill", parameters={}))["state"], "succeeded")

    def test_without_memory_a_request_fails_and_not_the_daemon(self):
        service = self.start()
        if is_sanitized(service.process.pid):
            self.skipTest("a sanitizer ends programs that run out of memory")
        with open(f"/proc/{service.process.pid}/status", encoding="utf-8") as file:
            status = file.read()
        now = int(next(row for row in status.splitlines() if row.startswith("VmSize:")).split()[1]) << 10
        resource.prlimit(service.process.pid, resource.RLIMIT_AS, (now + (24 << 20), now + (24 << 20)))
        lines = []
        for _ in range(200):
            one = self.line()
            try:
                one.sendall(b"POST /v1/jobs HTTP/1.1\r\n" + HOST + b"Content-Length: 1000000\r\n\r\n" + b"[" * 999999)
            except OSError:
                pass
            lines.append(one)
        self.alive()
        for one in lines:
            one.close()
        deadline = time.monotonic() + 30
        while service.metric("multum_http_memory_bytes") > 4 << 20 and time.monotonic() < deadline:
            time.sleep(0.05)
        self.assertEqual(service.ask("GET", "/v1/jobs")[0], 200)

    def test_what_two_readers_may_understand_differently_is_refused(self):
        self.start()
        for head, status in ((HOST + HOST, 400), (HOST + b"A: b\r\n c\r\n", 400), (b"", 400),
                             (HOST + b"Transfer-Encoding: gzip\r\n", 501),
                             (HOST + b"Transfer-Encoding: gzip, chunked\r\n", 501),
                             (HOST + b"Transfer-Encoding: chunked\r\nContent-Length: 5\r\n", 400),
                             (HOST + b"Content-Length: 5\r\nContent-Length: 6\r\n", 400),
                             (HOST + b"Origin: http://localhost\r\nOrigin: http://evil\r\n", 400),
                             (HOST + b"Authorization: Bearer a\r\nAuthorization: Bearer b\r\n", 400),
                             (HOST, 200), (HOST + b"Sec-Fetch-Site: same-origin\r\n", 200)):
            self.assertEqual(self.said(b"GET /v1/types HTTP/1.1\r\n" + head + b"\r\n")[0], status, head)
        self.assertEqual(self.said(b"GET / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n")[0], 400)
        # A line feed without a carriage return does not end a line. The service refuses it at once.
        self.assertEqual(self.said(b"GET / HTTP/1.1\nHost: localhost\n\n", ends=False)[0], 400)

    def test_pages_of_others_are_not_served(self):
        self.start()
        for headers in ({"Host": "multum"}, {"Host": "intranet"}, {"Host": "localhost.evil"}, {"Origin": "http://evil"},
                        {"Sec-Fetch-Site": "cross-site"}, {"Sec-Fetch-Site": "same-site"},
                        {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}):
            self.refused(403, "origin", [], "GET", "/v1/jobs", headers=headers)
        # Other sites may link to the page.
        self.assertEqual(self.service.ask("GET", "/", headers={"Sec-Fetch-Site": "cross-site",
                                                               "Sec-Fetch-Mode": "navigate"})[0], 200)
        self.refused(403, "origin", [], "GET", "/",
                     headers={"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"})

    def test_listeners_leave_room_for_others(self):
        service = self.start(QUICK + "connections_max = 40\n")
        listeners = []
        full = 0
        for _ in range(60):
            one = self.line()
            one.sendall(b"GET /v1/events HTTP/1.1\r\n" + HOST + b"\r\n")
            if one.recv(100).startswith(b"HTTP/1.1 503"):
                full += 1
                one.close()
            else:
                listeners.append(one)
        self.assertEqual(service.metric("multum_http_event_streams"), 30)
        self.assertGreaterEqual(full, 20)
        self.alive()
        # Idle connections take all remaining places. The service still answers monitoring requests, but other clients
        # must try again later.
        idle = [self.line() for _ in range(40)]
        time.sleep(0.2)
        self.assertEqual(self.said(b"GET /healthz HTTP/1.1\r\n" + HOST + b"\r\n", ends=False)[0], 200)
        status, text = self.said(b"GET /v1/jobs HTTP/1.1\r\n" + HOST + b"\r\n", ends=False)
        self.assertEqual(status, 503, text)
        self.assertIn(b"Retry-After: 1", text)
        for one in listeners + idle:
            one.close()

    def test_who_missed_events_is_told(self):
        service = self.start()
        service.wait_for(service.submit(type="drill", parameters={}))
        _, text = self.said(b"GET /v1/events HTTP/1.1\r\n" + HOST + b"Last-Event-ID: 3\r\n\r\n", timeout=1, ends=False)
        self.assertIn(b"event: missed", text)
        last = int(text.rsplit(b"\nid: ", 1)[1].split()[0])
        _, text = self.said(b"GET /v1/events HTTP/1.1\r\n" + HOST + b"Last-Event-ID: 0\r\n\r\n", timeout=1, ends=False)
        self.assertNotIn(b"event: missed", text, "0 requests all kept events, and all must come")
        self.assertIn(b"event: job", text)
        self.assertEqual(service.stop(), 0)
        service.start()
        for number in (last, last + 10**12):
            _, text = self.said(b"GET /v1/events HTTP/1.1\r\n" + HOST + b"Last-Event-ID: %d\r\n\r\n" % number,
                                timeout=1, ends=False)
            self.assertIn(b"event: missed", text, number)

    # ---- Files and folders

    def test_a_folder_of_the_user_is_not_replaced(self):
        service = self.start()
        self.make_map()
        with open(self.output("scene.toml"), "w", encoding="utf-8") as file:
            file.write('[[map]]\nname = "m"\nnormal = "map_normal.png"\ngreen = "up"\n[[material]]\nname = "p"\n'
                       'brdf = "lambert"\n[[object]]\nname = "o"\nmap = "m"\nmaterial = "p"\nwidth = 1\n'
                       'distance = [1, 2]\n[[light]]\ndirection = [0, 0, 1]\n')
        mine = self.output("mine")
        os.mkdir(mine)
        with open(os.path.join(mine, "notes.txt"), "w", encoding="utf-8") as file:
            file.write("weeks of work")
        job = {"type": "scene", "parameters": {"scene": self.output("scene.toml")}, "again": True}
        self.assertIn("notes.txt", self.refused(400, "usage", [], "POST", "/v1/jobs", dict(job, output=mine)))
        # The scene is in the root folder itself.
        made = self.output("made")
        for _ in range(2):  # first into a new folder, then over its own result
            number = service.submit(**job, output=made)
            self.assertEqual(service.wait_for(number)["state"], "succeeded", service.job(number))
        self.assertTrue(os.path.exists(os.path.join(made, "plan.json")))
        with open(os.path.join(made, "added.txt"), "w", encoding="utf-8") as file:
            file.write("by hand")
        self.assertIn("added.txt", self.refused(400, "usage", [], "POST", "/v1/jobs", dict(job, output=made)))
        os.remove(os.path.join(made, "added.txt"))
        with open(os.path.join(made, "plan.json"), "a", encoding="utf-8") as file:
            file.write(" ")
        self.assertIn("plan.json", self.refused(400, "usage", [], "POST", "/v1/jobs", dict(job, output=made)))
        with open(os.path.join(mine, "notes.txt"), encoding="utf-8") as file:
            self.assertEqual(file.read(), "weeks of work")
        # The service ignores a listing that is a pipe. It still shows a name that is not valid UTF-8.
        os.mkfifo(os.path.join(mine, ".multum-result"))
        with open(os.path.join(mine, "notes.txt").encode() + b"\xff", "wb"):
            pass
        self.refused(400, "usage", [], "POST", "/v1/jobs", dict(job, output=mine))
        # The service finds a file that appears in the folder while the job waits, before the work begins.
        late = self.output("late")
        blocker = service.submit(type="drill", parameters={"seconds": 0.5})
        number = service.submit(**job, output=late, needs=[blocker], attempt_max=1)
        os.mkdir(late)
        with open(os.path.join(late, "late.txt").encode() + b"\xff", "w", encoding="utf-8") as file:
            file.write("x")
        done = service.wait_for(number)
        self.assertEqual(done["state"], "dead")
        self.assertIn("late.txt", done["message"])
        self.assertEqual(os.listdir(late.encode()), [b"late.txt\xff"])
        self.assertEqual(service.wait_for(service.submit(type="drill", parameters={}))["state"], "succeeded")

    def test_an_input_is_no_output(self):
        service = self.start()
        source = self.make_map()
        renamed = self.output("source.ndf.exr")
        os.rename(source, renamed)
        with open(renamed, "rb") as file:
            before = file.read()
        message = self.refused(400, "usage", [], "POST", "/v1/jobs",
                               {"type": "bake", "parameters": {"input": renamed}, "output": renamed})
        self.assertIn(renamed, message)
        with open(renamed, "rb") as file:
            self.assertEqual(file.read(), before)
        self.assertEqual(service.counts()["queued"], 0)

    def test_names_that_cannot_be(self):
        self.start()
        source = self.make_map()
        for name in ("x" * 250 + ".ndf.exr", "x" * 200 + ".ndf.exr", "map_normal.png/a.ndf.exr", ".multum-a.ndf.exr"):
            self.refused(400, "usage", [], "POST", "/v1/jobs",
                         {"type": "bake", "parameters": {"input": source}, "output": self.output(name)})
        os.mkdir(self.output("folder.ndf.exr"))
        self.refused(400, "usage", [], "POST", "/v1/jobs",
                     {"type": "bake", "parameters": {"input": source}, "output": self.output("folder.ndf.exr")})

    def test_a_scene_is_no_map(self):
        service = self.start()
        with open(os.path.join(self.folder, "secret.png"), "w", encoding="utf-8") as file:
            file.write("secret")
        scene = ('[[map]]\nname = "m"\nnormal = "%s"\n[[material]]\nname = "p"\nbrdf = "lambert"\n[[object]]\n'
                 'name = "o"\nmap = "m"\nmaterial = "p"\nwidth = 1\ndistance = [1, 2]\n[[light]]\n'
                 'direction = [0, 0, 1]\n'
                 % os.path.join(self.folder, "secret.png"))
        path = self.upload("scene.toml", scene)
        os.symlink(path, self.output("link.png"))
        for given in (path, self.output("link.png")):
            self.refused(400, "usage", [], "POST", "/v1/jobs",
                         {"type": "bake", "parameters": {"input": given}, "output": self.output("a.ndf.exr")})
        message = self.refused(400, "usage", [], "POST", "/v1/jobs",
                               {"type": "scene", "parameters": {"scene": path}, "output": self.output("a")})
        self.assertIn("secret.png", message)
        # An uploaded file must not be an output either.
        self.refused(400, "usage", [], "POST", "/v1/jobs", {"type": "drill", "parameters": {}, "output": path})

    def test_hostile_scenes_cost_a_child(self):
        service = self.start()
        for text in (".".join(["a"] * 32000) + " = 1\n", "a = [" + "1," * 8000000 + "]\n", "a = " + "[" * 100000):
            path = self.upload("scene.toml", text)
            for kind, name in (("scene", "scene"), ("infer", "job"), ("pack", "manifest")):
                ending = ".mpt" if kind == "pack" else ""
                self.refused(400, "input", [], "POST", "/v1/jobs",
                             {"type": kind, "parameters": {name: path}, "output": self.output("a") + ending})
        self.alive()

    def test_workers_open_nothing_outside(self):
        """If a link replaces a picture after the check, the sandbox of the worker refuses to open it."""
        service = self.start()
        source = self.make_map()
        blocker = service.submit(type="drill", parameters={"seconds": 0.5})
        outside = os.path.join(self.folder, "outside.png")
        os.rename(source, outside)
        shutil.copy(outside, source)
        number = service.submit(type="bake", parameters={"input": source, "green": "up"}, needs=[blocker],
                                output=self.output("a.ndf.exr"), attempt_max=1)
        os.unlink(source)
        os.symlink(outside, source)
        job = service.wait_for(number)
        self.assertEqual(job["state"], "dead")
        self.assertFalse(os.path.exists(self.output("a.ndf.exr")))

    def test_a_root_that_is_replaced_is_noticed(self):
        service = self.start()
        source = self.make_map()
        os.rename(service.root, service.root + ".old")
        os.mkdir(service.root)
        os.rename(os.path.join(service.root + ".old", "map_normal.png"), source)
        status, answer = service.ask("POST", "/v1/jobs", {"type": "bake", "parameters": {"input": source},
                                                          "output": self.output("a.ndf.exr")})
        self.assertEqual(status, 503, answer)
        self.assertIn(service.root, answer["error"]["message"])

    # ---- Settings

    def serve(self, *arguments):
        address = [] if "--listen" in arguments else ["--listen", "127.0.0.1:0"]
        done = subprocess.run([MULTUM, "serve", "--data", os.path.join(self.folder, "d"), *address,
                               *arguments], capture_output=True, text=True, check=False, timeout=30, cwd=self.folder)
        return done.returncode, done.stderr

    def test_roots_are_named_and_hold_nothing_of_the_daemons(self):
        root = os.path.join(self.folder, "root")
        os.mkdir(root)
        token, config = os.path.join(root, "token"), os.path.join(root, "serve.toml")
        for path in (token, config):
            with open(path, "w", encoding="utf-8") as file:
                file.write("workers = 2 # sixteen characters\n")
            os.chmod(path, 0o600)
        self.assertEqual(self.serve()[0], 2)
        self.assertIn("--root", self.serve()[1])
        for wrong in (["--root", "/"], ["--root", self.folder], ["--root", os.path.join(self.folder, "d")],
                      ["--root", root, "--token-file", token], ["--root", root, "--config", config],
                      ["--root", root, "--listen", f"unix:{root}/socket"]):
            code, said = self.serve(*wrong)
            self.assertEqual(code, 2, (wrong, said))
            self.assertIn("root", said)
        os.makedirs(os.path.join(self.folder, "d", "results"), exist_ok=True)
        self.assertEqual(self.serve("--root", os.path.join(self.folder, "d", "results"))[0], 2)

    def test_reading_the_settings_again_opens_nothing(self):
        first, second, empty = (os.path.join(self.folder, name) for name in ("first", "second", "empty"))
        for path, text in ((first, "the first token of all\n"), (second, "the second token of all\n"), (empty, "\n")):
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            os.chmod(path, 0o600)
        self.start(QUICK, options=["--token-file", first])
        config = os.path.join(self.folder, "serve.toml")

        def reloads(text):
            with open(config, "w", encoding="utf-8") as file:
                file.write(QUICK + text)
            before = self.service.log_text().count("settings")
            self.service.process.send_signal(signal.SIGHUP)
            deadline = time.monotonic() + 10
            while self.service.log_text().count("settings") == before:
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.01)

        def is_open_to(token):
            return self.service.ask("GET", "/v1/jobs", headers={"Authorization": "Bearer " + token})[0] == 200

        for text in (f'token_file = "{second}"\n', 'token_file = ""\n', f'token_file = "{empty}"\n', ""):
            reloads(text)
            self.assertTrue(is_open_to("the first token of all"), text)
            self.assertFalse(is_open_to("the second token of all"), text)
            self.refused(401, "token", [], "GET", "/v1/jobs")
        # The file that the command line names may contain a new token. An empty file is refused.
        with open(first, "w", encoding="utf-8") as file:
            file.write("the third token of all\n")
        reloads("")
        self.assertTrue(is_open_to("the third token of all"))
        with open(first, "w", encoding="utf-8") as file:
            file.write("")
        reloads("")
        self.assertTrue(is_open_to("the third token of all"))
        self.assertFalse(is_open_to(""))

    def test_a_token_of_the_settings_is_not_taken_away(self):
        token = os.path.join(self.folder, "token")
        with open(token, "w", encoding="utf-8") as file:
            file.write("a token of many letters\n")
        os.chmod(token, 0o600)
        self.start(QUICK + f'token_file = "{token}"\n')
        self.refused(401, "token", [], "GET", "/v1/jobs")
        with open(os.path.join(self.folder, "serve.toml"), "w", encoding="utf-8") as file:
            file.write(QUICK)
        self.service.process.send_signal(signal.SIGHUP)
        self.service.wait_for_log("previous settings remain in use")
        self.refused(401, "token", [], "GET", "/v1/jobs")


if __name__ == "__main__":
    unittest.main(verbosity=2)
