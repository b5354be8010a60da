#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kills every writing command at some moments (kill -9), runs it on a disk that becomes full, and runs the daemon on
such a disk. No complete output may be lost, no half-written file may have the name of an output, the next run must
write the same bytes, and no hidden file may remain after it. The full disks are small file systems in memory, which
only root may mount. For other users, these tests are skipped with a message.

  kills_and_disks_test.py MULTUM [unittest's arguments]

With MULTUM_SWEEPS=all, kills each command at eight moments and fills six disks; the default is one of each.
limit_sweep_test.cpp tests `ulimit`.
"""
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, "..", "gltf"), os.path.join(HERE, "..", "..", "service")]
from model_writing import Model, bumps  # noqa: E402  pylint: disable=wrong-import-position
from service_harness import Service  # noqa: E402  pylint: disable=wrong-import-position
from tiny_animation import write_animation  # noqa: E402  pylint: disable=wrong-import-position

MULTUM = ""
IS_ALL = os.environ.get("MULTUM_SWEEPS") == "all"
ENVIRONMENT = 4
SKIPPED = 77


def contents(folder):
    """Returns the SHA-256 of every file in the folder by its name. Reports contain times, so only their names are
    compared."""
    found = {}
    for above, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(above, name)
            with open(path, "rb") as file:
                data = file.read()
            is_report = name.endswith((".json", ".html"))
            found[os.path.relpath(path, folder)] = "report" if is_report else hashlib.sha256(data).hexdigest()
    return found


class SweepTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.top = tempfile.mkdtemp(prefix="multum_sweep_")
        cls.out = os.path.join(cls.top, "out")
        cls.write("map.png", bumps(64, 64))
        cls.write("other.png", bumps(32, 64))
        model = Model()
        model.square()
        model.material(name="bricks", normalTexture={"index": model.texture(model.image(bumps(32, 32)))})
        cls.write("model.glb", model.glb())
        os.mkdir(os.path.join(cls.top, "renders"))
        write_animation(os.path.join(cls.top, "renders"), 0.5, noise=0.2)
        subprocess.run([MULTUM, "bake", "map.png", "-o", "lobes.ndf.exr", "-q"], cwd=cls.top, check=True)
        subprocess.run([MULTUM, "infer", "renders/animation.toml", "-o", "inferred", "-q"], cwd=cls.top, check=True)

    @classmethod
    def write(cls, name, data):
        with open(os.path.join(cls.top, name), "wb") as file:
            file.write(data)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.top)

    def setUp(self):
        os.mkdir(self.out)

    def tearDown(self):
        shutil.rmtree(self.out)

    def commands(self):
        """Returns commands that write into the folder out. Their second run continues or begins again."""
        farm = [["openjd", "-o", "out/a", "bake", "map.png", "-o", "b.ndf.exr"]]
        if self.run_multum(["openjd", "--help"]).returncode != 0:
            farm = []  # a build without the command
        return [["bake", "map.png", "-o", "out/a.ndf.exr", "--report", "out/a.json"],
                ["bake", "map.png", "-o", "out/a.ndf.exr", "--ndf", "sh"],
                ["bake", "map.png", "other.png", "-o", "out"],
                ["export", "map.png", "-o", "out/a", "--resume"],
                ["export", "map.png", "-o", "out/a", "--format", "ktx2", "--zstd", "3"],
                ["gltf", "model.glb", "-o", "out/a.glb", "--format", "rgba8"],
                ["mip", "map.png", "-o", "out/a.exr"],
                ["testmap", "out/a", "--size", "64"],
                ["look", "lobes.ndf.exr", "-o", "out/a.html"],
                ["shaders", "-o", "out/a"],
                *farm,
                ["infer", "renders/animation.toml", "-o", "out/a"],
                ["pack", "inferred", "-o", "out/a.mpt", "--ratio", "1", "--resume"]]

    def run_multum(self, arguments, wrapped=()):
        return subprocess.run([*wrapped, MULTUM, *arguments], cwd=self.top, capture_output=True, text=True, check=False)

    def reset(self):
        shutil.rmtree(self.out)
        os.mkdir(self.out)

    def assert_whole(self, expected, where=None):
        """Checks that every file with the name of an output is complete."""
        for name, digest in contents(where or self.out).items():
            if not any(part.startswith(".") for part in name.split("/")):
                self.assertEqual(digest, expected.get(name), name)

    def wait_for_group(self, group):
        """Waits for helper processes. They end soon after the process that started them, and keep their work folders
        until
            then."""
        end = time.monotonic() + 20
        while time.monotonic() < end:
            try:
                os.killpg(group, 0)
            except ProcessLookupError:
                return
            time.sleep(0.01)
        self.fail("a helper still runs 20 s after its parent has ended")

    def test_kills(self):
        for i, arguments in enumerate(self.commands()):
            moments = [j / 9 for j in range(1, 9)] if IS_ALL else [(0.5, 0.9)[i % 2]]
            self.reset()
            begin = time.monotonic()
            run = self.run_multum(arguments)
            seconds = time.monotonic() - begin
            self.assertEqual(run.returncode, 0, run.stderr)
            expected = contents(self.out)
            for moment in moments:
                with self.subTest(command=arguments, moment=moment):
                    self.reset()
                    process = subprocess.Popen([MULTUM, *arguments], cwd=self.top, stdout=subprocess.DEVNULL,
                                               stderr=subprocess.DEVNULL, start_new_session=True)
                    time.sleep(moment * seconds)
                    process.kill()
                    process.wait()
                    self.wait_for_group(process.pid)
                    self.assert_whole(expected)
                    again = self.run_multum(arguments)
                    self.assertEqual(again.returncode, 0, again.stderr)
                    self.assertEqual(contents(self.out), expected)

    def test_what_kills_left_where_all_is_done(self):
        """A run that finds its filter matrices already measured removes the work folder that a kill left next to
        them."""
        [arguments] = [words for words in self.commands() if words[0] == "infer"]
        self.reset()
        run = self.run_multum(arguments)
        self.assertEqual(run.returncode, 0, run.stderr)
        expected = contents(self.out)
        folders = {os.path.dirname(name) for name in expected if name.endswith(".fmx")}
        self.assertGreater(len(folders), 1)
        for folder in folders:
            left = os.path.join(self.out, folder, ".multum-work-0123456789abcdef")
            os.mkdir(left, 0o700)
            for name in (".multum-folder", "request.probe.json"):
                with open(os.path.join(left, name), "w", encoding="utf-8"):
                    pass
        again = self.run_multum(arguments)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(contents(self.out), expected)

    def disk(self, kibibytes):
        """Returns words that are put before a command and mount a disk of that size at out. The remaining files are
        copied to left."""
        script = ('mount -t tmpfs -o size="$1"k,mode=0755 tmpfs out && shift && status=0 && { "$@" || status=$?; } && '
                  'cp -a out/. left && exit $status')
        return ["unshare", "-m", "bash", "-c", "mount --make-rprivate / && " + script, "bash", str(kibibytes)]

    def can_mount(self):
        left = os.path.join(self.top, "left")
        os.makedirs(left, exist_ok=True)
        probe = subprocess.run([*self.disk(64), "true"], cwd=self.top, capture_output=True, text=True, check=False)
        return probe.returncode == 0

    def test_full_disks(self):
        if not self.can_mount():
            self.skipTest("no file system can be mounted here: needs root")
        left = os.path.join(self.top, "left")
        for i, arguments in enumerate(self.commands()):
            self.reset()
            run = self.run_multum(arguments)
            self.assertEqual(run.returncode, 0, run.stderr)
            expected = contents(self.out)
            size = sum(os.path.getsize(os.path.join(self.out, name)) for name in expected)
            for share in ([0.05, 0.2, 0.4, 0.6, 0.8, 0.95] if IS_ALL else [(0.2, 0.8)[i % 2]]):
                kibibytes = max(4, int(share * size / 1024) // 4 * 4)
                with self.subTest(command=arguments, kibibytes=kibibytes):
                    self.reset()
                    shutil.rmtree(left)
                    os.mkdir(left)
                    run = self.run_multum(arguments, self.disk(kibibytes))
                    self.assertIn(run.returncode, (0, ENVIRONMENT), run.stderr)
                    if run.returncode != 0:
                        self.assertIn("No space left on device", run.stderr)
                    self.assert_whole(expected, left)
                    hidden = [name for name in contents(left) if os.path.basename(name).startswith(".multum-tmp-")]
                    self.assertEqual(hidden, [])

    def test_the_daemon_on_a_full_disk(self):
        if not self.can_mount():
            self.skipTest("no file system can be mounted here: needs root")
        service = Service(MULTUM, self.top)
        os.mkdir(service.data)
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1M,mode=0700", "tmpfs", service.data], check=True)
        try:
            service.start()
            connection = service.connection()
            connection.request("PUT", "/v1/uploads/large.png", bytes(4 << 20))
            response = connection.getresponse()
            self.assertEqual(response.status, 507, response.read())
            connection.close()
            small = os.path.join(service.root, "map.png")
            shutil.copy(os.path.join(self.top, "map.png"), small)
            for number in range(20):  # logs, ledger and pictures notice the full disk at different moments
                with open(os.path.join(service.data, "filler"), "ab") as filler:
                    try:
                        filler.write(bytes(1 << 20))
                    except OSError:
                        pass
                status, _ = service.ask("POST", "/v1/jobs", {
                    "type": "bake", "parameters": {"input": small},
                    "output": os.path.join(service.root, f"{number}.ndf.exr")})
                self.assertIn(status, (201, 503, 507), status)
            self.assertEqual(service.ask("GET", "/healthz")[0], 200)
            os.remove(os.path.join(service.data, "filler"))
            status, job = service.ask("POST", "/v1/jobs", {
                "type": "bake", "parameters": {"input": small}, "output": os.path.join(service.root, "last.ndf.exr")})
            self.assertEqual(status, 201, job)
            deadline = time.monotonic() + 120
            while not os.path.exists(os.path.join(service.root, "last.ndf.exr")):
                self.assertLess(time.monotonic(), deadline, service.log_text()[-2000:])
                time.sleep(0.1)
            self.assertEqual(service.stop(), 0)
        finally:
            service.end(service.process)
            subprocess.run(["umount", "-l", service.data], check=False)


if __name__ == "__main__":
    MULTUM = sys.argv.pop(1)
    unittest.main()
