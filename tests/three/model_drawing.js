// SPDX-License-Identifier: Apache-2.0
// Draws a scene of three.js into a picture with four linear floats per pixel.
import * as THREE from "three";
import { toByte } from "./linear_pictures.js";

const TILE = 1024; // the number of pixels per side that are drawn at once

/**
 * Draws `width` x `height` pixels, each the mean of `samples` x `samples`. `shift` is the offset of the samples, in
 * samples. Nothing is drawn outside of `crop`, [left, top, width, height].
 */
export function drawn(renderer, scene, camera,
  { width, height, samples, shift = [0, 0], crop = [0, 0, width, height] }) {
  const [left0, top0, w, h] = crop, tile = Math.min(Math.floor(TILE / samples), Math.max(w, h)), side = tile * samples;
  const made = new Float32Array(4 * width * height), halves = new Uint16Array(4 * side ** 2);
  const target = new THREE.WebGLRenderTarget(side, side, { type: THREE.HalfFloatType });
  renderer.setRenderTarget(target);
  for (let top = top0; top < top0 + h; top += tile)
    for (let left = left0; left < left0 + w; left += tile) {
      camera.setViewOffset(width * samples, height * samples, left * samples + shift[0], top * samples + shift[1], side,
        side);
      renderer.render(scene, camera);
      renderer.readRenderTargetPixels(target, 0, 0, side, side, halves);
      for (let y = 0; y < side; ++y)
        for (let x = 0; x < side; ++x) {
          const [column, row] = [left + Math.floor(x / samples), top + Math.floor((side - 1 - y) / samples)];
          if (column >= width || row >= height) continue;
          for (let c = 0; c < 4; ++c)
            made[4 * (row * width + column) + c] += THREE.DataUtils.fromHalfFloat(halves[4 * (y * side + x) + c]) /
              samples ** 2;
        }
    }
  renderer.setRenderTarget(null);
  target.dispose();
  camera.clearViewOffset();
  return made;
}

/**
 * Draws the mean of `frames` x `frames` pictures, each shifted by a part of a pixel, like temporal antialiasing. Each
 * picture has `edges` samples of edges.
 */
export function settled(renderer, scene, camera, { width, height, frames, edges }) {
  const made = new Float32Array(4 * width * height), halves = new Uint16Array(made.length);
  const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.HalfFloatType, samples: edges });
  renderer.setRenderTarget(target);
  for (let frame = 0; frame < frames ** 2; ++frame) {
    const shift = (k) => (k + 0.5) / frames - 0.5;
    camera.setViewOffset(width, height, shift(frame % frames), shift(Math.floor(frame / frames)), width, height);
    renderer.render(scene, camera);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, halves);
    for (let y = 0; y < height; ++y)
      for (let i = 0; i < 4 * width; ++i)
        made[4 * y * width + i] += THREE.DataUtils.fromHalfFloat(halves[4 * (height - 1 - y) * width + i]) /
          frames ** 2;
  }
  renderer.setRenderTarget(null);
  target.dispose();
  camera.clearViewOffset();
  return made;
}

/**
 * Returns pictures next to each other as a JPEG in base64: of each the rectangle [x, y, width, height], `zoom` times.
 */
export async function strip(pictures, width, [x0, y0, w, h], zoom) {
  const gap = 4, canvas = new OffscreenCanvas(pictures.length * (w * zoom + gap) - gap, h * zoom);
  const context = canvas.getContext("2d");
  context.fillStyle = "#888";
  context.fillRect(0, 0, canvas.width, canvas.height);
  pictures.forEach((pixels, number) => {
    const image = context.createImageData(w * zoom, h * zoom);
    for (let y = 0; y < h * zoom; ++y)
      for (let x = 0; x < w * zoom; ++x)
        for (let c = 0; c < 4; ++c)
          image.data[4 * (y * w * zoom + x) + c] = c === 3 ? 255
            : toByte(pixels[4 * ((y0 + Math.floor(y / zoom)) * width + x0 + Math.floor(x / zoom)) + c]);
    context.putImageData(image, number * (w * zoom + gap), 0);
  });
  const blob = await canvas.convertToBlob({ type: "image/jpeg", quality: 0.88 });
  let text = "";
  for (const byte of new Uint8Array(await blob.arrayBuffer())) text += String.fromCharCode(byte);
  return btoa(text);
}
