// SPDX-License-Identifier: Apache-2.0
// Makes a Radiance HDR picture of a sky that is black except for a sun.
import { Buffer } from "node:buffer";

const WIDTH = 512, HEIGHT = 256, SAMPLES = 4; // samples along each side of a pixel

function rgbe(value) {
  if (value < 1e-9) return [0, 0, 0, 0];
  const exponent = Math.ceil(Math.log2(value)), part = Math.min(255, Math.round(256 * value / 2 ** exponent));
  return [part, part, part, exponent + 128];
}

/** Returns the bytes of the file. The sun has the irradiance `light` and a radius of `sunRadius` degrees. */
export function skyBytes({ light, towardsLight, sunRadius }) {
  const radius = sunRadius * Math.PI / 180, radiance = light / (Math.PI * Math.sin(radius) ** 2);
  const size = Math.hypot(...towardsLight), pixels = Buffer.alloc(4 * WIDTH * HEIGHT);
  const seesSun = (column, row) => {
    const [turn, rise] = [(column / WIDTH - 0.5) * 2 * Math.PI, (0.5 - row / HEIGHT) * Math.PI];
    const direction = [Math.cos(turn) * Math.cos(rise), Math.sin(rise), Math.sin(turn) * Math.cos(rise)];
    return direction.reduce((sum, part, axis) => sum + part * towardsLight[axis] / size, 0) > Math.cos(radius);
  };
  for (let y = 0; y < HEIGHT; ++y)
    for (let x = 0; x < WIDTH; ++x) {
      let seen = 0;
      for (let i = 0; i < SAMPLES ** 2; ++i)
        seen += seesSun(x + (i % SAMPLES + 0.5) / SAMPLES, y + (Math.floor(i / SAMPLES) + 0.5) / SAMPLES);
      pixels.set(rgbe(radiance * seen / SAMPLES ** 2), 4 * (y * WIDTH + x));
    }
  return Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${HEIGHT} +X ${WIDTH}\n`), pixels]);
}
