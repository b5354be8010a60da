// SPDX-License-Identifier: Apache-2.0
// Measures the error of methods against the map itself, which is its finest level, drawn at many places of each pixel.
const PLACES_ACROSS = 12; // places across a pixel; the same number upwards

/** Returns the scene shifted to another place of each pixel. `x` and `y` are from -1/2 to 1/2 pixel. */
function movedWithinPixel(scene, [width, height], x, y) {
  const across = 2 * x / width, up = 2 * y / height;
  const rays = scene.rays.slice(), toClip = scene.toClip.slice();
  for (let i = 0; i < 3; ++i) rays[6 + i] += across * rays[i] + up * rays[3 + i];
  for (let c = 0; c < 16; c += 4) {
    toClip[c] -= across * toClip[c + 3];
    toClip[c + 1] -= up * toClip[c + 3];
  }
  return { ...scene, rays, toClip };
}

/** Returns the sum of absolute differences of two RGBA pictures' colours. */
function differenceOf(one, other) {
  let sum = 0;
  for (let i = 0; i < one.length; ++i) if (i % 4 !== 3) sum += Math.abs(one[i] - other[i]);
  return sum;
}

/**
 * Returns the relative L1 error of each method's radiance against the mean of the map's finest level, and `noise`: half
 * the difference of the means of two halves of the places. Returns null if `isStale()` reports a changed view.
 * `onShare` gets the progress, 0 to 1.
 */
async function errorsBesideMap(gl, methods, scene, isStale, onShare) {
  const halves = [0, 1].map(() => new Float32Array(4 * gl.size[0] * gl.size[1]));
  const place = (i) => (i + 0.5) / PLACES_ACROSS - 0.5;
  for (let y = 0; y < PLACES_ACROSS; ++y) {
    for (let x = 0; x < PLACES_ACROSS; ++x) {
      const seen = gl.radiance("mip", { ...movedWithinPixel(scene, gl.size, place(x), place(y)), lock: 0 });
      const half = halves[(x + y) % 2];
      for (let i = 0; i < half.length; ++i) half[i] += seen[i];
    }
    onShare((y + 1) / PLACES_ACROSS);
    await giveWay();
    if (isStale()) return null;
  }
  const count = PLACES_ACROSS ** 2, mean = halves[0].map((one, i) => (one + halves[1][i]) / count);
  const whole = Math.max(differenceOf(mean, new Float32Array(mean.length)), Number.MIN_VALUE);
  return { noise: differenceOf(halves[0], halves[1]) / count / whole,
    errors: methods.map((method) => differenceOf(gl.radiance(method, scene), mean) / whole) };
}
