// SPDX-License-Identifier: Apache-2.0
// Compares pictures of engine_pictures.mjs. A picture is a list of linear values, three per pixel, between 0 and 1.

/** Returns the linear value of an sRGB code, 0 to 255. */
export const fromByte = (byte) => (byte <= 10.31475 ? byte / 3294.6 : ((byte / 255 + 0.055) / 1.055) ** 2.4);

/** Returns the square of `crop` pixels in the middle of RGBA bytes of `side` x `side` pixels, as linear values. */
export function middleOf(bytes, side, crop) {
  const from = (side - crop) / 2, made = [];
  for (let y = from; y < from + crop; ++y)
    for (let x = from; x < from + crop; ++x)
      for (let c = 0; c < 3; ++c) made.push(fromByte(bytes[4 * (y * side + x) + c]));
  return made;
}

/** Returns the middle of a linear RGBA picture, with `tone` applied to each pixel, and clipped to 0 to 1. */
export function shownMiddleOf(linear, side, crop, tone) {
  const from = (side - crop) / 2, made = [];
  for (let y = from; y < from + crop; ++y)
    for (let x = from; x < from + crop; ++x) {
      const at = 4 * (y * side + x);
      made.push(...tone(linear.slice(at, at + 3)).map((value) => Math.min(1, Math.max(0, value))));
    }
  return made;
}

/** Khronos PBR Neutral tone mapping, which CesiumJS applies ("PBR Neutral Tone Mapping", Khronos, 2024). */
export function neutral(rgb) {
  const start = 0.8 - 0.04, desaturation = 0.15, low = Math.min(...rgb);
  const offset = low < 0.08 ? low - 6.25 * low * low : 0.04, color = rgb.map((value) => value - offset);
  const peak = Math.max(...color);
  if (peak < start) return color;
  const d = 1 - start, limited = 1 - d * d / (peak + d - start), g = 1 - 1 / (desaturation * (peak - limited) + 1);
  return color.map((value) => value * limited / peak * (1 - g) + limited * g);
}

const sum = (values) => values.reduce((all, value) => all + value, 0);
const difference = (a, b) => a.reduce((all, value, i) => all + Math.abs(value - b[i]), 0);
const mean = (values) => sum(values) / values.length;

/** Returns relative L1 over all frames: the sum of |picture - reference|, divided by the sum of the reference. */
export const errorOf = (frames, references) =>
  sum(frames.map((one, i) => difference(one, references[i]))) / sum(references.map(sum));

/** Returns the sum of all frames, divided by the sum of the references. */
export const energyOf = (frames, references) => sum(frames.map(sum)) / sum(references.map(sum));

export const brightnessOf = (frames) => mean(frames.map(mean));

/** Returns the mean absolute change of a value from one frame to the next. */
export const flickerOf = (frames) => mean(frames.slice(1).map((one, i) => difference(one, frames[i]) / one.length));
