#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the files of the service's jobs as clients see them: inputs, uploads, results, downloads, and limits on their
size. MULTUM names the program.

  MULTUM=build/release/bin/multum-drill job_files_test.py [-v] [JobFilesTest.test_...]
"""
import contextlib
import http.client
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
import unittest
import urllib.parse

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from service_harness import (MULTUM, QUICK, ClientCase, is_sanitized, listed_files, resident_bytes,  # noqa: E402
                             seal_listing)
from tiny_animation import write_animation, write_exr  # noqa: E402


class JobFilesTest(ClientCase):
    checks_answers = True

    def test_a_bake_is_what_the_command_line_makes(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "64", os.path.join(service.root, "q")], check=True,
                       capture_output=True)
        source, alone = self.output("q_normal.png"), self.output("alone.ndf.exr")
        subprocess.run([MULTUM, "bake", source, "-o", alone, "--lobes", "2", "-q"], check=True, env=service.environment)
        self.assertIn("succeeded", self.client("submit", "bake", source, "-o", self.output("a.ndf.exr"), "--lobes", "2",
                                               "--wait"))
        with open(alone, "rb") as one, open(self.output("a.ndf.exr"), "rb") as other:
            self.assertEqual(one.read(), other.read())
        self.assertIn("written", self.client("tail", "1"))
        # An identical submission returns the same job. With another output, the service copies the result. With a
        # changed map, the submission is a new job.
        again = {"type": "bake", "parameters": {"input": source, "lobes": 2}, "output": self.output("a.ndf.exr")}
        self.assertEqual(service.ask("POST", "/v1/jobs", again)[0], 200)
        copy = service.submit(**dict(again, output=self.output("b.ndf.exr")))
        self.assertEqual(service.wait_for(copy)["reused_from"], 1)
        with open(alone, "rb") as one, open(self.output("b.ndf.exr"), "rb") as other:
            self.assertEqual(one.read(), other.read())
        os.remove(self.output("a.ndf.exr"))
        os.remove(self.output("b.ndf.exr"))
        made = service.wait_for(service.submit(**again))
        self.assertIsNone(made["reused_from"], "no earlier result was left to copy")
        status, data = service.ask("GET", f"/v1/jobs/{made['id']}/result")
        self.assertEqual(status, 200)
        with open(self.output("a.ndf.exr"), "rb") as file:
            self.assertEqual(file.read(), data)

    def test_a_result_behind_a_link_is_not_reused(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "32", self.output("q")], check=True, capture_output=True)
        job = {"type": "bake", "parameters": {"input": self.output("q_normal.png"), "lobes": 1, "no_measure": True}}
        os.mkdir(self.output("sub"))

        def made(name, **more):
            done = service.wait_for(service.submit(**job, output=self.output(name), **more))
            self.assertEqual(done["state"], "succeeded", done)
            with open(self.output(name), "rb") as file:
                return done, file.read()

        data = made("sub/a.ndf.exr")[1]
        # The file is moved to a folder that no job may read, and a link replaces it. Then the same is done with the
        # folder above it.
        elsewhere = os.path.join(self.folder, "elsewhere")
        os.mkdir(elsewhere)
        for name, moved in (("b.ndf.exr", "sub/a.ndf.exr"), ("c.ndf.exr", "sub")):
            if moved == "sub":
                os.remove(self.output("sub/a.ndf.exr"))
                made("sub/a.ndf.exr", again=True)
                os.remove(self.output("b.ndf.exr"))  # otherwise the service would copy the result from there
            target = os.path.join(elsewhere, os.path.basename(moved))
            shutil.move(self.output(moved), target)
            os.symlink(target, self.output(moved))
            done, again = made(name)
            self.assertIsNone(done["reused_from"], "a file behind a link does not count as a result")
            self.assertEqual((done["attempt"], again), (1, data))
        self.refused(409, "no_result", ["link"], "GET", "/v1/jobs/1/result")

    def test_names_that_are_no_utf8_keep_their_bytes(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "32", self.output("q")], check=True, capture_output=True)
        root = os.fsencode(service.root)
        # Tests a name that is not valid UTF-8, a valid name that equals the escaped text of the first name, and a name
        # with a character that escapes use.
        for name, text in ((b"caf\xe9", "caf\uefe9"), ("caf\uefe9".encode(), "caf\uefee\uefbf\uefa9"),
                           ("\u4e2d".encode(), "\u4e2d")):
            with self.subTest(name=name):
                source, result = root + b"/" + name + b".png", root + b"/" + name + b".ndf.exr"
                shutil.copy(self.output("q_normal.png"), source)
                number = int(self.client("submit", "bake", source, "-o", result, "--lobes", "1", "--no-measure",
                                         "--again"))
                job = service.wait_for(number)
                self.assertEqual(job["state"], "succeeded", job)
                self.assertTrue(job["output"].endswith(f"/{text}.ndf.exr"), job["output"])
                self.assertTrue(job["parameters"]["input"].endswith(f"/{text}.png"), job)
                self.assertTrue(os.path.exists(result), os.listdir(root))
                listed = subprocess.run([MULTUM, "jobs", "list"], capture_output=True, check=True,
                                        env=dict(os.environ, MULTUM_SERVER=f"http://127.0.0.1:{service.port}"))
                self.assertIn(result, listed.stdout)
                status, headers, data = self.download(number)
                self.assertIn("''" + urllib.parse.quote(name) + ".ndf.exr", headers["Content-Disposition"])
                with open(result, "rb") as file:
                    self.assertEqual((status, file.read()), (200, data))
                # The parameters in the answer can be submitted again.
                again = {"type": "bake", "parameters": job["parameters"], "output": job["output"]}
                self.assertEqual(service.ask("POST", "/v1/jobs", dict(again, again=True))[0], 201)
                service.wait_until_idle()
        missing = self.refused(400, "usage", ["no such file"], "POST", "/v1/jobs",
                               {"type": "bake", "parameters": {"input": self.output("a\uefff.png")},
                                "output": "b.ndf.exr"})
        self.assertIn("a\uefff.png", missing)

    def test_data_lies_in_a_folder_that_is_no_utf8(self):
        folder = os.fsencode(self.folder) + b"/f\xf6lder"
        os.mkdir(folder)
        self.folder, kept = os.fsdecode(folder), self.folder
        try:
            service = self.start()
            with contextlib.closing(service.connection()) as connection:
                connection.request("PUT", "/v1/uploads/a.png", b"content")
                response = connection.getresponse()
                answer = json.loads(response.read())
            self.assertEqual(response.status, 201, answer)
            self.assertIn("/f\ueff6lder/", answer["path"])
            bad = service.wait_for(service.submit(type="bake", parameters={"input": answer["path"]},
                                                  output="a.ndf.exr", attempt_max=1))
            self.assertIn("f\ueff6lder", bad["message"], "the file was found, but is not a picture")
            service.wait_for(self.drill(output="b.txt"))
            self.assertEqual(service.ask("GET", "/v1/jobs?limit=5")[0], 200)
            self.assertEqual(service.stop(), 0)
        finally:
            self.service.end(self.service.process)
            self.folder = kept

    def test_a_download_goes_on_where_it_broke_off(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "64", self.output("q")], check=True, capture_output=True)
        with open(self.output("scene.toml"), "w", encoding="utf-8") as file:
            file.write('[[map]]\nname = "wall"\nnormal = "q_normal.png"\n[[material]]\nname = "paint"\n'
                       'brdf = "lambert"\n[[object]]\nname = "front"\nmap = "wall"\nmaterial = "paint"\n'
                       'width = 2.0\ndistance = [1, 20]\n[[light]]\ndirection = [0.3, 0.8, 0.5]\n')
        jobs = [service.submit(type="bake", parameters={"input": self.output("q_normal.png"), "no_measure": True},
                               output=self.output("a.ndf.exr")),
                service.submit(type="scene", parameters={"scene": self.output("scene.toml")},
                               output=self.output("baked"))]
        for number in jobs:
            self.assertEqual(service.wait_for(number)["state"], "succeeded")
            target = f"/v1/jobs/{number}/result"
            status, headers, whole = self.download(number)
            self.assertEqual((status, headers["Accept-Ranges"]), (200, "bytes"))

            def part(asked, **more):
                with contextlib.closing(service.connection()) as connection:
                    connection.request("GET", target, headers={"Range": asked, **more})
                    response = connection.getresponse()
                    return response.status, response.headers["Content-Range"], response.read()

            size = len(whole)
            self.assertEqual(part("bytes=100-"), (206, f"bytes 100-{size - 1}/{size}", whole[100:]))
            self.assertEqual(part("bytes=600-699"), (206, f"bytes 600-699/{size}", whole[600:700]))
            self.assertEqual(part("bytes=-7"), (206, f"bytes {size - 7}-{size - 1}/{size}", whole[-7:]))
            self.assertEqual(part("bytes=100-", **{"If-Range": headers["ETag"]})[0], 206)
            self.assertEqual(part("bytes=100-", **{"If-Range": '"another"'})[2], whole)
            self.assertEqual(part(f"bytes={size}-")[:2], (416, f"bytes */{size}"))
            if shutil.which("curl"):
                here = os.path.join(self.folder, "here")
                for cut in (1, size // 2, size):
                    with open(here, "wb") as file:
                        file.write(whole[:cut])
                    subprocess.run(["curl", "-sS", "-C", "-", "-o", here,
                                    f"http://127.0.0.1:{service.port}{target}"], check=True)
                    with open(here, "rb") as file:
                        self.assertEqual(file.read(), whole, cut)

    def test_a_scene_is_a_folder_and_its_maps_are_its_inputs(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "32", os.path.join(service.root, "q")], check=True,
                       capture_output=True)
        scene = self.output("scene.toml")
        with open(scene, "w", encoding="utf-8") as file:
            file.write('[[map]]\nname = "wall"\nnormal = "q_normal.png"\n[[material]]\nname = "paint"\n'
                       'brdf = "lambert"\n[[object]]\nname = "front"\nmap = "wall"\nmaterial = "paint"\n'
                       'width = 2.0\ndistance = [1, 20]\n[[light]]\ndirection = [0.3, 0.8, 0.5]\n')
        self.assertIn("succeeded", self.client("submit", "scene", scene, "-o", self.output("baked"), "--wait"))
        self.assertTrue(os.path.exists(self.output("baked/wall.ndf.exr")))
        with open(self.output("baked/plan.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["maps"][0]["chosen"]["lobes"], 1)
        again = {"type": "scene", "parameters": {"scene": scene}, "output": self.output("baked")}
        self.assertEqual(service.ask("POST", "/v1/jobs", again)[0], 200, "the same is there")
        subprocess.run([MULTUM, "testmap", "--size", "16", os.path.join(service.root, "q")], check=True,
                       capture_output=True)
        self.assertEqual(service.ask("POST", "/v1/jobs", again)[0], 201, "a map of the scene has changed")
        with open(scene, "w", encoding="utf-8") as file:
            file.write("[[map]]\n")
        self.refused(400, "input", ["scene.toml:1: ", "map", "name"], "POST", "/v1/jobs",
                     dict(again, output=self.output("other")))

    def test_a_field_is_inferred_and_packed_and_what_it_names_are_inputs(self):
        service = self.start()
        write_animation(service.root, 0.25)
        self.assertIn("succeeded", self.client("submit", "infer", self.output("animation.toml"), "-o",
                                               self.output("field"), "--context", "osmesa", "--no-frames",
                                               "--no-comparison", "--wait"))
        manifest = self.output("field/inferred.json")
        with open(manifest, encoding="utf-8") as file:
            geometry = json.load(file)["geometry"]
        self.assertEqual(geometry, os.path.realpath(self.output("quad.obj")), "found from every output folder")
        self.assertIn("succeeded", self.client("submit", "pack", manifest, "-o", self.output("field.mpt"), "--lambda",
                                               "20", "--wait"))
        self.assertIn("lambda 20", self.client("tail", "2"))
        for command in (["pack", self.output("field"), "-o", self.output("alone.mpt"), "--lambda=20",
                         "--absolute-geometry"], ["unpack", self.output("field.mpt"), "-o", self.output("unpacked")]):
            subprocess.run([MULTUM, *command, "-q"], check=True, env=service.environment)
        with open(self.output("field.mpt"), "rb") as one, open(self.output("alone.mpt"), "rb") as other:
            data = one.read()
            self.assertEqual(data, other.read())
        self.assertEqual(service.ask("GET", "/v1/jobs/2/result"), (200, data))
        with open(self.output("unpacked/inferred.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["geometry"], geometry)
        # An identical submission returns the same job. With another output, the service copies the result. With another
        # texture, the submission is a new job.
        again = {"type": "pack", "parameters": {"manifest": manifest, "lambda": 20}, "output": self.output("field.mpt")}
        self.assertEqual(service.ask("POST", "/v1/jobs", again)[0], 200)
        copy = service.submit(**dict(again, output=self.output("copy.mpt")))
        self.assertEqual(service.wait_for(copy)["reused_from"], 2)
        texture = next(os.path.join(above, name) for above, _, names in os.walk(self.output("field/textures"))
                       for name in names)
        os.remove(texture)
        self.refused(400, "usage", [os.path.basename(texture)], "POST", "/v1/jobs", again)
        write_exr(self.output("radiance.exr"), 0.75)
        subprocess.run([MULTUM, "infer", self.output("animation.toml"), "-o", self.output("field"), "--context=osmesa",
                        "--no-frames", "--no-comparison", "-q"], check=True, env=service.environment)
        made = service.wait_for(service.submit(**again))
        self.assertIsNone(made["reused_from"])
        with open(self.output("field.mpt"), "rb") as file:
            self.assertNotEqual(file.read(), data)
        # The service does not retry a job whose target cannot be met. Only one target may be given.
        job = service.wait_for(service.submit(type="pack", parameters={"manifest": manifest, "bytes": 10},
                                              output=self.output("none.mpt")))
        self.assertEqual((job["state"], len(service.job(job["id"])["attempts"])), ("dead", 1))
        self.assertIn("cannot be reached", job["message"])
        self.assertFalse(os.path.exists(self.output("none.mpt")))
        self.refused(400, "usage", ["ratio", "lambda"], "POST", "/v1/jobs",
                     {"type": "pack", "parameters": {"manifest": manifest, "lambda": 1, "ratio": 2},
                      "output": self.output("none.mpt")})
        self.refused(400, "usage", [".mpt"], "POST", "/v1/jobs", dict(again, output=self.output("field.exr")))

    def test_a_map_is_exported_to_a_folder(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "32", os.path.join(service.root, "q")], check=True,
                       capture_output=True)
        source = self.output("q_normal.png")
        self.assertIn("succeeded", self.client("submit", "export", source, "-o", self.output("material"), "--format",
                                               "ktx2", "--base-roughness", "0.3", "--wait"))
        subprocess.run([MULTUM, "export", source, "-o", self.output("alone"), "--format=ktx2", "--base-roughness=0.3",
                        "-q"], check=True, env=service.environment)
        for name in ("normal.ktx2", "orm.ktx2"):
            with open(self.output(f"material/{name}"), "rb") as one, open(self.output(f"alone/{name}"), "rb") as other:
                self.assertEqual(one.read(), other.read(), name)
        status, archive = service.ask("GET", "/v1/jobs/1/result")
        self.assertEqual(status, 200)
        self.assertIn(b"orm.ktx2", archive)
        again = {"type": "export", "parameters": {"input": source, "format": "ktx2", "base_roughness": 0.3},
                 "output": self.output("material")}
        self.assertEqual(service.ask("POST", "/v1/jobs", again)[0], 200, "the same is there")
        self.refused(400, "usage", ["material.ktx2", "a folder"], "POST", "/v1/jobs",
                     dict(again, output=self.output("material.ktx2")))
        self.refused(400, "usage", ["base_roughness", "roughness"], "POST", "/v1/jobs",
                     dict(again, parameters=dict(again["parameters"], roughness=source)))
        subprocess.run([MULTUM, "bake", source, "-o", self.output("q.ndf.exr"), "--no-measure", "-q"], check=True,
                       env=service.environment)
        self.refused(400, "usage", ["q.ndf.exr", "not a baked file"], "POST", "/v1/jobs",
                     dict(again, parameters={"input": self.output("q.ndf.exr")}))

    def test_a_pack_job_is_cancelled_and_reads_nothing_outside(self):
        service = self.start()
        write_animation(service.root, 0.25, side=256, noise=0.5)
        subprocess.run([MULTUM, "infer", self.output("animation.toml"), "-o", self.output("field"), "--context=osmesa",
                        "--no-frames", "--no-comparison", "-q"], check=True, env=service.environment)
        manifest = self.output("field/inferred.json")
        job = service.submit(type="pack", parameters={"manifest": manifest, "lambda": 1e-4},
                             output=self.output("a.mpt"))
        deadline = time.monotonic() + 30
        while not (service.job(job)["progress"] or {"stage": ""})["stage"].startswith("code"):
            self.assertLess(time.monotonic(), deadline, service.job(job))
            time.sleep(0.01)
        self.assertEqual(service.ask("POST", f"/v1/jobs/{job}/cancel")[0], 202)
        self.assertEqual(service.wait_for(job)["state"], "cancelled")
        self.assertEqual([name for name in os.listdir(service.root) if "mpt" in name or "multum" in name], [])
        with open(os.path.join(self.folder, "secret.exr"), "w", encoding="utf-8") as file:
            file.write("secret")
        with open(manifest, encoding="utf-8") as file:
            field = json.load(file)
        layer = field["objects"][0]["layers"][0]
        layer["textures"] = ["../../secret.exr" for _ in layer["textures"]]
        with open(manifest, "w", encoding="utf-8") as file:
            json.dump(field, file)
        self.refused(400, "usage", ["secret.exr", self.results()], "POST", "/v1/jobs",
                     {"type": "pack", "parameters": {"manifest": manifest}, "output": self.output("a.mpt")})
        # These scene files are outside the root folders. One exists, one is missing, and one is a device. The answer
        # does not reveal anything about them.
        field["objects"][0]["layers"] = []
        words = set()
        for geometry in (os.path.join(self.folder, "secret.exr"), os.path.join(self.folder, "nothing.exr"),
                         "../../secret.exr", "/dev/zero"):
            with open(manifest, "w", encoding="utf-8") as file:
                json.dump(dict(field, geometry=geometry), file)
            message = self.refused(400, "usage", [self.results()], "POST", "/v1/jobs",
                                   {"type": "pack", "parameters": {"manifest": manifest},
                                    "output": self.output("a.mpt")})
            words.add(message.split(": ", 1)[1])
        self.assertEqual(len(words), 1, words)

    def test_an_input_that_changes_in_the_queue_is_no_earlier_one(self):
        service = self.start()
        for name, size in (("q", 32), ("other", 16)):
            subprocess.run([MULTUM, "testmap", "--size", str(size), self.output(name)], check=True, capture_output=True)
        source, first = self.output("q_normal.png"), self.output("first.png")
        shutil.copy(source, first)

        def job(output):
            return {"type": "bake", "parameters": {"input": source, "lobes": 1}, "output": self.output(output)}

        made = service.wait_for(service.submit(**job("a.ndf.exr")))
        service.ask("POST", "/v1/queues/default/pause")
        waiting = service.submit(**job("b.ndf.exr"))
        shutil.copy(self.output("other_normal.png"), source)
        service.ask("POST", "/v1/queues/default/resume")
        self.assertIsNone(service.wait_for(waiting)["reused_from"], "its input is not what it was")
        self.assertNotEqual(os.path.getsize(self.output("a.ndf.exr")), os.path.getsize(self.output("b.ndf.exr")))
        # The key of the job names the first map, so a client with that map does not get the result of the other map.
        os.replace(first, source)
        copy = service.wait_for(service.submit(**job("c.ndf.exr")))
        self.assertEqual(copy["reused_from"], made["id"])

    def test_uploads_are_baked_and_downloaded(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "32", os.path.join(service.root, "q")], check=True,
                       capture_output=True)
        with open(self.output("q_normal.png"), "rb") as file:
            picture = file.read()
        connection = service.connection()
        connection.request("PUT", "/v1/uploads/a.png", picture)
        response = connection.getresponse()
        upload = json.loads(response.read())
        self.assertEqual((response.status, upload["bytes"]), (201, len(picture)))
        results = os.path.join(service.data, "results", "a.ndf.exr")
        job = service.wait_for(service.submit(type="bake", parameters={"input": upload["path"], "lobes": 1},
                                              output=results))
        self.assertEqual(job["state"], "succeeded", job)
        self.refused(404, "not_found", [], "PUT", "/v1/uploads/..%2Fb.png")
        self.refused(400, "usage", ["100"], "PUT", "/v1/uploads/a%20b.png")
        self.refused(400, "usage", ["100"], "PUT", "/v1/uploads/.hidden")

    @unittest.skipUnless(shutil.which("curl"), "curl is not installed; the page's commands use it")
    def test_the_commands_of_the_page_run_as_they_stand(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "32", self.output("rock")], check=True, capture_output=True)
        page = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../docs/how-to/service_behind_proxy.md")
        with open(page, encoding="utf-8") as file:
            commands = re.search(r"\n## Submit a job with curl\n.*?```bash\n(.*?)```", file.read(), re.DOTALL)[1]
        here = os.path.join(self.folder, "client")
        os.makedirs(here)
        shutil.copy(self.output("rock_normal.png"), here)
        done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", commands], cwd=here, capture_output=True,
                              text=True, check=False, timeout=120,
                              env=dict(os.environ, MULTUM_SERVER=f"http://127.0.0.1:{service.port}",
                                       MULTUM_TOKEN_FILE="/dev/null"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('"state":"succeeded"', done.stdout)
        self.assertEqual(sorted(os.listdir(here)), ["rock.ndf.exr", "rock_normal.png"])
        with open(os.path.join(here, "rock.ndf.exr"), "rb") as one, \
                open(os.path.join(self.results(), "rock.ndf.exr"), "rb") as other:
            self.assertEqual(one.read(), other.read())

    def test_an_output_without_a_slash_lies_among_the_results(self):
        service = self.start()
        os.makedirs(os.path.join(service.data, "results", "sub"))
        for name in ("a.txt", "sub/b.txt", "./c.txt", "sub/../d.txt"):
            with self.subTest(name=name):
                job = service.wait_for(self.drill(output=name))
                self.assertEqual(job["state"], "succeeded", job)
                self.assertEqual(job["output"], os.path.normpath(os.path.join(self.results(), name)))
                self.assertTrue(os.path.isfile(job["output"]))
        root = os.path.relpath(os.path.realpath(service.root), self.results())
        for name in ("../a.txt", root + "/a.txt", "sub/../../a.txt", "nowhere/a.txt", ".", "..", "sub/.."):
            with self.subTest(name=name):
                self.refused(400, "usage", [self.results()], "POST", "/v1/jobs", {"type": "drill", "output": name})
        # The service does not guess the folder of a relative input either. Clients get the path of an upload from its
        # answer.
        with contextlib.closing(service.connection()) as connection:
            connection.request("PUT", "/v1/uploads/a.png", b"a picture")
            upload = json.loads(connection.getresponse().read())
        self.assertIn(json.dumps(upload["path"]), upload["use"])
        self.refused(400, "usage", ["'a.png'", os.path.dirname(os.path.dirname(upload["path"])), "upload"],
                     "POST", "/v1/jobs", {"type": "bake", "parameters": {"input": "a.png"}, "output": "a.ndf.exr"})

    def download(self, number):
        with contextlib.closing(self.service.connection()) as connection:
            connection.request("GET", f"/v1/jobs/{number}/result")
            response = connection.getresponse()
            data = response.read()
            return response.status, response.headers, data

    def test_a_result_is_sent_under_its_name(self):
        service = self.start()
        for name in ("plain-1.txt", "two words.txt", 'quo"te.txt', "back\\slash.txt", "per%41cent.txt",
                     "semi;colon=.txt", "h\u00e4\u4e16 \U0001f600.txt", "a" * 196 + ".txt"):
            with self.subTest(name=name):
                job = service.wait_for(self.drill(output=self.output(name), text=name))
                status, headers, data = self.download(job["id"])
                self.assertEqual((status, data.decode().strip()), (200, name))
                sent = headers["Content-Disposition"]
                self.assertTrue(sent.isascii() and sent.startswith("attachment; filename="), sent)
                # RFC 6266 prefers the extended file name to the plain one. Both names are safe.
                found = re.fullmatch(r'attachment; filename="([ -!#$&-\[\]-~]+)"'
                                     r"(?:; filename\*=UTF-8''([\w.%-]+))?", sent)
                self.assertIsNotNone(found, sent)
                self.assertEqual(urllib.parse.unquote(found[2]) if found[2] else found[1], name)

    def test_a_folder_is_sent_as_an_archive(self):
        service = self.start()
        subprocess.run([MULTUM, "testmap", "--size", "32", self.output("q")], check=True, capture_output=True)
        names = ["wall", "long" * 25]
        with open(self.output("scene.toml"), "w", encoding="utf-8") as file:
            for name in names:
                file.write(f'[[map]]\nname = "{name}"\nnormal = "q_normal.png"\n')
            file.write('[[material]]\nname = "paint"\nbrdf = "lambert"\n')
            for name in names:
                file.write(f'[[object]]\nname = "{name}"\nmap = "{name}"\nmaterial = "paint"\nwidth = 2.0\n'
                           'distance = [1, 20]\n')
            file.write("[[light]]\ndirection = [0.3, 0.8, 0.5]\n")
        made = service.wait_for(service.submit(type="scene", parameters={"scene": self.output("scene.toml")},
                                               output=self.output("b\u00e4ked")))
        self.assertEqual(made["state"], "succeeded", made)
        folder = self.output("b\u00e4ked")
        expected = {f"b\u00e4ked/{one}": os.path.join(folder, one) for one in os.listdir(folder) if one[0] != "."}
        self.assertGreater(len(expected), len(names))
        os.symlink("/etc/passwd", os.path.join(folder, "link"))
        with open(os.path.join(folder, "private.txt"), "w", encoding="utf-8") as file:
            file.write("put there since")
        status, headers, data = self.download(made["id"])
        self.assertEqual((status, headers["Content-Type"]), (200, "application/x-tar"))
        self.assertEqual(headers["Content-Disposition"],
                         "attachment; filename=\"b__ked.tar\"; filename*=UTF-8''b%C3%A4ked.tar")
        with tarfile.open(fileobj=io.BytesIO(data)) as archive:
            self.assertEqual(sorted(archive.getnames()), sorted(expected), "exactly the published files")
            for name, path in expected.items():
                with open(path, "rb") as file:
                    self.assertEqual(archive.extractfile(name).read(), file.read(), name)
                member = archive.getmember(name)
                self.assertEqual(member.mtime, int(os.stat(path).st_mtime))
                # The checksum in tar is the sum of all unsigned bytes, with blanks in the checksum field. Readers also
                # accept the sum of signed bytes.
                head = data[member.offset_data - 512:member.offset_data]
                self.assertEqual(int(head[148:154], 8), sum(head[:148] + b" " * 8 + head[156:]))
        listed = subprocess.run(["tar", "tf", "-"], input=data, capture_output=True, check=False,
                                env=dict(os.environ, LC_ALL="C.UTF-8"))
        self.assertEqual((listed.returncode, listed.stderr), (0, b""))
        service.ask("HEAD", f"/v1/jobs/{made['id']}/result")
        # The service does not send an archive if the listing names files outside the folder, or files that have
        # changed.
        listing = os.path.join(folder, ".multum-result")
        published = listed_files(folder)
        secret = os.path.join(self.folder, "secret")
        with open(secret, "w", encoding="utf-8") as file:
            file.write("secret")
        state = f"{os.stat(secret).st_size} {os.stat(secret).st_mtime_ns}"
        os.symlink(secret, os.path.join(folder, "door"))
        wall = os.stat(os.path.join(folder, "wall.ndf.exr"))
        own = f"{wall.st_size} {wall.st_mtime_ns}"  # existing files whose names an archive must not contain
        for name, listed in (("../../secret", state), (secret, state), ("door", state), ("nothing", state),
                             ("wall.ndf.exr/../../../secret", state), ("./wall.ndf.exr", own),
                             ("../b\u00e4ked/wall.ndf.exr", own), (os.path.join(folder, "wall.ndf.exr"), own)):
            with self.subTest(name=name):
                seal_listing(service.data, folder, f"{published}{listed} {name}\n")
                message = self.refused(409, "no_result", [], "GET", f"/v1/jobs/{made['id']}/result")
                self.assertIn(name, message)
        # The service does not send an archive if another program wrote the listing. Tests a listing without a seal, and
        # one with a forged seal.
        for forged in (published, f"{published}seal {'0' * 64}\n"):
            with open(listing, "w", encoding="utf-8") as file:
                file.write(forged)
            self.refused(409, "no_result", ["b\u00e4ked"], "GET", f"/v1/jobs/{made['id']}/result")
        seal_listing(service.data, folder, published)
        self.assertEqual(service.ask("HEAD", f"/v1/jobs/{made['id']}/result")[0], 200)
        with open(os.path.join(folder, "wall.ndf.exr"), "ab") as file:
            file.write(b"more")
        self.refused(409, "no_result", ["wall.ndf.exr"], "GET", f"/v1/jobs/{made['id']}/result")
        os.remove(listing)
        self.refused(409, "no_result", ["b\u00e4ked"], "GET", f"/v1/jobs/{made['id']}/result")

    def test_a_large_folder_takes_no_memory(self):
        service = self.start(QUICK + 'request_memory_max = "8M"\n')
        with open(self.output("scene.toml"), "w", encoding="utf-8") as file:
            file.write('[[map]]\nname = "wall"\nnormal = "q_normal.png"\n[[material]]\nname = "paint"\n'
                       'brdf = "lambert"\n[[object]]\nname = "wall"\nmap = "wall"\nmaterial = "paint"\nwidth = 2.0\n'
                       'distance = [1, 20]\n[[light]]\ndirection = [0.3, 0.8, 0.5]\n')
        subprocess.run([MULTUM, "testmap", "--size", "16", self.output("q")], check=True, capture_output=True)
        made = service.wait_for(service.submit(type="scene", parameters={"scene": self.output("scene.toml")},
                                               output=self.output("baked")))
        large = os.path.join(self.output("baked"), "large")
        with open(large, "wb") as file:
            file.truncate(200 << 20)
        folder = self.output("baked")
        seal_listing(service.data, folder,
                     f"{listed_files(folder)}{200 << 20} {os.stat(large).st_mtime_ns} large\n")
        before = resident_bytes(service.process.pid)
        with contextlib.closing(service.connection()) as connection:
            connection.request("GET", f"/v1/jobs/{made['id']}/result")
            response = connection.getresponse()
            received = 0
            while part := response.read(1 << 20):
                received += len(part)
        self.assertGreater(received, 200 << 20)
        self.assertEqual(received, int(response.headers["Content-Length"]))
        if not is_sanitized(service.process.pid):
            self.assertLess(resident_bytes(service.process.pid), before + (8 << 20))
        # If a file changes while it is being sent, the transfer does not end as if it were complete.
        with contextlib.closing(service.connection()) as connection:
            connection.request("GET", f"/v1/jobs/{made['id']}/result")
            response = connection.getresponse()
            response.read(1 << 20)
            os.utime(large)
            with self.assertRaises(http.client.IncompleteRead):
                response.read()
        # A list of files that is longer than all of the memory for requests is also refused.
        with open(os.path.join(folder, ".multum-result"), "a", encoding="utf-8") as file:
            for i in range(40000):
                file.write(f"0 0 {'name' * 12}-{i}\n")
        self.refused(503, "busy", ["files"], "GET", f"/v1/jobs/{made['id']}/result")

    def test_what_clients_leave_is_held_to_a_limit(self):
        service = self.start(QUICK + 'data_max = "100K"\n')

        def upload(size):
            with contextlib.closing(service.connection()) as connection:
                connection.request("PUT", "/v1/uploads/a.bin", os.urandom(size))
                response = connection.getresponse()
                return response.status, json.loads(response.read())

        self.assertEqual(upload(70 << 10)[0], 201)
        status, answer = upload(40 << 10)
        self.assertEqual((status, answer["error"]["code"]), (507, "quota"))
        self.assertEqual(upload(20 << 10)[0], 201)
        results = os.path.join(service.data, "results", "a.txt")
        large = os.path.join(service.data, "results", "large")
        counted_for = 5.5  # the number of seconds, plus a margin
        service.ask("POST", "/v1/queues/default/pause")
        accepted = self.drill(output=results, attempt_max=100)
        with open(large, "wb") as file:
            file.write(bytes(20 << 10))
        time.sleep(counted_for)
        self.refused(507, "quota", [], "POST", "/v1/jobs", {"type": "drill", "output": results + "x"})
        # A job that was accepted earlier waits until there is space again. Other jobs run.
        service.ask("POST", "/v1/queues/default/resume")
        service.wait_for(self.drill(output=self.output("a.txt")))
        deadline = time.monotonic() + 20
        while "data_max" not in service.job(accepted)["message"] and time.monotonic() < deadline:
            time.sleep(0.05)
        self.assertIn("data_max", service.job(accepted)["message"])
        os.remove(large)
        time.sleep(counted_for)
        self.drill(output=results + "x")
        self.assertEqual(service.wait_for(accepted)["state"], "succeeded")

    def test_a_full_disk_loses_nothing(self):
        os.mkdir(os.path.join(self.folder, "data"))
        data = os.path.join(self.folder, "data")
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m,mode=0700", "tmpfs", data], check=False,
                          capture_output=True).returncode != 0:
            self.skipTest("no file system can be mounted")
        try:
            service = self.start()
            running = self.drill(3)
            service.wait_for(running, ["running"])
            with open(os.path.join(data, "ballast"), "wb") as ballast:
                try:
                    for _ in range(64):
                        ballast.write(bytes(1 << 16))
                        ballast.flush()
                except OSError:
                    pass
            status = 201
            for _ in range(2000):  # the space that is reserved for the ledger
                status, answer = service.ask("POST", "/v1/jobs", {"type": "drill", "parameters": {"text": "x" * 900}})
                if status != 201:
                    break
            self.assertEqual((status, answer["error"]["code"]), (507, "no_space"), answer)
            self.assertIn("full", answer["error"]["message"])
            self.assertEqual(service.ask("GET", "/v1/jobs")[0], 200, "looking goes on")
            time.sleep(4)
            self.assertEqual(service.job(running)["state"], "running", "its end cannot be noted")
            os.remove(os.path.join(data, "ballast"))
            self.assertEqual(service.wait_for(running)["state"], "succeeded")
            self.assertEqual(service.stop(), 0)
        finally:
            if self.service.process.poll() is None:
                self.service.kill()
            subprocess.run(["umount", data], check=True)


if __name__ == "__main__":
    unittest.main(verbosity=2)
