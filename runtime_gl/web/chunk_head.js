// SPDX-License-Identifier: Apache-2.0
// Reads the size and number of a chunk's textures from its first bytes, without decoding the chunk
// (docs/reference/packed_fields.md, "Chunks").

/** Returns `{ width, height, textures }`, or zeros if there are too few bytes. */
export function chunkHead(bytes) {
  let at = 1;
  const number = () => {
    let value = 0;
    for (let shift = 0; shift < 35; shift += 7) {
      const next = bytes[at++] ?? 0;
      value += (next & 127) * 2 ** shift;
      if (next < 128) break;
    }
    return value;
  };
  const [width, height] = [number(), number()];
  const dimensions = Math.min(bytes[at] ?? 0, 8);
  at += 2;
  let textures = dimensions > 0 ? 1 : 0;
  for (let d = 0; d < dimensions; ++d) textures *= number();
  return { width, height, textures };
}
