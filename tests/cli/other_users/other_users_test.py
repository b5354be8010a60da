#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests two users of one machine. One user plants links, folders and pipes where the other user bakes. The other user
must not lose a file, and no output may be redirected to another place. The test needs root to become both users.
Without root, it prints a message and is skipped (exit code 77).

  other_users_test.py MULTUM [unittest's arguments]
"""
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "gltf"))
from model_writing import Model, bumps  # noqa: E402  pylint: disable=wrong-import-position

MULTUM = ""
SKIPPED = 77
ENVIRONMENT, USAGE = 4, 2
BAKER, ATTACKER = 12345, 54321  # user ids that do not need an account
PRECIOUS = "weeks of work"


def as_user(user, function):
    """Runs a function in a child process of that user. The child's exit code shows what the function raised."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.setgroups([])
            os.setgid(user)
            os.setuid(user)
            function()
            code = 0
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    assert status == 0, f"user {user}: {function}"


def model(path):
    made = Model()
    made.square()
    made.material(name="bricks", normalTexture={"index": made.texture(made.image(bumps(16, 16)))})
    with open(path, "wb") as file:
        file.write(made.glb())


class OtherUsersTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.top = tempfile.mkdtemp(prefix="multum_users_")
        os.chmod(cls.top, 0o755)
        cls.home = os.path.join(cls.top, "home")
        os.mkdir(cls.home, 0o700)
        cls.precious = os.path.join(cls.home, "precious")
        with open(os.path.join(cls.home, "map.png"), "wb") as file:
            file.write(bumps(32, 32))
        subprocess.run([MULTUM, "bake", "map.png", "-o", "map.ndf.exr"], cwd=cls.home, check=True, capture_output=True)
        model(os.path.join(cls.home, "model.glb"))
        for entry in [cls.home] + [os.path.join(cls.home, name) for name in os.listdir(cls.home)]:
            os.chown(entry, BAKER, BAKER)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.top)

    def setUp(self):
        """Makes a folder like /tmp, and a shared folder as in studios, where everybody may rename files."""
        self.shared = {}
        for name, mode in (("sticky", 0o1777), ("open", 0o777)):
            folder = os.path.join(self.top, name)
            os.mkdir(folder)
            os.chmod(folder, mode)
            self.shared[name] = folder
        as_user(BAKER, self.make_precious)

    def tearDown(self):
        for folder in self.shared.values():
            shutil.rmtree(folder)
        shutil.rmtree(self.precious)

    def make_precious(self):
        os.mkdir(self.precious, 0o700)
        with open(os.path.join(self.precious, "thesis.txt"), "w", encoding="utf-8") as file:
            file.write(PRECIOUS)

    def run_multum(self, *arguments):
        def become_baker():
            os.setgroups([])
            os.setgid(BAKER)
            os.setuid(BAKER)
        environment = {"PATH": os.environ["PATH"], "HOME": self.home}
        for name in ("POCL_CACHE_DIR", "MULTUM_CACHE_DIR"):
            environment[name] = os.path.join(self.home, name)
        return subprocess.run([MULTUM, *arguments], capture_output=True, text=True, check=False,
                              cwd=self.home, env=environment, preexec_fn=become_baker)

    def assert_precious_is_whole(self, folder=None):
        with open(os.path.join(folder or self.precious, "thesis.txt"), encoding="utf-8") as file:
            self.assertEqual(file.read(), PRECIOUS)

    def commands(self, folder):
        """Returns command lines that keep unfinished work next to their outputs, and the name of the folder with this
        work."""
        def at(name):
            return os.path.join(folder, name)
        return [(["bake", "map.png", "-o", at("a.ndf.exr")], at(".multum-partial-a.ndf.exr")),
                (["export", "map.png", "-o", folder, "--resume"], at(".multum-partial-export")),
                (["gltf", "model.glb", "-o", at("b.glb"), "--format", "rgba8"], at(".multum-partial-b.glb")),
                (["look", "map.ndf.exr", "-o", at("c.html")], at(".multum-partial-c.html")),
                (["tradeoff", "map.png", "-o", at("d.html")], at(".multum-partial-d.html"))]

    def assert_all_refuse(self, folder, plant, word):
        for arguments, partial in self.commands(folder):
            with self.subTest(command=arguments[0], word=word):
                plant(partial)
                before = os.lstat(partial)
                run = self.run_multum(*arguments)
                self.assertEqual(run.returncode, ENVIRONMENT, run.stderr)
                self.assertIn(partial, run.stderr)
                self.assertIn(word, run.stderr)
                after = os.lstat(partial)
                self.assertEqual((before.st_ino, before.st_uid, before.st_mode), (after.st_ino, after.st_uid,
                                                                                  after.st_mode))

    def test_a_link_for_the_folder_of_unfinished_work(self):
        for folder in self.shared.values():
            self.assert_all_refuse(folder, lambda name: as_user(ATTACKER, lambda: os.symlink(self.precious, name)),
                                   "is a symbolic link")
            self.assert_precious_is_whole()

    def test_a_folder_of_the_other_user_with_links_in_it(self):
        def plant(name):
            def make():
                os.mkdir(name)
                os.chmod(name, 0o777)
                for link in ("progress", "fits", "level-0.lobes"):
                    os.symlink(os.path.join(self.precious, "thesis.txt"), os.path.join(name, link))
            as_user(ATTACKER, make)
        self.assert_all_refuse(self.shared["sticky"], plant, f"belongs to user {ATTACKER}")
        self.assert_precious_is_whole()

    def test_a_pipe_for_the_folder_of_unfinished_work(self):
        self.assert_all_refuse(self.shared["sticky"], lambda name: as_user(ATTACKER, lambda: os.mkfifo(name)),
                               "neither a file nor a folder")

    def test_a_folder_of_the_bakers_own_under_another_name(self):
        folder = self.shared["open"]
        arguments, partial = self.commands(folder)[0]
        own = os.path.join(folder, "results of May")
        as_user(BAKER, lambda: shutil.copytree(self.precious, own))
        as_user(ATTACKER, lambda: os.rename(own, partial))
        run = self.run_multum(*arguments)
        self.assertEqual(run.returncode, ENVIRONMENT, run.stderr)
        self.assertIn("did not create it", run.stderr)
        self.assert_precious_is_whole(partial)

    def test_links_at_the_outputs_name(self):
        folder = self.shared["open"]
        output = os.path.join(folder, "a.ndf.exr")
        thesis = os.path.join(self.precious, "thesis.txt")
        as_user(ATTACKER, lambda: os.symlink(thesis, output))
        run = self.run_multum("bake", "map.png", "-o", output, "--force")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertTrue(stat.S_ISREG(os.lstat(output).st_mode))
        self.assert_precious_is_whole()
        os.remove(output)
        as_user(ATTACKER, lambda: os.mkfifo(output))
        run = self.run_multum("bake", "map.png", "-o", output, "--force")
        self.assertEqual(run.returncode, USAGE, run.stderr)
        self.assertIn(output, run.stderr)

    def test_names_of_temporary_files_are_stolen_as_they_appear(self):
        """The attacking user replaces each temporary file by a link, as fast as it can read names."""
        folder = self.shared["open"]
        thesis = os.path.join(self.precious, "thesis.txt")
        thief = os.fork()
        if thief == 0:
            os.setgid(ATTACKER)
            os.setuid(ATTACKER)
            end = time.monotonic() + 60
            while time.monotonic() < end:
                for name in os.listdir(folder):
                    if not name.startswith(".multum-tmp-"):
                        continue
                    try:
                        os.rename(os.path.join(folder, name), os.path.join(folder, "stolen"))
                        os.symlink(thesis, os.path.join(folder, name))
                    except OSError:
                        pass
            os._exit(0)
        try:
            outcomes = set()
            for i in range(4):
                output = os.path.join(folder, f"{i}.ndf.exr")
                run = self.run_multum("bake", "map.png", "-o", output, "--no-measure")
                outcomes.add(run.returncode)
                self.assertIn(run.returncode, (0, ENVIRONMENT), run.stderr)
                self.assertEqual(run.returncode == 0, os.path.isfile(output) and not os.path.islink(output))
                self.assert_precious_is_whole()
        finally:
            os.kill(thief, 9)
            os.waitpid(thief, 0)
        self.assertIn(ENVIRONMENT, outcomes, "the thief was never fast enough, so nothing was tested")


if __name__ == "__main__":
    if os.geteuid() != 0:
        print("other_users_test.py: skipped: needs root, to be two users", file=sys.stderr)
        sys.exit(SKIPPED)
    MULTUM = sys.argv.pop(1)
    unittest.main()
