// SPDX-License-Identifier: Apache-2.0
// Computes with 4 x 4 matrices, which are stored column by column as sixteen numbers. Interpolates cameras and places
// between samples.

export function identity() {
  const matrix = new Float64Array(16);
  for (let i = 0; i < 16; i += 5) matrix[i] = 1;
  return matrix;
}

export function multiplied(a, b) {
  const product = new Float64Array(16);
  for (let column = 0; column < 4; ++column)
    for (let row = 0; row < 4; ++row)
      for (let k = 0; k < 4; ++k) product[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return product;
}

export const isEqual = (a, b) => a === b || a.every((value, i) => value === b[i]);

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const scaled = (a, s) => a.map((one) => one * s);
const less = (a, b, s) => a.map((one, i) => one - s * b[i]);
const crossed = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.sqrt(dot(a, a));
const mixed = (lists, weights) => lists[0].map((_, i) => lists.reduce((sum, list, k) => sum + weights[k] * list[i], 0));

/** Returns the quaternion w, x, y, z of the rotation with these rows. */
function quaternionOf([a, b, c]) {
  const trace = a[0] + b[1] + c[2];
  const q = [1 + trace, 1 + a[0] - b[1] - c[2], 1 - a[0] + b[1] - c[2], 1 - a[0] - b[1] + c[2]];
  const most = q.indexOf(Math.max(...q));
  const s = Math.sqrt(Math.max(q[most], 1e-30)) / 2;
  const [wx, wy, wz] = [(c[1] - b[2]) / (4 * s), (a[2] - c[0]) / (4 * s), (b[0] - a[1]) / (4 * s)];
  const [xy, xz, yz] = [(a[1] + b[0]) / (4 * s), (a[2] + c[0]) / (4 * s), (b[2] + c[1]) / (4 * s)];
  return [[s, wx, wy, wz], [wx, s, xy, xz], [wy, xy, s, yz], [wz, xz, yz, s]][most];
}

function rowsOf([w, x, y, z]) {
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
}

/** Returns the weighted mean of similar rotations. */
function mixedRotation(quaternions, weights) {
  const signed = quaternions.map((q) =>
    (q.reduce((sum, one, i) => sum + one * quaternions[0][i], 0) < 0 ? scaled(q, -1) : q));
  const mean = mixed(signed, weights);
  return scaled(mean, 1 / Math.hypot(...mean));
}

/**
 * Returns a camera's parts: `eye`, `rotation` to camera space, and the numbers of `perspective`, such that
 * clip = perspective (rotation (world - eye)). Returns null if the matrix is not a perspective.
 */
export function cameraParts(worldToClip) {
  const rows = [0, 1, 2, 3].map((r) => [worldToClip[r], worldToClip[4 + r], worldToClip[8 + r]]);
  const ends = [0, 1, 2, 3].map((r) => worldToClip[12 + r]);
  const scale = length(rows[3]);
  if (!(scale > 1e-12)) return null;
  const back = scaled(rows[3], -1 / scale); // +z of camera space
  const upward = less(rows[1], back, dot(rows[1], back));
  const fy = length(upward);
  if (!(fy > 1e-12)) return null;
  const up = scaled(upward, 1 / fy);
  const right = crossed(up, back);
  const fx = dot(rows[0], right);
  if (!(Math.abs(fx) > 1e-12)) return null;
  const skew = dot(rows[0], up);
  const [cx, cy, depth] = [dot(rows[0], back), dot(rows[1], back), dot(rows[2], back)];
  // The position of the world's origin in camera space, from which the eye's position is computed.
  const tz = ends[3] / -scale;
  const ty = (ends[1] - cy * tz) / fy;
  const tx = (ends[0] - cx * tz - skew * ty) / fx;
  const eye = [0, 1, 2].map((i) => -(right[i] * tx + up[i] * ty + back[i] * tz));
  return { eye, right, rotation: quaternionOf([right, up, back]), lens: [fx, skew, fy, cx, cy, depth,
    ends[2] - depth * tz, scale] };
}

function cameraOf(eye, rotation, [fx, skew, fy, cx, cy, depth, depthEnd, scale]) {
  const [right, up, back] = rowsOf(rotation);
  const row = (a, b, c, end) => {
    const vector = [0, 1, 2].map((i) => a * right[i] + b * up[i] + c * back[i]);
    return [...vector, end - dot(vector, eye)];
  };
  const rows = [row(fx, skew, cx, 0), row(0, fy, cy, 0), row(0, 0, depth, depthEnd), row(0, 0, -scale, 0)];
  return Float64Array.from({ length: 16 }, (_, i) => rows[i % 4][i >> 2]);
}

/**
 * Mixes cameras: eyes and lenses linearly, directions by rotation. If there is only one camera, returns it unchanged.
 */
export function mixedCamera(matrices, weights) {
  const heaviest = weights.indexOf(Math.max(...weights));
  if (weights[heaviest] === 1 || matrices.every((one) => isEqual(one, matrices[0]))) return matrices[heaviest];
  const parts = matrices.map(cameraParts);
  if (parts.includes(null)) return matrices[heaviest];
  return cameraOf(mixed(parts.map((one) => one.eye), weights),
    mixedRotation(parts.map((one) => one.rotation), weights), mixed(parts.map((one) => one.lens), weights));
}

/** Returns the rotation and size of a place with a uniform scale and no mirroring, otherwise null. */
function placeParts(matrix) {
  const columns = [0, 4, 8].map((i) => [matrix[i], matrix[i + 1], matrix[i + 2]]);
  const size = length(columns[0]);
  const isRigid = size > 1e-12 && columns.every((one) => Math.abs(length(one) - size) < 1e-4 * size) &&
    [[0, 1], [0, 2], [1, 2]].every(([i, j]) => Math.abs(dot(columns[i], columns[j])) < 1e-4 * size * size);
  if (!isRigid) return null;
  const rows = [0, 1, 2].map((r) => columns.map((column) => column[r] / size));
  return dot(rows[0], crossed(rows[1], rows[2])) > 0 ? { size, rotation: quaternionOf(rows) } : null;
}

/** Mixes places of an object: by rotation if all are rotations with a uniform scale, otherwise linearly. */
export function mixedPlace(matrices, weights) {
  const heaviest = weights.indexOf(Math.max(...weights));
  if (weights[heaviest] === 1 || matrices.every((one) => isEqual(one, matrices[0]))) return matrices[heaviest];
  const linear = Float64Array.from(mixed(matrices.map((one) => [...one]), weights));
  const parts = matrices.map(placeParts);
  if (parts.includes(null)) return linear;
  const rows = rowsOf(mixedRotation(parts.map((one) => one.rotation), weights));
  const size = parts.reduce((sum, one, k) => sum + weights[k] * one.size, 0);
  for (let column = 0; column < 3; ++column)
    for (let row = 0; row < 3; ++row) linear[4 * column + row] = size * rows[row][column];
  return linear;
}
