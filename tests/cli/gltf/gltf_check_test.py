#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests verdicts of `multum check` about models, which depend on the model's own shape.

  gltf_check_test.py MULTUM [unittest's arguments]
"""
import json
import math
import os
import subprocess
import sys
import unittest

from folder_case import FolderCase
from model_writing import Model, bumps

MULTUM = ""
COLUMNS, WAVE = 400, 8  # columns of vertices on 2 m, and columns per wave


def board(tilt):
    """Returns a metal board of 2 x 2 m with small bumps. Its vertex normals swing by `tilt` radians, in waves of
    4 cm."""
    model = Model()
    corners, normals, tangents, coordinates, indices = [], [], [], [], []
    for column in range(COLUMNS + 1):
        x, angle = 2.0 * column / COLUMNS - 1.0, tilt * math.sin(2.0 * math.pi * column / WAVE)
        for y in (-1.0, 1.0):
            corners.append((x, y, 0.0))
            normals.append((math.sin(angle), 0.0, math.cos(angle)))
            tangents.append((math.cos(angle), 0.0, -math.sin(angle), 1.0))
            coordinates.append((0.5 * (x + 1.0), 0.5 * (1.0 - y)))
        if column < COLUMNS:
            first = 2 * column
            indices += [first, first + 2, first + 3, first, first + 3, first + 1]
    attributes = {"POSITION": model.accessor("VEC3", corners, min=[-1, -1, 0], max=[1, 1, 0]),
                  "NORMAL": model.accessor("VEC3", normals), "TANGENT": model.accessor("VEC4", tangents),
                  "TEXCOORD_0": model.accessor("VEC2", coordinates)}
    model.json["meshes"].append({"primitives": [{
        "attributes": attributes, "indices": model.accessor("SCALAR", [(i,) for i in indices], 5123), "material": 0}]})
    texture = model.texture(model.image(bumps(64, 64, steepness=0.02)))
    model.material(name="board", normalTexture={"index": texture},
                   pbrMetallicRoughness={"metallicFactor": 1.0, "roughnessFactor": 0.3})
    return model.glb()


class GltfCheckTest(FolderCase):
    def verdict(self, tilt):
        with open(self.path("board.glb"), "wb") as file:
            file.write(board(tilt))
        ran = subprocess.run([MULTUM, "check", self.path("board.glb"), "--json", "--quiet"], capture_output=True,
                             text=True, check=False)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        return json.loads(ran.stdout)["maps"][0]

    @staticmethod
    def errors(verdict, distance):
        """Returns the mean errors under sun and sky."""
        rows = [row for row in verdict["errors"] if row["distance"] == distance]
        return {form: sum(row[form] for row in rows) / len(rows) for form in ("plain", "export", "lobes")}

    def test_a_flat_board_keeps_its_mips(self):
        self.assertEqual(self.verdict(0.0)["advice"], "keep")

    def test_waves_of_the_model_gain_from_lobes(self):
        verdict = self.verdict(0.3)
        self.assertEqual(verdict["advice"], "lobes", verdict["sentence"])
        at_10_m = self.errors(verdict, 10.0)
        self.assertGreater(at_10_m["plain"], 5.0)
        self.assertLess(at_10_m["lobes"], 0.7 * at_10_m["plain"])
        self.assertGreater(at_10_m["export"], 0.8 * at_10_m["plain"])  # textures cannot help here

    def test_from_inside_the_model_a_sphere_is_seen(self):
        distances = {row["distance"] for row in self.verdict(0.3)["errors"]}
        self.assertEqual(distances, {1.0, 2.0, 5.0, 10.0, 25.0, 50.0})


if __name__ == "__main__":
    MULTUM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
