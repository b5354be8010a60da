// SPDX-License-Identifier: Apache-2.0
// Decodes BC5 textures for browsers and GPUs without EXT_texture_compression_rgtc. Such textures have blocks of 4 x 4
// texels, with two channels per block (Khronos Data Format Specification 1.3, section 17).

/** Decodes a BC4 block to every `step`-th byte of `out` from `at` on, in rows of `stride` bytes, up to the edge. */
function decodeBc4(block, out, at, stride, step, columns, rows) {
  const [first, last] = block;
  const parts = first > last ? 7 : 5;
  const palette = [first, last];
  for (let part = 1; part < parts; ++part) palette.push(Math.round(((parts - part) * first + part * last) / parts));
  if (parts === 5) palette.push(0, 255);
  for (let texel = 0; texel < 16; ++texel) {
    const bit = 16 + 3 * texel, byte = bit >> 3;
    const index = ((block[byte] | (block[byte + 1] ?? 0) << 8) >> (bit & 7)) & 7;
    const [x, y] = [texel & 3, texel >> 2];
    if (x < columns && y < rows) out[at + y * stride + step * x] = palette[index];
  }
}

/** Decodes layers of BC5 to RG8, or, if `layersPerTexel` is 2, two layers to one of RGBA8. */
export function decodeBc5(bytes, width, height, layerCount, layersPerTexel = 1) {
  const step = 2 * layersPerTexel, out = new Uint8Array(2 * width * height * layerCount);
  let from = 0;
  for (let layer = 0; layer < layerCount; ++layer)
    for (let y = 0; y < height; y += 4)
      for (let x = 0; x < width; x += 4)
        for (let channel = 0; channel < 2; ++channel, from += 8) {
          const at = step * (x + width * (y + height * Math.floor(layer / layersPerTexel))) +
            2 * (layer % layersPerTexel) + channel;
          decodeBc4(bytes.subarray(from, from + 8), out, at, step * width, step, width - x, height - y);
        }
  return out;
}
