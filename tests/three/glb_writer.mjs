// SPDX-License-Identifier: Apache-2.0
// Writes a GLB with one mesh and one material. Its images are PNG files.
import { Buffer } from "node:buffer";
import { deflateSync } from "node:zlib";

const CRC_STEPS = Uint32Array.from({ length: 256 }, (_, byte) => {
  let left = byte;
  for (let bit = 0; bit < 8; ++bit) left = left & 1 ? 0xedb88320 ^ (left >>> 1) : left >>> 1;
  return left;
});
const crc32 = (data) => (data.reduce((sum, byte) => CRC_STEPS[(sum ^ byte) & 255] ^ (sum >>> 8), 0xffffffff) ^
  0xffffffff) >>> 0;
const wide = (...values) => Buffer.from(Uint32Array.from(values).buffer);

/** Returns the bytes of a PNG file. */
export function pngOf({ width, height, rgb }) {
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type, "latin1"), data]), head = Buffer.alloc(4), sum = Buffer.alloc(4);
    head.writeUInt32BE(data.length);
    sum.writeUInt32BE(crc32(body));
    return Buffer.concat([head, body, sum]);
  };
  const header = Buffer.alloc(13), rows = Buffer.alloc(height * (1 + 3 * width));
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2, 0, 0, 0], 8); // bits, RGB
  for (let y = 0; y < height; ++y) rows.set(rgb.subarray(3 * width * y, 3 * width * (y + 1)), y * (1 + 3 * width) + 1);
  return Buffer.concat([Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]), chunk("IHDR", header),
    chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]);
}

const extreme = (values, better) => [0, 1, 2].map((axis) =>
  values.reduce((best, value, i) => (i % 3 === axis ? better(best, value) : best), values[axis]));

/**
 * `mesh` is { positions, normals, uvs, indices }, flat arrays. `normal` and the optional `colors` and `surface` (green:
 * roughness, blue: metalness) are { width, height, rgb }. Without these options, the material has `color`, `roughness`
 * and `metalness`.
 */
export function makeGlb(name, { mesh, normal, colors, surface, color = [1, 1, 1], roughness = 1, metalness = 1 }) {
  const images = [normal, colors, surface].filter((one) => one !== undefined);
  const floats = (values) => Buffer.from(Float32Array.from(values).buffer);
  const parts = [...[mesh.positions, mesh.normals, mesh.uvs].map(floats), wide(...mesh.indices), ...images.map(pngOf)];
  const filled = (part, byte) => Buffer.concat([part, Buffer.alloc((4 - part.length % 4) % 4, byte)]);
  const padded = parts.map((part) => filled(part, 0));
  let offset = 0;
  const bufferViews = parts.map((part, i) => {
    const view = { buffer: 0, byteOffset: offset, byteLength: part.length };
    offset += padded[i].length;
    return view;
  });
  const vertexCount = mesh.positions.length / 3, float = (view, type) =>
    ({ bufferView: view, componentType: 5126, count: vertexCount, type });
  const texture = (one) => ({ index: images.indexOf(one) });
  const material = { name, normalTexture: texture(normal), pbrMetallicRoughness: { baseColorFactor: [...color, 1],
    metallicFactor: metalness, roughnessFactor: roughness } };
  if (colors) material.pbrMetallicRoughness.baseColorTexture = texture(colors);
  if (surface) material.pbrMetallicRoughness.metallicRoughnessTexture = texture(surface);
  const json = { asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0, name }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3, material: 0 }] }],
    materials: [material], textures: images.map((one, source) => ({ source, sampler: 0 })),
    samplers: [{ magFilter: 9729, minFilter: 9987, wrapS: 10497, wrapT: 10497 }],
    images: images.map((one, i) => ({ bufferView: 4 + i, mimeType: "image/png" })),
    accessors: [{ ...float(0, "VEC3"), min: extreme(mesh.positions, Math.min), max: extreme(mesh.positions, Math.max) },
      float(1, "VEC3"), float(2, "VEC2"),
      { bufferView: 3, componentType: 5125, count: mesh.indices.length, type: "SCALAR" }],
    bufferViews, buffers: [{ byteLength: offset }] };
  const chunk = (type, data) => Buffer.concat([wide(data.length), Buffer.from(type, "latin1"), data]);
  const text = filled(Buffer.from(JSON.stringify(json)), 32);
  const body = Buffer.concat([chunk("JSON", text), chunk("BIN\0", Buffer.concat(padded))]);
  return Buffer.concat([Buffer.from("glTF", "latin1"), wide(2, 12 + body.length), body]);
}
