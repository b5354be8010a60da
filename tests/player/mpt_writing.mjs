// SPDX-License-Identifier: Apache-2.0
// Splits packed fields (docs/reference/packed_fields.md) into parts and joins them again. The checksums are correct for
// any contents.
import { deflateSync, inflateSync } from "node:zlib";
import { sectionChecksum } from "../../runtime_gl/web/checksum.js";

function number(value) {
  const bytes = [];
  for (; value >= 128; value = Math.floor(value / 128)) bytes.push(value % 128 + 128);
  return [...bytes, value];
}
const fixed = (value) => [0, 8, 16, 24].map((shift) => value >>> shift & 255);

function reader(bytes) {
  let at = 0;
  return {
    number() {
      let value = 0;
      for (let shift = 0; ; shift += 7) {
        const next = bytes[at++];
        value += (next & 127) * 2 ** shift;
        if (next < 128) return value;
      }
    },
    skip(count) { at += count; },
    get at() { return at; },
  };
}

/** Sections: { kind, layer, block, bytes }. */
export function sectionsOf(file) {
  const read = reader(file);
  read.skip(9);
  const list = Array.from({ length: read.number() }, () => {
    const [kind, layer, block, length] = [0, 0, 0, 0].map(() => read.number());
    read.skip(4);
    return { kind, layer, block, length };
  });
  let at = read.at + 4;
  return list.map(({ length, ...section }) => {
    at += length;
    return { ...section, bytes: file.subarray(at - length, at) };
  });
}

export function fileOf(sections) {
  const index = [...number(sections.length), ...sections.flatMap(({ kind, layer, block, bytes }) =>
    [...number(kind), ...number(layer), ...number(block), ...number(bytes.length), ...fixed(sectionChecksum(bytes))])];
  const head = Uint8Array.from([77, 80, 84, 70, 2, ...fixed(index.length), ...index]);
  return Buffer.concat([head, Uint8Array.from(fixed(sectionChecksum(head))), ...sections.map(({ bytes }) => bytes)]);
}

export function descriptionOf(section) {
  const read = reader(section.bytes);
  read.number();
  return JSON.parse(inflateSync(section.bytes.subarray(read.at)));
}

export function descriptionSection(json, length) {
  const text = Buffer.from(typeof json === "string" ? json : JSON.stringify(json));
  return { kind: 0, layer: 0, block: 0,
    bytes: Buffer.concat([Uint8Array.from(number(length ?? text.length)), deflateSync(text)]) };
}
