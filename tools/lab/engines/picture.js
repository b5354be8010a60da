// SPDX-License-Identifier: Apache-2.0
// Contains what the pages of all engines share.

/** Returns the place of the camera, which looks at the origin. Angles are in degrees; y points up. */
export function eyeOf({ azimuth, elevation, distance }) {
  const [turn, rise] = [azimuth, elevation].map((degrees) => degrees * Math.PI / 180);
  return [Math.sin(turn) * Math.cos(rise), Math.sin(rise), Math.cos(turn) * Math.cos(rise)]
    .map((part) => part * distance);
}

/** Returns a canvas of `side` x `side` pixels on the page. */
export function makeCanvas(side) {
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width: side, height: side });
  canvas.style.cssText = `display: block; width: ${side}px; height: ${side}px`;
  document.body.append(canvas);
  return canvas;
}

/** Returns the RGBA bytes of a picture, row 0 at the top, in base64. */
export function pixelsOf(picture, side = picture.width) {
  const context = new OffscreenCanvas(side, side).getContext("2d");
  context.fillStyle = "#000";
  context.fillRect(0, 0, side, side);
  context.drawImage(picture, 0, 0, side, side);
  let text = "";
  for (const byte of context.getImageData(0, 0, side, side).data) text += String.fromCharCode(byte);
  return btoa(text);
}

/** Waits for `count` frames of the browser. */
export async function frames(count) {
  for (let frame = 0; frame < count; ++frame) await new Promise((resolve) => requestAnimationFrame(resolve));
}
