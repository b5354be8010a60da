// SPDX-License-Identifier: Apache-2.0
// Compares and encodes pictures that have four linear floats per pixel.

/** Returns relative L1, the sum of |picture - reference| over the sum of the reference, and the ratio of their sums. */
export function compared(picture, reference) {
  let [difference, all, wanted] = [0, 0, 0];
  for (let i = 0; i < picture.length; ++i) {
    if (i % 4 === 3) continue;
    difference += Math.abs(picture[i] - reference[i]);
    all += picture[i];
    wanted += reference[i];
  }
  return { error: difference / wanted, energy: all / wanted };
}

/** Returns the sRGB code of a linear value, 0 to 255. */
export const toByte = (linear) => {
  const v = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
};
