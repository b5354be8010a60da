// SPDX-License-Identifier: Apache-2.0
// Reads a packed field, NAME.mpt (docs/reference/packed_fields.md, "Packed fields"). Reads its index, its description,
// and single sections on request. Reports problems as FieldError with the file's name.
import { FieldError } from "./byte_source.js";
import { sectionChecksum } from "./checksum.js";

const VERSION = 2;
const HEAD_BYTES = 9;
const FIRST_BYTES = 65536; // the first request gets most indices and descriptions
const INDEX_BYTES_MAX = 2 ** 26;
const TEXT_BYTES_MAX = 2 ** 26;
const SECTION_BYTES_MAX = 2 ** 32;
const NUMBER_MAX = 2 ** 32 - 1;
const KIND_DESCRIPTION = 0;
const KIND_CHUNK = 1;

/** Reads numbers of seven bits per byte, and fixed-size ones. Past the end, sets `isBroken` and returns zeros. */
export class NumberReader {
  constructor(bytes) {
    Object.assign(this, { bytes, at: 0, isBroken: false });
  }

  byte() {
    if (this.at >= this.bytes.length) this.isBroken = true;
    return this.isBroken ? 0 : this.bytes[this.at++];
  }

  fixed32() {
    let value = 0;
    for (let i = 0; i < 4; ++i) value += this.byte() * 2 ** (8 * i);
    return value;
  }

  number(most) {
    let value = 0;
    for (let shift = 0; shift < 49; shift += 7) {
      const next = this.byte();
      value += (next & 127) * 2 ** shift;
      if (next < 128) {
        if (value > most) this.isBroken = true;
        return this.isBroken ? 0 : value;
      }
    }
    this.isBroken = true;
    return 0;
  }
}

export class MptFile {
  /** Reads the index. */
  static async open(source) {
    const file = new MptFile(source);
    file.first = await source.read(0, FIRST_BYTES);
    await file.readIndex();
    return file;
  }

  constructor(source) {
    this.source = source;
    this.description = null; // section of the description
    this.chunks = new Map(); // sections by "layer:block"
  }

  refuse(what) {
    throw new FieldError(`${this.source.name}: ${what}`);
  }

  async readIndex() {
    const head = this.first.subarray(0, HEAD_BYTES);
    if (head.length < HEAD_BYTES) this.refuse(`has ${head.length} bytes, expected a packed field`);
    if (String.fromCharCode(...head.subarray(0, 4)) !== "MPTF")
      this.refuse("is not a packed field: it does not begin with MPTF");
    if (head[4] !== VERSION) this.refuse(`is a packed field of version ${head[4]}, expected ${VERSION}`);
    const reader = new NumberReader(head.subarray(5));
    const length = reader.fixed32();
    if (length > INDEX_BYTES_MAX)
      this.refuse(`is a packed field with an index of ${length} bytes, expected at most 2^26`);
    const end = HEAD_BYTES + length;
    if (this.first.length < end + 4 && this.source.size > this.first.length)
      this.first = await this.source.read(0, end + 4);
    if (this.first.length < end + 4) this.refuse("is damaged: cut short within its index");
    if (new NumberReader(this.first.subarray(end)).fixed32() !== sectionChecksum(this.first.subarray(0, end)))
      this.refuse("is damaged: the checksum of its index differs");
    this.readSections(new NumberReader(this.first.subarray(HEAD_BYTES, end)), end + 4);
  }

  readSections(reader, offset) {
    const count = reader.number(INDEX_BYTES_MAX);
    if (count > reader.bytes.length / 8) this.refuse("is damaged: its index contains fewer sections than it states");
    for (let i = 0; i < count; ++i) {
      const [kind, layer, block] = [0, 0, 0].map(() => reader.number(NUMBER_MAX));
      const section = { kind, layer, block, number: i, offset, length: reader.number(SECTION_BYTES_MAX) };
      section.checksum = reader.fixed32();
      offset += section.length;
      const name = `${layer}:${block}`;
      if (kind === KIND_CHUNK && !this.chunks.has(name)) this.chunks.set(name, section);
      if (kind === KIND_DESCRIPTION && name === "0:0") this.description ??= section;
    }
    if (reader.isBroken || reader.at < reader.bytes.length)
      this.refuse("is damaged: its index is longer or shorter than its sections");
    if (this.source.size !== null && this.source.size !== offset)
      this.refuse(`has ${this.source.size} bytes, but its index says ${offset}`);
    if (this.description === null) this.refuse("has no description");
  }

  /** Returns a section's bytes. `what` names the section in errors. */
  async section(section, what, signal) {
    const end = section.offset + section.length;
    const bytes = end <= this.first.length
      ? this.first.slice(section.offset, end) : await this.source.read(section.offset, section.length, signal);
    if (bytes.length !== section.length || sectionChecksum(bytes) !== section.checksum)
      this.refuse(`section ${section.number} (${what}) is damaged: its checksum differs`);
    return bytes;
  }

  /** Returns the object of docs/reference/packed_fields.md, "The description", not yet checked. */
  async descriptionObject() {
    const bytes = await this.section(this.description, "description");
    const reader = new NumberReader(bytes);
    const length = reader.number(TEXT_BYTES_MAX);
    if (reader.isBroken) this.refuse("its description does not state its length");
    const stream = new Blob([bytes.subarray(reader.at)]).stream().pipeThrough(new DecompressionStream("deflate"));
    const parts = [];
    let count = 0;
    try {
      for (const from = stream.getReader(); ;) {
        const { done, value } = await from.read();
        if (done) break;
        count += value.length;
        if (count > length) this.refuse("its description is longer than its stated length");
        parts.push(value);
      }
    } catch (error) {
      if (error instanceof FieldError) throw error;
      this.refuse("its description cannot be inflated");
    }
    if (count !== length) this.refuse("its description is shorter than its stated length");
    try {
      return JSON.parse(await new Blob(parts).text());
    } catch {
      return this.refuse("its description is not JSON");
    }
  }
}
