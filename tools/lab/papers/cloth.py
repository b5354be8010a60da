# SPDX-License-Identifier: Apache-2.0
"""Simulates a square of cloth that falls on a sphere (Han et al. 2007, fig. 5) by position-based dynamics (Müller et
al. 2007).

Each step restores the distances between neighbours (threads), diagonals (shear) and second neighbours (bending).
Constraints are divided into sets without common vertices, and one set is solved after the other. The sphere has a
radius of 0.6, and the cloth measures 2 x 2 units.
"""
import numpy as np

SIDE, WIDTH, RADIUS, FLOOR = 65, 2.0, 0.6, -0.6
SECONDS_A_STEP, ITERATIONS, THICKNESS, DAMPING = 1.0 / 120.0, 24, 0.012, 0.995
GRAVITY = np.array([0.0, 0.0, -9.81])


def constraint_sets():
    """Lists (first vertices, second vertices, rest length, stiffness). No vertex appears twice within one entry."""
    index = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    spacing = WIDTH / (SIDE - 1)
    sets = []
    for rows, columns, stiffness in ((0, 1, 1.0), (1, 0, 1.0), (1, 1, 0.5), (1, -1, 0.5), (0, 2, 0.15), (2, 0, 0.15)):
        first = index[:SIDE - rows, max(0, -columns):SIDE - max(0, columns)]
        second = index[rows:, max(0, columns):SIDE + min(0, columns)]
        # successive pairs along the direction of the constraint share a vertex, so each set contains every other pair
        place = np.arange(first.shape[0])[:, None] // rows if rows else np.arange(first.shape[1])[None, :] // columns
        odd = np.broadcast_to(place % 2 == 1, first.shape)
        rest = spacing * np.hypot(rows, columns)
        sets += [(first[chosen], second[chosen], rest, stiffness) for chosen in (~odd, odd)]
    return sets


def drape(steps):
    """Yields positions [SIDE, SIDE, 3] at each of `steps`, which are in ascending order."""
    along = np.linspace(-WIDTH / 2, WIDTH / 2, SIDE)
    # the cloth is slightly rotated, so that its folds are not symmetric
    here = np.dstack([np.broadcast_to(along[None, :], (SIDE, SIDE)), np.broadcast_to(along[:, None], (SIDE, SIDE)),
                      RADIUS + 0.05 + 0.01 * np.sin(3 * along[None, :] + 1) * np.cos(2 * along[:, None])])
    here, before = here.reshape(-1, 3).copy(), here.reshape(-1, 3).copy()
    sets, wanted = constraint_sets(), list(steps)
    for step in range(1, wanted[-1] + 1):
        velocity = DAMPING * (here - before)
        before = here.copy()
        here = here + velocity + GRAVITY * SECONDS_A_STEP ** 2
        for _ in range(ITERATIONS):
            for first, second, rest, stiffness in sets:
                apart = here[second] - here[first]
                length = np.linalg.norm(apart, axis=1, keepdims=True)
                moved = 0.5 * stiffness * (1 - rest / length) * apart
                here[first] += moved
                here[second] -= moved
            rest_on_sphere(here, before)
        if step == wanted[0]:
            wanted.pop(0)
            yield here.reshape(SIDE, SIDE, 3).copy()


def rest_on_sphere(here, before):
    """Moves vertices out of the sphere and the floor. Vertices that touch them lose half of their sliding motion."""
    length = np.linalg.norm(here, axis=1)
    inside = length < RADIUS + THICKNESS
    here[inside] *= ((RADIUS + THICKNESS) / length[inside])[:, None]
    low = here[:, 2] < FLOOR + THICKNESS
    here[low, 2] = FLOOR + THICKNESS
    touching = inside | low
    here[touching] -= 0.5 * (here[touching] - before[touching]) / ITERATIONS


def write_obj(path, positions, repeats):
    """Writes a mesh with smooth normals. The map is repeated `repeats` times along each side."""
    right, up = np.gradient(positions, axis=1), np.gradient(positions, axis=0)
    normals = np.cross(right, up)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    along = repeats * np.arange(SIDE) / (SIDE - 1)
    lines = []
    for row in range(SIDE):
        for column in range(SIDE):
            lines += ["v {:.6f} {:.6f} {:.6f}".format(*positions[row, column]),
                      f"vt {along[column]:.6f} {along[row]:.6f}",
                      "vn {:.6f} {:.6f} {:.6f}".format(*normals[row, column])]
    for row in range(SIDE - 1):
        for column in range(SIDE - 1):
            first = row * SIDE + column + 1  # OBJ files count from 1
            corners = (first, first + 1, first + SIDE + 1, first + SIDE)
            lines.append("f " + " ".join(f"{k}/{k}/{k}" for k in corners))
    path.write_text("\n".join(lines) + "\n")
