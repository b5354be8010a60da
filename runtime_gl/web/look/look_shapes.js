// SPDX-License-Identifier: Apache-2.0
// Makes the shapes of the page: triangles like those of readModel(), with eight floats per corner: position, normal, u,
// v. The map repeats often enough that its texels have about the same size everywhere.

/** Joins a grid of `corner(u, v)`, with u and v from 0 to 1, to triangles. */
function gridOf(columns, rows, corner) {
  const vertices = new Float32Array(48 * columns * rows);
  let at = 0;
  for (let y = 0; y < rows; ++y)
    for (let x = 0; x < columns; ++x)
      for (const [i, j] of [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]) {
        vertices.set(corner((x + i) / columns, (y + j) / rows), at);
        at += 8;
      }
  return { vertices, count: 6 * columns * rows, image: null, isClosed: true };
}

function joined(parts) {
  const vertices = new Float32Array(parts.reduce((sum, one) => sum + one.vertices.length, 0));
  parts.reduce((at, one) => { vertices.set(one.vertices, at); return at + one.vertices.length; }, 0);
  return { ...parts[0], vertices, count: vertices.length / 8 };
}

/** A sphere that is a blown-up cube, so that no place pinches the map. */
function sphereShape(centre, radius) {
  const sides = [[[1, 0, 0], [0, 0, 1]], [[0, 1, 0], [0, 0, 1]], [[-1, 0, 0], [0, 0, 1]], [[0, -1, 0], [0, 0, 1]],
    [[1, 0, 0], [0, 1, 0]], [[1, 0, 0], [0, -1, 0]]]; // across and up, whose cross product points outwards
  return joined(sides.map(([across, up]) => {
    const out = [across[1] * up[2] - across[2] * up[1], across[2] * up[0] - across[0] * up[2],
      across[0] * up[1] - across[1] * up[0]];
    return gridOf(32, 32, (u, v) => {
      const [s, t] = [u, v].map((one) => Math.tan(0.25 * Math.PI * (2 * one - 1)));
      const place = out.map((one, c) => one + s * across[c] + t * up[c]), size = Math.hypot(...place);
      const n = place.map((one) => one / size);
      return [...n.map((one, c) => centre[c] + radius * one), ...n, 2 * u, 2 - 2 * v];
    });
  }));
}

/** A ring that stands up and is turned a little, so that the view passes along it at every angle. */
function ringShape(centre, radius) {
  const [large, small] = [0.68 * radius, 0.32 * radius];
  const [c, s] = [Math.cos(0.9), Math.sin(0.9)];
  return gridOf(192, 64, (u, v) => {
    const along = 2 * Math.PI * u, about = 2 * Math.PI * v;
    const turned = ([x, y, z]) => [x, c * y - s * z, s * y + c * z];
    const n = turned([Math.cos(along) * Math.cos(about), Math.sin(along) * Math.cos(about), Math.sin(about)]);
    const middle = turned([large * Math.cos(along), large * Math.sin(along), 0]);
    return [...n.map((one, i) => centre[i] + middle[i] + small * one), ...n, 8 * u, 4 * v];
  });
}

/** By name: what the list shows, and a function that makes the shape, or null for the endless plane. */
const SHAPES = { plane: ["plane", null], sphere: ["sphere", sphereShape], ring: ["ring", ringShape] };
