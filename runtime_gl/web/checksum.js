// SPDX-License-Identifier: Apache-2.0
// Computes the checksum of a packed field's sections, which is the lower 32 bits of CRC-64/XZ
// (docs/reference/packed_fields.md, "Packed fields"). Uses two halves of 32 bits, because JavaScript's bit operations
// have only 32 bits.

const HIGH_POLYNOMIAL = 0xc96c5795;
const LOW_POLYNOMIAL = 0xd7870f42;
const highTable = new Uint32Array(256);
const lowTable = new Uint32Array(256);
for (let i = 0; i < 256; ++i) {
  let high = 0;
  let low = i;
  for (let bit = 0; bit < 8; ++bit) {
    const isOdd = low & 1;
    low = (low >>> 1 | high << 31) >>> 0;
    high >>>= 1;
    if (isOdd) {
      low = (low ^ LOW_POLYNOMIAL) >>> 0;
      high = (high ^ HIGH_POLYNOMIAL) >>> 0;
    }
  }
  highTable[i] = high;
  lowTable[i] = low;
}

export function sectionChecksum(bytes) {
  let high = 0xffffffff;
  let low = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) {
    const place = (low ^ bytes[i]) & 255;
    low = (low >>> 8 | high << 24) ^ lowTable[place];
    high = high >>> 8 ^ highTable[place];
  }
  return ~low >>> 0;
}
