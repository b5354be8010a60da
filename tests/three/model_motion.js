// SPDX-License-Identifier: Apache-2.0
// Moves a view slowly, by a fraction of a pixel to a few pixels per frame. Measures changes between frames that do not
// occur in the references.
import { toByte } from "./linear_pictures.js";

const plus = (a, b, factor) => a.map((value, i) => value + factor * b[i]);

/** Returns `view` after `step` frames of a "zoom", a "pan" or a "turn", which docs/evidence/FILTER.md defines. */
export function moved(view, { motion, step }) {
  const { eye, target } = view, ahead = plus(target, eye, -1), distance = Math.hypot(...ahead);
  const side = [-ahead[2] / distance, 0, ahead[0] / distance];
  const along = (way, factor) => ({ ...view, eye: plus(eye, way, factor), target: plus(target, way, factor) });
  if (motion === "zoom") return along(ahead, 0.01 * step);
  if (motion === "pan") return along(side, 0.003 * distance * step);
  if (motion === "turn") return { ...view, target: plus(target, side, Math.tan(0.004 * step) * distance) };
  throw new Error(`motion: found ${motion}, expected zoom, pan or turn`);
}

const EDGE = 3; // in units of 1/255; where the floor picture differs from its reference by more than this, there is an
                // edge

/**
 * Compares pictures of linear floats, four per pixel, with their references and floors. `flicker` is the mean over
 * neighbours in time of sum |(f' - f) - (t' - t)| / sum t. `jump` is the largest change of a colour beyond the change
 * of its reference, in 1/255 of sRGB, where there are no edges.
 */
export function changes(frames, references, floors) {
  let [flicker, jump] = [0, 0];
  for (let k = 0; k + 1 < frames.length; ++k) {
    const [f0, f1, t0, t1] = [frames[k], frames[k + 1], references[k], references[k + 1]];
    let [change, total] = [0, 0];
    for (let i = 0; i < f0.length; ++i) {
      if (i % 4 === 3) continue;
      change += Math.abs(f1[i] - f0[i] - (t1[i] - t0[i]));
      total += t0[i];
      const isEdge = [k, k + 1].some((j) => Math.abs(toByte(floors[j][i]) - toByte(references[j][i])) > EDGE);
      if (isEdge) continue;
      const beyond = Math.abs(toByte(f1[i]) - toByte(f0[i])) - Math.abs(toByte(t1[i]) - toByte(t0[i]));
      jump = Math.max(jump, beyond);
    }
    flicker += change / total / (frames.length - 1);
  }
  return { flicker, jump };
}
