#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests pictures of jobs. A child process makes each picture once. If the child crashes, hangs or is missing, only
pictures are affected. MULTUM names the program.

  MULTUM=build/release/bin/multum-drill pictures_test.py [-v] [PicturesTest.test_...]
"""
import contextlib
import os
import shutil
import struct
import subprocess
import sys
import threading
import time
import unittest
import urllib.request

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from service_harness import MULTUM, Service, ServiceCase  # noqa: E402
from tiny_animation import write_animation  # noqa: E402



def png_size(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n", data[:20]
    return struct.unpack(">II", data[16:24])


class PicturesTest(ServiceCase):
    def start(self, viewer=None, **more):
        """`viewer` is a shell script that replaces multum-view for this daemon. If it is "", multum-view is
        missing."""
        multum = MULTUM
        if viewer is not None:
            multum = os.path.join(self.folder, "bin", "multum")
            os.makedirs(os.path.dirname(multum))
            shutil.copy(MULTUM, multum)
            shutil.copy(os.path.join(os.path.dirname(os.path.abspath(MULTUM)), "multum-decode"), multum + "-decode")
            if viewer:
                with open(multum + "-view", "w", encoding="utf-8") as file:
                    file.write("#!/bin/sh\n" + viewer)
                os.chmod(multum + "-view", 0o755)
        self.service = Service(multum, self.folder, config="back_off_first_s = 0.05\n", **more).start()
        subprocess.run([MULTUM, "testmap", "--size", "64", self.path("q")], check=True, capture_output=True)
        return self.service

    def path(self, name):
        return os.path.join(self.service.root, name)

    def bake(self, output="q.ndf.exr", **parameters):
        parameters = {"input": self.path("q_normal.png"), "lobes": 1, "no_measure": True, **parameters}
        job = self.service.wait_for(self.service.submit(type="bake", parameters=parameters, output=self.path(output)))
        self.assertEqual(job["state"], "succeeded", job)
        return job["id"]

    def ask(self, job, name):
        return self.service.ask("GET", f"/v1/jobs/{job}/pictures/{name}.png", timeout=120)

    def refused(self, job, name, words):
        status, answer = self.ask(job, name)
        self.assertEqual(status, 404, answer)
        self.assertEqual(answer["error"]["code"], "no_picture")
        self.assertIn(words, answer["error"]["message"])
        return answer["error"]["message"]

    def folders(self):
        pictures = os.path.join(self.service.data, "pictures")
        # A daemon that ends removes the folder if it is empty.
        return sorted(os.listdir(pictures)) if os.path.exists(pictures) else []

    def test_three_pictures_of_a_bake(self):
        self.start()
        job = self.bake()
        sizes = {name: png_size(self.ask(job, name)[1]) for name in ("input", "render", "error")}
        self.assertEqual(sizes, {"input": (64, 64), "render": (384, 288), "error": (384, 288)})
        self.assertEqual(len(self.folders()), 1)
        self.assertTrue(self.folders()[0].startswith(f"{job}-"))
        status, answer = self.service.ask("POST", "/v1/purge", {"jobs": [job]})
        self.assertEqual((status, answer["purged"]), (200, [job]))
        self.assertEqual(self.folders(), [])

    def test_without_its_input_there_is_a_render(self):
        self.start()
        job = self.bake(first_level=1)
        os.remove(self.path("q_normal.png"))
        self.assertEqual(self.ask(job, "render")[0], 200)
        for name in ("input", "error"):
            self.assertNotIn("changed", self.refused(job, name, "input"))

    def test_a_changed_input_or_result_is_not_shown(self):
        self.start()
        job, other = self.bake(), self.bake("b.ndf.exr", lobes=2)
        shutil.copy(self.path("q_albedo.png"), self.path("q_normal.png"))
        self.refused(job, "input", "changed")
        self.assertEqual(self.ask(job, "render")[0], 200)
        shutil.copy(self.path("q.ndf.exr"), self.path("b.ndf.exr"))
        self.refused(other, "render", "result")
        os.remove(self.path("q.ndf.exr"))
        self.refused(job, "render", "result")

    def test_pictures_go_when_what_they_show_has_changed(self):
        self.start()
        job = self.bake()
        for name in ("input", "error"):
            self.assertEqual(self.ask(job, name)[0], 200)
        shutil.copy(self.path("q_albedo.png"), self.path("q_normal.png"))
        for name in ("input", "error"):
            self.refused(job, name, "changed")
        os.remove(self.path("q_normal.png"))
        self.refused(job, "input", "input")
        self.assertEqual(self.ask(job, "render")[0], 200)
        # A symbolic link to the moved result does not count as the result.
        shutil.move(self.path("q.ndf.exr"), self.path("moved.ndf.exr"))
        os.symlink(self.path("moved.ndf.exr"), self.path("q.ndf.exr"))
        self.refused(job, "render", "result")

    def test_they_count_against_data_max_and_may_be_removed(self):
        service = self.start()
        job = self.bake()
        self.assertEqual(self.ask(job, "render")[0], 200)
        shutil.rmtree(os.path.join(service.data, "pictures"))
        self.assertEqual(self.ask(job, "render")[0], 200, "the folder must be made again")
        shutil.rmtree(os.path.join(service.data, "pictures"))
        service.stop()
        # This limit is below the size of the pictures.
        with open(os.path.join(self.folder, "serve.toml"), "a", encoding="utf-8") as file:
            file.write('data_max = "8K"\n')
        service.start()
        status, answer = self.ask(job, "render")
        self.assertEqual((status, answer["error"]["code"]), (507, "quota"), answer)
        self.assertEqual(self.folders(), [], "pictures without room must not be kept")

    def pack(self):
        write_animation(self.service.root, 0.25)
        subprocess.run([MULTUM, "infer", self.path("animation.toml"), "-o", self.path("field"), "--context=osmesa",
                        "--no-frames", "--no-comparison", "-q"], check=True, env=self.service.environment)
        job = self.service.wait_for(self.service.submit(
            type="pack", parameters={"manifest": self.path("field/inferred.json"), "lambda": 20},
            output=self.path("field.mpt")))
        self.assertEqual(job["state"], "succeeded", job)
        return job["id"]

    def test_a_packed_field_has_a_player(self):
        self.start()
        job = self.pack()
        subprocess.run([MULTUM, "unpack", self.path("field.mpt"), "-o", self.path("unpacked"), "-q"], check=True)
        status, page = self.service.ask("GET", f"/v1/jobs/{job}/pictures/player.html", timeout=120)
        if status == 404 and "built without" in page["error"]["message"]:
            self.skipTest(page["error"]["message"])
        self.assertEqual(status, 200, page)
        subprocess.run([MULTUM, "player", self.path("field.mpt"), "-o", self.path("alone.html"), "-q"], check=True,
                       env=self.service.environment)
        with open(self.path("alone.html"), "rb") as file:
            self.assertEqual(page, file.read())
        with urllib.request.urlopen(f"http://127.0.0.1:{self.service.port}/v1/jobs/{job}/pictures/player.html") as one:
            policy = one.headers["Content-Security-Policy"]
        self.assertIn("sandbox allow-scripts", policy)
        self.assertNotIn("allow-same-origin", policy)
        self.refused(job, "render", "no pictures")
        baked = self.bake()
        status, answer = self.service.ask("GET", f"/v1/jobs/{baked}/pictures/player.html")
        self.assertEqual((status, answer["error"]["code"]), (404, "no_picture"))
        # The scene file has changed since the bake, so the answer says why there is no picture.
        other = self.service.wait_for(self.service.submit(
            type="pack", parameters={"manifest": self.path("field/inferred.json"), "lambda": 30},
            output=self.path("other.mpt")))
        with open(self.path("quad.obj"), "a", encoding="utf-8") as file:
            file.write("# changed\n")
        def refused_player(words):
            # The daemon remembers until its restart that a picture failed.
            self.service.stop()
            self.service.start()
            status, answer = self.service.ask("GET", f"/v1/jobs/{other['id']}/pictures/player.html", timeout=120)
            self.assertEqual(status, 404, answer)
            self.assertIn(words, answer["error"]["message"])
            return answer["error"]["message"]

        refused_player("not the geometry")
        # The service does not wait for a pipe. It does not reveal whether files outside the root folders exist.
        geometry = self.path("quad.obj")
        os.remove(geometry)
        os.mkfifo(geometry)
        refused_player("not a file")
        words = set()
        for outside in ("secret", "nothing"):
            os.remove(geometry)
            with open(os.path.join(self.folder, "secret"), "w", encoding="utf-8") as file:
                file.write("secret")
            os.symlink(os.path.join(self.folder, outside), geometry)
            words.add(refused_player("not below a folder"))
        self.assertEqual(len(words), 1, words)

    def look(self, job):
        return self.service.ask("GET", f"/v1/jobs/{job}/pictures/look.html", timeout=120)

    def refused_look(self, job, words):
        status, answer = self.look(job)
        self.assertEqual((status, answer["error"]["code"]), (404, "no_picture"), answer)
        self.assertIn(words, answer["error"]["message"])

    def test_a_bake_of_lobes_has_a_look_page(self):
        service = self.start()
        job = self.bake(lobes=2)
        # If there are older pictures, the oldest one is removed.
        pictures = os.path.join(service.data, "pictures")
        for age in range(16):
            folder = os.path.join(pictures, f"{900 + age}-1-2-look")
            os.mkdir(folder)
            os.utime(folder, (time.time() - 1000 - age,) * 2)
        status, page = self.look(job)
        self.assertEqual(status, 200, page)
        kept = [name for name in self.folders() if name.endswith("-look")]
        self.assertEqual(len(kept), 16)
        self.assertNotIn("915-1-2-look", kept)
        subprocess.run([MULTUM, "look", self.path("q.ndf.exr"), "--source", self.path("q_normal.png"), "--no-open",
                        "-q", "-o", self.path("alone.html")], check=True, env=service.environment)
        with open(self.path("alone.html"), "rb") as file:
            self.assertEqual(page, file.read())
        with urllib.request.urlopen(f"http://127.0.0.1:{service.port}/v1/jobs/{job}/pictures/look.html") as one:
            self.assertIn("sandbox allow-scripts", one.headers["Content-Security-Policy"])
            self.assertNotIn("allow-same-origin", one.headers["Content-Security-Policy"])
        # The service keeps the page for later requests, as long as the map exists and is unchanged.
        self.assertEqual(self.look(job)[0], 200)
        shutil.move(self.path("q_normal.png"), self.path("kept.png"))
        self.refused_look(job, "q_normal.png")
        shutil.copy(self.path("q_albedo.png"), self.path("q_normal.png"))
        self.refused_look(job, "changed")
        shutil.copy(self.path("kept.png"), self.path("q_normal.png"))  # the same contents in another file
        self.assertEqual(self.look(job)[0], 200)
        self.assertEqual(self.ask(job, "render")[0], 200)
        self.assertEqual(service.ask("POST", "/v1/purge", {"jobs": [job]})[0], 200)
        self.assertEqual([name for name in self.folders() if name.startswith(f"{job}-")], [])

    def test_why_there_is_no_look_page(self):
        service = self.start()
        moments = service.submit(type="bake", output=self.path("m.ndf.exr"),
                                 parameters={"input": self.path("q_normal.png"), "ndf": "moments", "no_measure": True})
        self.assertEqual(service.wait_for(moments)["state"], "succeeded")
        self.refused_look(moments, "found no vMF lobes, expected a file of multum bake without --ndf")
        gone, changed = self.bake("gone.ndf.exr"), self.bake("changed.ndf.exr", lobes=2)
        shutil.move(self.path("q_normal.png"), self.path("kept.png"))
        self.refused_look(gone, "q_normal.png")
        # The service does not remember that a map was missing, because the map may come back.
        shutil.move(self.path("kept.png"), self.path("q_normal.png"))
        self.assertEqual(self.look(gone)[0], 200)
        shutil.copy(self.path("q_albedo.png"), self.path("q_normal.png"))
        self.refused_look(changed, "changed")
        self.assertEqual(self.look(service.submit(type="drill", parameters={"seconds": 0}))[0], 404)

    def test_who_has_none(self):
        service = self.start()
        drill = service.submit(type="drill", parameters={"seconds": 0})
        service.wait_for(drill)
        self.refused(drill, "render", "drill")
        bad = service.submit(type="bake", parameters={"input": self.path("q_normal.png"), "first_level": 15},
                             output=self.path("c.ndf.exr"))
        self.assertEqual(service.wait_for(bad)["state"], "dead")
        self.refused(bad, "input", "dead")
        self.assertEqual(service.ask("GET", "/v1/jobs/99/pictures/input.png")[0], 404)
        self.assertEqual(service.ask("GET", f"/v1/jobs/{drill}/pictures/other.png")[0], 404)

    def test_a_crash_is_one_childs_and_is_remembered(self):
        # The cache is one of the few folders that the viewer may write to.
        cache = os.path.join(self.folder, "cache")
        service = self.start('echo x >> "$MESA_SHADER_CACHE_DIR/begun"\nsleep 1\nkill -SEGV $$\n',
                             environment={"MESA_SHADER_CACHE_DIR": cache})
        job = self.bake()
        answers = []
        threads = [threading.Thread(target=lambda: answers.append(self.ask(job, "render"))) for _ in range(10)]
        for thread in threads:
            thread.start()
        begun = time.monotonic()
        self.assertEqual(service.ask("GET", "/healthz")[0], 200)
        healthy = time.monotonic() - begun
        for thread in threads:
            thread.join()
        self.assertEqual({status for status, _ in answers}, {404})
        self.assertIn("signal 11", answers[0][1]["error"]["message"])
        self.assertLess(healthy, 0.9, "/healthz must not wait for a child")
        self.refused(job, "input", "signal 11")
        with open(os.path.join(cache, "begun"), encoding="utf-8") as file:
            self.assertEqual(len(file.read()), 2, "one child serves all requests, later ones too")
        # A restarted daemon tries once more to make the picture.
        service.stop()
        service.start()
        self.refused(job, "render", "signal 11")
        with open(os.path.join(cache, "begun"), encoding="utf-8") as file:
            self.assertEqual(len(file.read()), 4)

    def ask_of_a_viewer_that_hangs(self):
        """Returns the service, the thread that waits for a picture, and the viewer's running process."""
        cache = os.path.join(self.folder, "cache")
        service = self.start('echo $$ > "$MESA_SHADER_CACHE_DIR/begun"\nexec sleep 1000\n',
                             environment={"MESA_SHADER_CACHE_DIR": cache})
        job = self.bake()
        thread = threading.Thread(target=lambda: self.assertRaises(Exception, self.ask, job, "render"))
        thread.start()
        begun = os.path.join(cache, "begun")
        deadline = time.monotonic() + 30
        while not (os.path.exists(begun) and os.path.getsize(begun) > 1):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.02)
        with open(begun, encoding="utf-8") as file:
            return service, thread, file.read().strip()

    def test_a_child_ends_with_a_daemon_that_is_killed(self):
        service, thread, child = self.ask_of_a_viewer_that_hangs()
        service.kill()
        thread.join()
        deadline = time.monotonic() + 30

        def is_there():
            with contextlib.suppress(FileNotFoundError, ProcessLookupError):
                with open(f"/proc/{child}/stat", encoding="utf-8") as file:
                    return file.read().rsplit(")", 1)[1].split()[0] not in "ZX"
            return False

        while is_there() and time.monotonic() < deadline:
            time.sleep(0.02)
        self.assertFalse(is_there(), "the child must run on for its minute")

    def test_a_child_that_hangs_keeps_nobody_from_ending(self):
        service, thread, _ = self.ask_of_a_viewer_that_hangs()
        begun = time.monotonic()
        self.assertEqual(service.stop(), 0)
        self.assertLess(time.monotonic() - begun, 20)
        thread.join()
        self.assertEqual([name for name in self.folders() if name != "unfinished"], [])

    def test_without_the_viewer_and_after_its_installation(self):
        self.start("", environment={"PATH": self.folder})
        job = self.bake()
        self.refused(job, "render", "multum-view")
        for name in ("multum-view", "multum-decode"):
            shutil.copy(os.path.join(os.path.dirname(os.path.abspath(MULTUM)), name), self.folder)
        self.assertEqual(self.ask(job, "render")[0], 200)

    def test_pictures_of_jobs_that_are_gone_are_swept(self):
        service = self.start()
        job = self.bake()
        self.assertEqual(self.ask(job, "render")[0], 200)
        gone = service.submit(type="drill", parameters={})
        service.wait_for(gone)
        self.assertEqual(service.ask("POST", "/v1/purge", {"jobs": [gone]})[0], 200)
        service.stop()
        pictures = os.path.join(service.data, "pictures")
        # A daemon may have died between the purge and the removal of this folder.
        shutil.copytree(os.path.join(pictures, self.folders()[0]), os.path.join(pictures, f"{gone}-1-2-3"))
        service.start()
        deadline = time.monotonic() + 10
        while len(self.folders()) > 1 and time.monotonic() < deadline:
            time.sleep(0.05)
        self.assertEqual([name.split("-")[0] for name in self.folders()], [str(job)])


if __name__ == "__main__":
    unittest.main(verbosity=2)
