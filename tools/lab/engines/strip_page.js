// SPDX-License-Identifier: Apache-2.0
// Draws labelled pictures next to each other.
const GAP = 4, HEAD = 20; // pixels
const QUALITY = 0.9;

/**
 * Returns a JPEG in base64. Of each picture, the square of `crop` pixels in the middle is enlarged to `side` pixels
 * without smoothing.
 */
async function strip(title, pictures, side) {
  const canvas = new OffscreenCanvas(pictures.length * (side + GAP) - GAP, 2 * HEAD + side);
  const context = canvas.getContext("2d");
  context.fillStyle = "#fff";
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = "#000";
  context.font = "bold 14px sans-serif";
  context.fillText(title, 2, 15);
  context.font = "13px sans-serif";
  context.imageSmoothingEnabled = false;
  for (const [number, { label, bytes, width, crop }] of pictures.entries()) {
    const data = Uint8ClampedArray.from(atob(bytes), (one) => one.charCodeAt(0));
    const picture = new OffscreenCanvas(width, width), from = (width - crop) / 2, left = number * (side + GAP);
    picture.getContext("2d").putImageData(new ImageData(data, width, width), 0, 0);
    context.fillText(label, left + 2, HEAD + 15);
    context.drawImage(picture, from, from, crop, crop, left, 2 * HEAD, side, side);
  }
  const blob = await canvas.convertToBlob({ type: "image/jpeg", quality: QUALITY });
  let text = "";
  for (const byte of new Uint8Array(await blob.arrayBuffer())) text += String.fromCharCode(byte);
  return btoa(text);
}

globalThis.engine = { strip };
