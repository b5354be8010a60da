# SPDX-License-Identifier: Apache-2.0
"""Contains tests that shares of scenes and shares of inference have in common. The records of shares are in
OUTPUT/shards, and merges check them."""
import hashlib
import itertools
import json
import pathlib
import shutil
import tempfile
import unittest

import farm_programs


def hashes(folder):
    """Returns the hash of each result by its name. Reports are left out, because they contain times and so differ
    between equal runs."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*"))
            if path.is_file() and not {"shards", "frames", "comparison"} & set(path.relative_to(folder).parts)
            and not path.name.startswith("report.")}


def signed(record):
    """Writes a record like a program that knows the format but not the contents of a share."""
    line = record if isinstance(record, str) else json.dumps(record)
    return f"{line}\n{hashlib.sha256(line.encode()).hexdigest()}\n"


class MergedSharesTest(unittest.TestCase):
    """A subclass sets `words`, the command to run, and makes `whole`, the results of one process."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.out = pathlib.Path(holder.name) / "out"

    def run_command(self, *more, out=None):
        return farm_programs.run(*self.words, "-o", out or self.out, *more)

    def succeed(self, *more, out=None):
        done = self.run_command(*more, out=out)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def refused(self, *parts):
        """Expects that a merge refuses with exit code 4, which may be tried again."""
        for folder in ("inferred.json", "plan.json"):
            (self.out / folder).unlink(missing_ok=True)
        done = self.run_command("--merge", 3)
        self.assertEqual(done.returncode, 4, done.stdout + done.stderr)
        for part in parts:
            self.assertIn(part, done.stderr)
        self.assertFalse((self.out / "inferred.json").exists() or (self.out / "plan.json").exists())

    def record(self, index, count=3):
        return self.out / f"shards/{index}-of-{count}.shard"

    def check_any_number_of_shares(self):
        for count, order in ((1, (1,)), (2, (2, 1, 2)), (5, (4, 2, 5, 1, 3))):
            with self.subTest(count=count):
                for index in order:
                    self.succeed("--shard", f"{index}/{count}")
                self.succeed("--merge", count)
                self.assertEqual(hashes(self.out), self.whole)
                shutil.rmtree(self.out)

    def check_damage(self, of_share_two):
        """`of_share_two` is the name of a result that share 2 of 3 makes."""
        for index in (1, 3):
            self.succeed("--shard", f"{index}/3")
        self.refused("2-of-3.shard: is missing: --shard 2/3 makes it again")
        self.assertIn("written", self.succeed("--shard", "2/3"))
        times = {path: path.stat().st_mtime_ns for path in self.out.rglob("*") if path.is_file()}
        self.assertNotIn("written", self.succeed("--shard", "1-3/3"))
        self.assertEqual(times, {path: path.stat().st_mtime_ns for path in self.out.rglob("*") if path.is_file()})
        result = self.out / of_share_two
        whole = result.read_bytes()
        damaged = bytearray(whole)
        damaged[len(damaged) * 2 // 3] ^= 1
        for bytes_there in (bytes(damaged), None):
            if bytes_there is None:
                result.unlink()
            else:
                result.write_bytes(bytes_there)
            self.refused(of_share_two, "--shard 2/3 makes it again")
            self.assertIn("written", self.succeed("--shard", "2/3"))
            self.assertEqual(result.read_bytes(), whole)
            others = {path: path.stat().st_mtime_ns for path in times
                      if path.exists() and path != result and path != self.record(2) and path.suffix != ".json"}
            self.assertEqual(others, {path: times[path] for path in others})  # no other result was made a second time
        for _ in range(2):  # merges twice, because a farm may repeat the merge
            self.succeed("--merge", 3)
            self.assertEqual(hashes(self.out), self.whole)

    def hostile_records(self, index):
        """Returns texts that are not valid records of share `index` of 3. The valid record of this share exists."""
        good = self.record(index).read_text()
        line, _ = good.splitlines()
        self.assertEqual(signed(line), good)  # so that checks other than the hash check refuse the share
        record = json.loads(line)
        content = record["content"]
        texts = ["", "{", good[:len(good) // 2], good + "\n", signed(""), signed("[" * 100000), signed("\x00" * 64),
                 good.replace(f'"share":{index}', '"share":4'), *(signed({**record, **change}) for change in (
                     {"share": 4}, {"of": 4}, {"kind": "scenery"}, {"multumShare": 2}, {"key": "0" * 64}, {"key": 7},
                     {"content": []}, {"content": {}}))]
        for name, value in content.items():
            others = {key: one for key, one in content.items() if key != name}
            wrong = [None] * len(value) if isinstance(value, list) and value else {"a": "b"}
            texts.append(signed({**record, "content": {**others, name: wrong}}))
        return texts + [signed({**record, "content": {**content, name: value}})
                        for name, value in self.hostile(content)]

    def check_hostile_records(self):
        self.succeed("--shard", "1-3/3")
        # Each share has a third of these faults. A merge names every fault.
        thirds = [self.hostile_records(index)[index - 1::3] for index in (1, 2, 3)]
        for texts in itertools.zip_longest(*thirds, fillvalue=""):
            with self.subTest(texts=[text[:200] for text in texts]):
                for index, text in enumerate(texts, 1):
                    self.record(index).write_text(text)
                self.refused(*(part.format(index) for index in (1, 2, 3)
                               for part in ("{}-of-3.shard", "--shard {}/3 makes it again")))
        path = self.record(2)
        path.unlink()
        path.mkdir()
        self.refused("2-of-3.shard", "--shard 2/3 makes it again")
        path.rmdir()
        self.assertIn("written", self.succeed("--shard", "1-3/3"))
        self.succeed("--merge", 3)
        self.assertEqual(hashes(self.out), self.whole)

    def check_refusals(self):
        for more, part in ((("--shard", "0/3"), "expected I/N"), (("--shard", "1/5000"), "at most 4096 shares"),
                           (("--shard", "1/3", "--merge", "3"), "mutually exclusive"), (("--merge", "0"), "--merge")):
            done = self.run_command(*more)
            self.assertEqual(done.returncode, 2, more)
            self.assertIn(part, done.stderr)
        self.assertFalse((self.out / "shards").exists())
