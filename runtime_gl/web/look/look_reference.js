// SPDX-License-Identifier: Apache-2.0
// Draws the reference, which is the map's finest level at many places of each pixel, and measures the error of methods
// against it.
const PLACES_ACROSS = 12; // places across a pixel; the same number upwards
const PLACE_COUNT = PLACES_ACROSS ** 2;
const REFERENCE_FRAME_MS = 30; // time for samples per frame, while the reference becomes finer

/** Returns the scene moved to place number `index` of each pixel. Successive places are far apart. */
function sceneAtPlace(scene, size, index) {
  const place = (index * 89) % PLACE_COUNT, at = (i) => (i + 0.5) / PLACES_ACROSS - 0.5;
  return movedWithinPixel(scene, size, at(place % PLACES_ACROSS), at(Math.floor(place / PLACES_ACROSS)));
}

/** The reference on the screen. It restarts with each view, and becomes finer from frame to frame. */
class Reference {
  constructor() {
    this.count = 0; // samples per pixel so far
    this.perFrame = 2;
    this.sampleMs = 0; // time of the last samples, each
  }

  get isDone() { return this.count === PLACE_COUNT; }

  /** Draws more samples of the same view. Waits for the GPU, so that the next frame draws as many as fit. */
  refine(gl, scene, count = this.perFrame) {
    const begin = performance.now(), end = Math.min(PLACE_COUNT, this.count + count), from = this.count;
    for (; this.count < end; ++this.count) gl.addToReference(this.count, sceneAtPlace(scene, gl.size, this.count));
    if (this.count === from) return;
    gl.finish();
    const ms = Math.max(0.1, (performance.now() - begin) / (this.count - from));
    this.sampleMs = ms;
    this.perFrame = Math.min(24, Math.max(1, Math.round(REFERENCE_FRAME_MS / ms)));
  }
}

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

/** Returns the sum of absolute differences of two RGBA pictures' colours, where `covered` has alpha. */
function differenceOf(one, other, covered) {
  let sum = 0;
  for (let i = 0; i < one.length; ++i) if (i % 4 !== 3 && covered[i | 3] > 0) sum += Math.abs(one[i] - other[i]);
  return sum;
}

/**
 * Returns the relative L1 error of each method's radiance against the mean of the map's finest level, without the
 * background, and `noise`: half the difference of the means of two halves of the places. Returns null if `isStale()`
 * reports a changed view. `onShare` gets the progress, 0 to 1.
 */
async function errorsBesideMap(gl, methods, scene, isStale, onShare) {
  const halves = [0, 1].map(() => new Float32Array(4 * gl.size[0] * gl.size[1]));
  for (let i = 0; i < PLACE_COUNT; ++i) {
    const seen = gl.radiance("mip", { ...sceneAtPlace(scene, gl.size, i), lock: 0 });
    const half = halves[i % 2];
    for (let k = 0; k < half.length; ++k) half[k] += seen[k];
    if ((i + 1) % PLACES_ACROSS !== 0) continue;
    onShare((i + 1) / PLACE_COUNT);
    await giveWay();
    if (isStale()) return null;
  }
  const mean = halves[0].map((one, i) => (one + halves[1][i]) / PLACE_COUNT);
  const whole = Math.max(differenceOf(mean, new Float32Array(mean.length), mean), Number.MIN_VALUE);
  return { noise: differenceOf(halves[0], halves[1], mean) / PLACE_COUNT / whole,
    errors: methods.map((method) => differenceOf(gl.radiance(method, scene), mean, mean) / whole) };
}
