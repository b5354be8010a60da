#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests multum on render farms. Checks job bundles of Open Job Description with the published schema and runs them as
the specification says. They must give the same files as without a farm. Also tests shares of several maps, and exit
codes.

  tests/cli/farms/openjd_test.py --programs FOLDER --traced-folder PROGRAM
"""
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import farm_programs
import jsonschema
import merged_shares
import openjd_schema
import yaml
from farm_programs import run
from openjd_runner import Bundle, loaded

ROOT = pathlib.Path(__file__).resolve().parents[3]
traced_folder = sys.argv.index("--traced-folder")
TRACED_FOLDER = sys.argv[traced_folder + 1]
del sys.argv[traced_folder:traced_folder + 2]


def contents(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("*.ndf.exr"))}


class FarmTest(unittest.TestCase):
    maps = 5

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        for i in range(self.maps):
            self.succeed("testmap", self.folder / f"rock_{1001 + i}", "--size", 32, "--seed", i + 1)
            (self.folder / f"rock_{1001 + i}_normal.png").rename(self.folder / f"rock_{1001 + i}.png")
        lines = [f'[[map]]\ninput = "rock_{1001 + i}.png"\noutput = "out/rock_{1001 + i}.ndf.exr"\n'
                 for i in range(self.maps)]
        (self.folder / "out").mkdir()
        self.manifest = self.folder / "maps.toml"
        self.manifest.write_text("[defaults]\nlobes = 2\n\n" + "\n".join(lines))

    def succeed(self, *words):
        done = run(*words)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def baked_here(self):
        """Returns the results for the maps of the manifest without a farm."""
        self.succeed("bake", "--manifest", self.manifest)
        there = contents(self.folder / "out")
        self.assertEqual(len(there), self.maps)
        shutil.rmtree(self.folder / "out")
        (self.folder / "out").mkdir()
        return there

    def bundle(self, *words):
        folder = self.folder / "bundle"
        done = self.succeed("openjd", "-o", folder, *words)
        for name, schema in (("template", openjd_schema.TEMPLATE), ("parameter_values", openjd_schema.VALUES),
                             ("asset_references", openjd_schema.ASSETS)):
            jsonschema.validate(loaded(folder / f"{name}.yaml"), schema)
        bundle = Bundle(folder)
        bundle.set("Multum", str(farm_programs.multum()))
        return bundle, done.stdout


class SharesTest(FarmTest):
    def test_shares_make_what_one_run_makes(self):
        whole = self.baked_here()
        for share in ("3/3", "1/3", "2/3", "1/3"):  # runs the tasks in any order, and one of them twice
            self.succeed("bake", "--manifest", self.manifest, "--shard", share)
        self.assertEqual(contents(self.folder / "out"), whole)

    def test_a_share_bakes_its_own_maps_alone(self):
        self.succeed("bake", "--manifest", self.manifest, "--shard", "2/3")
        self.assertEqual(set(contents(self.folder / "out")), {"rock_1002.ndf.exr", "rock_1005.ndf.exr"})
        self.succeed("bake", "--manifest", self.manifest, "--shard", "6/9")  # more shares than maps
        self.assertEqual(len(contents(self.folder / "out")), 2)

    def test_shares_of_a_set(self):
        out = f"{self.folder}/out/<UDIM>.ndf.exr"
        self.succeed("bake", f"{self.folder}/rock_<UDIM>.png", "-o", out, "--lobes", 2, "--shard", "1-2/4")
        self.assertEqual(set(contents(self.folder / "out")), {"1001.ndf.exr", "1002.ndf.exr", "1005.ndf.exr"})

    def test_refusals(self):
        for share in ("0/3", "4/3", "2-1/3", "1/0", "a", "1/3/5", "-1/3"):
            done = run("bake", "--manifest", self.manifest, f"--shard={share}")
            self.assertEqual(done.returncode, 2, share)
            self.assertIn("expected I/N", done.stderr)


class BundleTest(FarmTest):
    def test_a_manifest_is_run_to_the_same_files(self):
        whole = self.baked_here()
        bundle, said = self.bundle("bake", "--manifest", self.manifest)
        self.assertIn("5 tasks", said)
        self.assertEqual(bundle.assets["inputs"]["filenames"], sorted(
            [str(self.manifest), *[str(self.folder / f"rock_{1001 + i}.png") for i in range(self.maps)]]))
        self.assertEqual(bundle.assets["outputs"]["directories"], [str(self.folder / "out")])
        tasks = bundle.run(chunk_size=2, again=[{"Task.Param.Shard": "3-4"}], order=lambda tasks: tasks[::-1])
        self.assertEqual([(task.values["Task.Param.Shard"], task.code) for task in tasks],
                         [("5", 0), ("3-4", 0), ("3-4", 0), ("1-2", 0)])
        self.assertEqual(contents(self.folder / "out"), whole)
        for task in tasks:
            self.assertEqual(task.progress, sorted(task.progress))
            self.assertEqual(task.progress[-1], 100)
            self.assertFalse(task.failures)
        first = tasks[0]
        self.assertGreater(len(first.progress), 1)
        self.assertTrue(any(status.startswith("read ") for status in first.statuses))

    def test_maps_by_name(self):
        maps = [self.folder / f"rock_{1001 + i}.png" for i in range(3)]
        bundle, _ = self.bundle("--shards", 2, "--name", "rocks", "bake", *maps, "-o", self.folder / "out", "--lobes=2")
        self.assertEqual(bundle.template["name"], "rocks")
        self.assertEqual([one["dataFlow"] for one in bundle.template["parameterDefinitions"] if one["type"] == "PATH"],
                         ["IN", "IN", "IN", "OUT"])
        self.assertEqual([task.code for task in bundle.run()], [0, 0])
        self.assertEqual(set(contents(self.folder / "out")), {f"rock_{1001 + i}.ndf.exr" for i in range(3)})

    def test_one_map_in_bands(self):
        self.succeed("testmap", self.folder / "one", "--size", 256)
        map_file, output = self.folder / "one_normal.png", self.folder / "out/one.ndf.exr"
        whole = self.folder / "whole.ndf.exr"
        self.succeed("bake", map_file, "-o", whole)
        bundle, said = self.bundle("--shards", 3, "bake", map_file, "-o", output)
        self.assertIn("5 tasks, 1 input file", said)
        self.assertNotIn("extensions", bundle.template)
        tasks = bundle.run(order=lambda tasks: tasks[::-1])
        self.assertEqual([(task.values.get("Task.Param.Shard"), task.code) for task in tasks],
                         [(None, 0), ("3", 0), ("2", 0), ("1", 0), (None, 0)])
        self.assertEqual(output.read_bytes(), whole.read_bytes())
        self.assertEqual(len(list((self.folder / "out").iterdir())), 1)

    def test_files_that_a_farm_puts_elsewhere(self):
        bundle, _ = self.bundle("bake", self.folder / "rock_1001.png", "-o", self.folder / "out/a.ndf.exr", "--lobes",
                                "2", "--roughness", f"{self.folder / 'rock_1002.png'}:R")
        self.assertNotIn("parameterSpace", bundle.template["steps"][0])
        elsewhere = self.folder / "worker"
        elsewhere.mkdir()
        for name, file in (("Input", "rock_1001.png"), ("Input2", "rock_1002.png")):
            (self.folder / file).rename(elsewhere / file)
            bundle.set(name, str(elsewhere / file))
        bundle.set("Output", str(elsewhere / "a.ndf.exr"))
        [task] = bundle.run()
        self.assertEqual(task.code, 0, task.text)
        self.assertTrue((elsewhere / "a.ndf.exr").exists())

    def test_a_failure_is_told(self):
        bundle, _ = self.bundle("bake", "--manifest", self.manifest)
        (self.folder / "rock_1002.png").write_bytes(b"no picture")
        tasks = bundle.run()
        self.assertEqual([task.code for task in tasks], [0, 3, 0, 0, 0])
        self.assertEqual(tasks[1].failures, ["exit code 3; stderr says why"])
        bundle, _ = self.bundle("bake", self.folder / "rock_1002.png", "-o", self.folder / "a.ndf.exr")
        [task] = bundle.run()
        self.assertEqual(task.code, 3)
        self.assertEqual(len(task.failures), 1)
        self.assertIn("rock_1002.png", task.failures[0])

    def test_a_canceled_task_goes_on_where_it_stopped(self):
        # This task takes some seconds and prints one line per second.
        self.succeed("testmap", self.folder / "large", "--size", 2048)
        file = self.folder / "out/large.ndf.exr"
        bundle, _ = self.bundle("bake", self.folder / "large_normal.png", "-o", file)
        [step] = bundle.steps()
        task = bundle.run_task(step, {}, cancel_at=1)
        self.assertEqual(task.code, 130, task.text)
        self.assertFalse(file.exists())
        self.assertEqual(bundle.run_task(step, {}).code, 0)
        resumed = contents(self.folder / "out")
        self.succeed("bake", self.folder / "large_normal.png", "-o", file, "--force")
        self.assertEqual(contents(self.folder / "out"), resumed)

    def test_refusals(self):
        rock = self.folder / "rock_1001.png"
        for words, expected in ((("bake", rock), "found no --output"),
                                (("--shards", 2, "bake", rock, "-o", "a.ndf.exr", "--refine"), "--refine"),
                                (("--shards", 2, "bake", rock, "-o", "a.ndf.exr", "--ndf=sh"), "at least two lobes"),
                                (("serve",), "cannot run on a farm"),
                                (("bake", "--manifest", self.manifest, "--lobos", 3), "--lobos"),
                                (("bake", "--manifest", self.manifest, "--shard", "1/2"), "--shards N before bake"),
                                (("bake", self.folder / "rock_1001.png", "-o", "a.exr", "--merge", 2), "--shards N"),
                                (("--shards", 6, "bake", "--manifest", self.manifest), "at most 5"),
                                (("info", self.folder / "rock_1001.png"), "cannot run on a farm"),
                                (("bakery",), "bakery"), ((), "found no command")):
            done = run("openjd", "-o", self.folder / "bundle", *words)
            self.assertEqual(done.returncode, 2, words)
            self.assertIn(expected, done.stderr)
            self.assertFalse((self.folder / "bundle").exists())
        for words in (("bake", self.folder / "none.png", "-o", "a.ndf.exr"), ("pack", "none", "-o", "a.mpt")):
            done = run("openjd", "-o", self.folder / "bundle", *words)
            self.assertEqual(done.returncode, 3, words)
            self.assertIn("does not exist", done.stderr)
            self.assertFalse((self.folder / "bundle").exists())

    def copies(self, count):
        """Writes maps with names of their own."""
        maps = [self.folder / f"m{100 + i}.png" for i in range(count)]
        for one in maps:
            one.hardlink_to(self.folder / "rock_1001.png")
        return maps

    def refused(self, expected, *words):
        done = run("openjd", "-o", self.folder / "bundle", *words)
        self.assertEqual(done.returncode, 2, (words, done.stderr))
        self.assertIn(expected, done.stderr)
        self.assertFalse((self.folder / "bundle").exists())

    def test_parameters_are_fifty_at_most(self):
        maps = self.copies(60)
        bundle, _ = self.bundle("bake", *maps[:48], "-o", self.folder / "out")
        self.assertEqual(len(bundle.template["parameterDefinitions"]), 50)
        shutil.rmtree(self.folder / "bundle")
        for count in (49, 60):
            self.refused("--manifest", "bake", *maps[:count], "-o", self.folder / "out")
            self.refused("expected at most 49", "export", *maps[:count], "-o", self.folder / "out")
        self.refused("expected at most 49", "bake", *maps[:47], "-o", self.folder / "out", "--roughness", maps[50],
                     "--albedo", maps[51])
        # The suggested number of chunks has no limit.
        self.manifest.write_text("".join(f'[[map]]\ninput = "{one.name}"\noutput = "out/{one.stem}.ndf.exr"\n'
                                         for one in maps))
        bundle, said = self.bundle("bake", "--manifest", self.manifest)
        self.assertIn("60 tasks", said)
        self.assertEqual(len(bundle.template["parameterDefinitions"]), 2)
        self.assertEqual(len(bundle.assets["inputs"]["filenames"]), 61)

    def test_names(self):
        rock = self.folder / "rock_1001.png"
        bundle, _ = self.bundle("--name", "\u00e9" * 128, "bake", rock, "-o", self.folder / "a.ndf.exr")
        self.assertEqual(bundle.template["name"], "\u00e9" * 128)
        shutil.rmtree(self.folder / "bundle")
        words = ("bake", self.folder / "rock_1002.png", "-o", self.folder / "a.ndf.exr")
        self.refused("has 129 characters, expected at most 128", "--name", "x" * 129, *words)
        for control in ("\x85", "\x7f", "\t", "\n", "\x9b"):
            name = f"control character U+{ord(control):04X}"
            self.refused(name, "--name", f"a{control}b", *words)
            rock = rock.rename(self.folder / f"rock{control}.png")
            self.refused(name, "bake", rock, "-o", self.folder / "a.ndf.exr")
            self.refused(name, "bake", self.folder / "rock_1002.png", "-o", self.folder / f"a{control}.ndf.exr")
        self.refused("rock_{{1}}.png", "bake", self.folder / "rock_1002.png", "-o", self.folder / "rock_{{1}}.png")
        deep = self.folder / "/".join(["d" * 200] * 5)
        deep.mkdir(parents=True)
        self.refused("expected at most 1024", "bake", self.folder / "rock_1002.png", "-o", deep / "a.ndf.exr")

    def test_names_that_are_not_utf_8(self):
        folder = os.fsencode(self.folder)
        odd = folder + b"/rock_\xff.png"
        os.rename(folder + b"/rock_1001.png", odd)
        for words in (("bake", odd, "-o", folder + b"/a.ndf.exr"),
                      ("bake", folder + b"/rock_1002.png", "-o", folder + b"/\xc3.ndf.exr"),
                      ("--name", b"\xff", "bake", folder + b"/rock_1002.png", "-o", folder + b"/a.ndf.exr")):
            done = subprocess.run([farm_programs.multum(), "openjd", "-o", self.folder / "bundle", *words],
                                  capture_output=True, check=False)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(b"is not UTF-8", done.stderr)
            self.assertFalse((self.folder / "bundle").exists())
        # The name of a tile in a tile set is also refused if it is not valid UTF-8.
        os.rename(odd, folder + b"/o\xff_1001.png")
        self.assertEqual(subprocess.run(
            [farm_programs.multum(), "openjd", "-o", self.folder / "bundle", "bake", folder + b"/o\xff_<UDIM>.png",
             "-o", folder + b"/<UDIM>.ndf.exr"], capture_output=True, check=False).returncode, 2)

    def test_a_set_that_lies_here(self):
        done = subprocess.run([farm_programs.multum(), "openjd", "-o", "bundle", "--shards", "2", "bake",
                               "rock_<UDIM>.png", "-o", "<UDIM>.ndf.exr"],
                              capture_output=True, text=True, check=False, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("2 tasks, 5 input files", done.stdout)
        bundle = Bundle(self.folder / "bundle")
        bundle.set("Multum", str(farm_programs.multum()))
        self.assertEqual([bundle.values[f"Param.{name}"] for name in ("Input", "Output")], [str(self.folder)] * 2)
        self.assertEqual([task.code for task in bundle.run()], [0, 0])
        self.assertEqual(len(contents(self.folder)), self.maps)

    def test_the_schema_refuses_what_is_none(self):
        good, _ = self.bundle("bake", "--manifest", self.manifest)
        for change in (lambda t: t.pop("steps"), lambda t: t.update(specificationVersion="jobtemplate-2024-01"),
                       lambda t: t.update(more=1), lambda t: t["parameterDefinitions"][0].update(objectType="file"),
                       lambda t: t["steps"][0]["script"]["actions"]["onRun"].pop("command")):
            template = yaml.safe_load(yaml.safe_dump(good.template))
            change(template)
            with self.assertRaises(jsonschema.ValidationError):
                jsonschema.validate(template, openjd_schema.TEMPLATE)


class MergedBundleTest(FarmTest):
    """Runs shares and then a merge. If chunks run in any order and one of them runs twice, the files must equal those
    of one process."""
    maps = 3

    def check(self, words, shards):
        self.succeed(*words, "-o", self.folder / "whole")
        bundle, said = self.bundle("--shards", shards, *words, "-o", self.folder / "out")
        self.assertIn(f"{shards + 1} tasks", said)
        self.assertEqual([step["name"] for step in bundle.steps()], ["Shares", "Merge"])
        tasks = bundle.run(chunk_size=2, again=[{"Task.Param.Shard": "1-2"}], order=lambda tasks: tasks[::-1])
        self.assertEqual([(task.values.get("Task.Param.Shard"), task.code) for task in tasks],
                         [("3", 0), ("1-2", 0), ("1-2", 0), (None, 0)], [task.text for task in tasks])
        for task in tasks:
            self.assertEqual(task.progress[-1], 100)
        self.assertEqual(merged_shares.hashes(self.folder / "out"), merged_shares.hashes(self.folder / "whole"))
        return bundle

    def test_a_scene(self):
        scene = self.folder / "scene.toml"
        scene.write_text('[camera]\nresolution = [96, 72]\n[[light]]\ndirection = [0.3, 0.8, 0.5]\n'
                         '[[material]]\nname = "paint"\nbrdf = "blinn-phong"\nexponent = 100\n' + "".join(
                             f'[[map]]\nname = "m{i}"\nnormal = "rock_{1001 + i}.png"\n[[object]]\nname = "o{i}"\n'
                             f'map = "m{i}"\nmaterial = "paint"\nwidth = 2.0\ndistance = [0.4, 20]\n'
                             for i in range(self.maps)))
        bundle = self.check(("bake", scene), 3)
        self.assertEqual(bundle.assets["inputs"]["filenames"], sorted(
            [str(scene), *[str(self.folder / f"rock_{1001 + i}.png") for i in range(self.maps)]]))
        self.assertEqual(bundle.assets["outputs"]["directories"], [str(self.folder / "out")])

    def test_inference(self):
        (self.folder / "renders").mkdir()
        subprocess.run([TRACED_FOLDER, self.folder / "renders", "2", "1"], check=True)
        self.succeed("animation", self.folder / "renders", "-o", self.folder / "animation.toml")
        self.check(("infer", self.folder / "animation.toml", "--context", "osmesa", "--no-frames", "--no-comparison",
                    "--absolute-geometry"), 3)


class DocumentTest(unittest.TestCase):
    """Compares the Kubernetes example in docs/how-to/clusters.md with the API reference for batch/v1 Jobs."""

    def test_the_indexed_job(self):
        text = (ROOT / "docs/how-to/clusters.md").read_text()
        [block] = re.findall(r"^```yaml\n(apiVersion: batch/v1\n.*?)^```", text, re.MULTILINE | re.DOTALL)
        job = yaml.safe_load(block)
        closed = openjd_schema.closed
        text_of = {"type": "string", "minLength": 1}
        count = {"type": "integer", "minimum": 1}
        rule = closed({"action": {"enum": ["FailJob", "FailIndex", "Ignore", "Count"]}},
                      onExitCodes=closed({"operator": {"enum": ["In", "NotIn"]},
                                          "values": {"type": "array", "minItems": 1, "items": {"type": "integer"}}}),
                      onPodConditions={"type": "array", "items": closed({"type": text_of}, status=text_of)})
        container = closed({"name": text_of, "image": text_of}, command={"type": "array", "items": text_of},
                           args={"type": "array", "items": text_of}, volumeMounts={"type": "array", "items": closed(
                               {"name": text_of, "mountPath": {"type": "string", "pattern": "^/"}})})
        pod = closed({"restartPolicy": {"const": "Never"},  # needed by podFailurePolicy
                      "containers": {"type": "array", "minItems": 1, "items": container}},
                     terminationGracePeriodSeconds={"type": "integer", "minimum": 30},
                     volumes={"type": "array", "items": closed({"name": text_of}, persistentVolumeClaim=closed(
                         {"claimName": text_of}))})
        jsonschema.validate(job, closed(
            {"apiVersion": {"const": "batch/v1"}, "kind": {"const": "Job"}, "metadata": closed({"name": text_of}),
             "spec": closed({"template": closed({"spec": pod})}, completions=count, parallelism=count,
                            completionMode={"const": "Indexed"}, backoffLimitPerIndex=count,
                            podFailurePolicy=closed({"rules": {"type": "array", "minItems": 1, "items": rule}}))}))
        [container] = job["spec"]["template"]["spec"]["containers"]
        self.assertIn(f"/{job['spec']['completions']} ", container["args"][-1] + " ")
        self.assertEqual(job["spec"]["podFailurePolicy"]["rules"][0]["onExitCodes"]["values"], [2, 3, 5])


if __name__ == "__main__":
    farm_programs.main()
