// SPDX-License-Identifier: Apache-2.0
// Checks the description of a packed field (docs/reference/packed_fields.md, "The description"). The description may
// come from an untrusted file, and drawing code relies on every index and size.
import { FieldError } from "./byte_source.js";

const SIDE_MAX = 16384;
const SUPERSAMPLING_MAX = 8;
const SAMPLES_MAX = 65536;
const DIMENSIONS_MAX = 16;
const LAYERS_MAX = 16; // limit per object: texture units that every WebGL 2 has
const LIST_MAX = 1 << 20;

/** Reads values of the expected kind. Errors name the place, such as `objects[2].mesh`. */
class Checker {
  constructor(name) { this.name = name; }

  refuse(where, what) {
    throw new FieldError(`${this.name}: its description is damaged: ${where} ${what}`);
  }
  object(value, where) {
    if (value === null || typeof value !== "object" || Array.isArray(value)) this.refuse(where, "is not an object");
    return value;
  }
  list(value, where, least = 0, most = LIST_MAX) {
    if (!Array.isArray(value)) this.refuse(where, "is not a list");
    if (value.length < least || value.length > most)
      this.refuse(where, `has ${value.length} entries, expected ${least === most ? least : `${least} to ${most}`}`);
    return value;
  }
  text(value, where) {
    if (typeof value !== "string") this.refuse(where, "is not a string");
    return value;
  }
  integer(value, where, least, most) {
    if (!Number.isInteger(value) || value < least || value > most)
      this.refuse(where, `is ${JSON.stringify(value)}, expected ${least} to ${most}`);
    return value;
  }
  real(value, where) {
    if (typeof value !== "number" || !Number.isFinite(value)) this.refuse(where, "is not a finite number");
    return value;
  }
  reals(value, where, count) {
    return this.list(value, where, count, count).map((one) => this.real(one, where));
  }
  /** Converts rows to the sixteen numbers of a column-major matrix. */
  matrix(value, where) {
    const rows = this.list(value, where, 4, 4).map((row) => this.reals(row, where, 4));
    return Float64Array.from({ length: 16 }, (_, i) => rows[i % 4][i >> 2]);
  }
}

export class FieldDescription {
  constructor(json, fileName) {
    const check = new Checker(fileName);
    this.check = check;
    check.object(json, "it");
    this.geometry = check.text(json.geometry, "geometry");
    this.geometryHash = check.text(json.geometryHash, "geometryHash");
    this.uvSet = check.integer(json.uvSet, "uvSet", 0, 7);
    this.width = check.integer(json.width, "width", 1, SIDE_MAX);
    this.height = check.integer(json.height, "height", 1, SIDE_MAX);
    this.supersampling = check.integer(json.supersampling, "supersampling", 1, SUPERSAMPLING_MAX);
    this.parameters = check.list(json.parameters, "parameters", 1, DIMENSIONS_MAX)
      .map((name) => check.text(name, "parameters"));
    this.readSamples(json);
    this.layers = []; // numbered over all objects
    this.objects = check.list(json.objects, "objects", 1, 4096).map((entry, i) => this.readObject(entry, i));
    delete this.check;
  }

  readSamples(json) {
    const { check } = this;
    const dimensions = this.parameters.length;
    const views = check.list(json.views, "views", 1, SAMPLES_MAX).map((view) => check.matrix(view, "views"));
    const moves = check.list(json.moves, "moves", 1, SAMPLES_MAX).map((move) => new Map(
      Object.entries(check.object(move, "moves")).map(([name, matrix]) => [name, check.matrix(matrix, "moves")])));
    const samples = check.list(json.samples, "samples", 1, SAMPLES_MAX).map((entry) => {
      const [name, at, view, move] = check.list(entry, "samples", 4, 4);
      check.list(at, "samples", dimensions, dimensions).forEach((one) =>
        check.integer(one, "samples", 0, SAMPLES_MAX - 1));
      return {
        name: check.text(name, "samples"), at,
        worldToClip: views[check.integer(view, "samples", 0, views.length - 1)],
        moved: moves[check.integer(move, "samples", 0, moves.length - 1)],
      };
    });
    this.samples = samples;
    this.sizes = this.parameters.map((_, d) => 1 + samples.reduce((most, sample) => Math.max(most, sample.at[d]), 0));
    if (this.sizes.reduce((product, size) => product * size, 1) !== samples.length)
      check.refuse("samples", `are ${samples.length}, expected ${this.sizes.join(" x ")}`);
    this.sampleOfPosition = new Int32Array(samples.length).fill(-1);
    samples.forEach((sample, i) => { this.sampleOfPosition[this.positionOf(sample.at)] = i; });
    if (this.sampleOfPosition.includes(-1)) check.refuse("samples", "leave out a point of the grid");
  }

  positionOf(at) {
    return at.reduce((position, index, d) => position * this.sizes[d] + index, 0);
  }

  /** Returns the number of the sample at an index along each parameter. */
  sampleAt(at) { return this.sampleOfPosition[this.positionOf(at)]; }

  readObject(entry, i) {
    const { check } = this;
    const where = `objects[${i}]`;
    check.object(entry, where);
    const object = {
      name: check.text(entry.name, `${where}.name`),
      mesh: check.text(entry.mesh, `${where}.mesh`),
      anisotropy: Math.min(16, Math.max(1, check.real(entry.anisotropy, `${where}.anisotropy`))),
      mappings: check.list(entry.mappings, `${where}.mappings`)
        .map((one) => this.readMapping(one, `${where}.mappings`)),
      mappingOfSample: check.list(entry.mappingOfSample, `${where}.mappingOfSample`, this.samples.length,
        this.samples.length),
    };
    for (const number of object.mappingOfSample)
      check.integer(number, `${where}.mappingOfSample`, 0, object.mappings.length - 1);
    object.layers = check.list(entry.layers, `${where}.layers`, 0, LAYERS_MAX)
      .map((layer) => this.readLayer(layer, object, `${where}.layers`));
    return object;
  }

  readMapping(entry, where) {
    const { check } = this;
    check.object(entry, where);
    const wrap = (value) => {
      if (value !== "clamp" && value !== "periodic")
        check.refuse(where, `wraps by ${JSON.stringify(value)}, expected clamp or periodic`);
      return value;
    };
    const hasCut = check.list(entry.hasCut, where, 2, 2);
    return {
      linear: check.reals(entry.linear, where, 4), offset: check.reals(entry.offset, where, 2),
      hasCut: hasCut.map((one) => one === true), cut: check.reals(entry.cut, where, 2),
      wrapS: wrap(entry.wrapS), wrapT: wrap(entry.wrapT),
      width: check.integer(entry.width, where, 1, SIDE_MAX), height: check.integer(entry.height, where, 1, SIDE_MAX),
    };
  }

  readLayer(entry, object, where) {
    const { check } = this;
    check.object(entry, where);
    const layer = { name: check.text(entry.name, where), object, number: this.layers.length, blocks: [] };
    const unseen = new Set(check.list(entry.unseen, where).map((one) =>
      check.integer(one, where, 0, this.samples.length - 1)));
    // Each sample's block, and its texture in the block's chunk, or -1 if it has none.
    layer.blockOfSample = new Int32Array(this.samples.length).fill(-1);
    layer.textureOfSample = new Int32Array(this.samples.length);
    layer.isSeen = Uint8Array.from(this.samples, (_, i) => (unseen.has(i) ? 0 : 1));
    let covered = 0;
    check.list(entry.blocks, where).forEach((block) => { covered += this.readBlock(block, layer, where); });
    if (covered !== this.samples.length) check.refuse(where, "has blocks that leave samples out");
    this.layers.push(layer);
    return layer;
  }

  readBlock(entry, layer, where) {
    const { check } = this;
    const dimensions = this.sizes.length;
    const [begin, size, varying] = check.list(entry, where, 3, 3).map((one) => check.list(one, where, 0, dimensions));
    if (begin.length !== dimensions || size.length !== dimensions)
      check.refuse(where, "has a block of other dimensions");
    begin.forEach((one, d) => {
      check.integer(one, where, 0, this.sizes[d] - 1);
      check.integer(size[d], where, 1, this.sizes[d] - one);
    });
    varying.forEach((d, i) => check.integer(d, where, i === 0 ? 0 : varying[i - 1] + 1, dimensions - 1));
    const number = layer.blocks.length;
    const count = size.reduce((product, one) => product * one, 1);
    let mapping = -1;
    const at = [...begin];
    for (let k = 0; k < count; ++k) {
      const sample = this.sampleAt(at);
      if (layer.blockOfSample[sample] !== -1) check.refuse(where, "has blocks that share a sample");
      layer.blockOfSample[sample] = number;
      layer.textureOfSample[sample] = varying.reduce((texture, d) => texture * size[d] + at[d] - begin[d], 0);
      if (layer.isSeen[sample]) {
        const { mappings } = layer.object;
        const own = layer.object.mappingOfSample[sample];
        if (mapping >= 0 && (mappings[own].width !== mappings[mapping].width ||
            mappings[own].height !== mappings[mapping].height))
          check.refuse(where, "has a block of textures of several sizes");
        mapping = own;
      }
      for (let d = dimensions - 1; d >= 0 && ++at[d] === begin[d] + size[d]; --d) at[d] = begin[d];
    }
    const textures = varying.reduce((product, d) => product * size[d], 1);
    layer.blocks.push({ number, textures, mapping: mapping < 0 ? null : layer.object.mappings[mapping] });
    return count;
  }

  /** Returns the texture of a layer at a sample: `{ key, layer, block, texture }`, or null if the object has none. */
  textureOf(layer, sample) {
    if (!layer.isSeen[sample]) return null;
    const block = layer.blocks[layer.blockOfSample[sample]];
    const texture = layer.textureOfSample[sample];
    return { key: `${layer.number}:${block.number}:${texture}`, layer, block, texture };
  }
}
