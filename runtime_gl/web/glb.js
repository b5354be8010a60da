// SPDX-License-Identifier: Apache-2.0
// Reads triangles by object from a binary glTF, with positions, one set of texture coordinates, and the names and
// places of nodes. Each triangle has its own three corners, because a vertex on a cut of the texture may have two
// texture coordinates. Rejects sparse accessors, compression and external files with an error that names them.
import { FieldError } from "./byte_source.js";
import { identity, multiplied } from "./matrices.js";

const MAGIC = 0x46546c67; // "glTF"
const CHUNK_JSON = 0x4e4f534a;
const CHUNK_BINARY = 0x004e4942;
const TRIANGLES = 4;
const COMPONENTS = new Map([ // keyed by glTF's numbers: the array type, and the value of 1.0 as a texture coordinate
  [5121, [Uint8Array, 255]], [5123, [Uint16Array, 65535]], [5125, [Uint32Array, 1]], [5126, [Float32Array, 1]],
]);
const WIDTHS = { SCALAR: 1, VEC2: 2, VEC3: 3 };
const REQUIRED_KNOWN = ["KHR_texture_transform", "KHR_materials_unlit"]; // extensions that do not affect triangles

class Glb {
  constructor(bytes, name) {
    this.name = name;
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    if (bytes.length < 20 || view.getUint32(0, true) !== MAGIC)
      this.refuse("is not a binary glTF (.glb); `multum pack --player` converts other scene files");
    if (view.getUint32(4, true) !== 2) this.refuse(`is glTF of version ${view.getUint32(4, true)}, expected 2`);
    if (view.getUint32(8, true) !== bytes.length)
      this.refuse(`has ${bytes.length} bytes, its head says ${view.getUint32(8, true)}`);
    for (let at = 12; at + 8 <= bytes.length;) {
      const length = view.getUint32(at, true);
      if (length > bytes.length - at - 8) this.refuse("is cut short within a chunk");
      const chunk = bytes.subarray(at + 8, at + 8 + length);
      if (view.getUint32(at + 4, true) === CHUNK_JSON) this.json ??= this.parsed(chunk);
      if (view.getUint32(at + 4, true) === CHUNK_BINARY) this.binary ??= chunk;
      at += 8 + length;
    }
    if (!this.json || typeof this.json !== "object" || Array.isArray(this.json)) this.refuse("has no JSON");
    const unknown = this.entries("extensionsRequired").filter((one) => !REQUIRED_KNOWN.includes(one));
    if (unknown.length > 0) this.refuse(`needs ${unknown.join(", ")}, which this player does not support`);
  }

  refuse(what) { throw new FieldError(`${this.name}: ${what}`); }

  parsed(chunk) {
    try {
      return JSON.parse(new TextDecoder().decode(chunk));
    } catch {
      return this.refuse("its JSON is damaged");
    }
  }

  entries(key, object = this.json) {
    const list = object[key] ?? [];
    if (!Array.isArray(list)) this.refuse(`its ${key} are not a list`);
    return list;
  }
  entry(key, index) {
    const list = this.entries(key);
    if (!Number.isInteger(index) || index < 0 || index >= list.length || typeof list[index] !== "object" ||
        list[index] === null)
      this.refuse(`names ${key}[${index}], of ${list.length}`);
    return list[index];
  }

  /** Returns the accessor's values as numbers. Integer texture coordinates are scaled to 0..1. */
  values(index, type, isIndex) {
    const accessor = this.entry("accessors", index);
    if (accessor.sparse !== undefined) this.refuse(`accessors[${index}] is sparse, which this player does not read`);
    if (accessor.type !== type) this.refuse(`accessors[${index}] is ${accessor.type}, expected ${type}`);
    const [List, most] = COMPONENTS.get(accessor.componentType) ??
      this.refuse(`accessors[${index}] has an unknown type of numbers`);
    const width = WIDTHS[type];
    const count = accessor.count;
    const view = this.entry("bufferViews", accessor.bufferView);
    if ((view.buffer ?? 0) !== 0 || this.entries("buffers")[0]?.uri !== undefined || !this.binary)
      this.refuse("has buffers in other files, which this player does not read");
    const size = List.BYTES_PER_ELEMENT;
    const stride = view.byteStride ?? width * size;
    const begin = (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    const isSound = [count, stride, begin].every((one) => Number.isInteger(one) && one >= 0) &&
      stride >= width * size && (count === 0 || begin + (count - 1) * stride + width * size <= this.binary.length);
    if (!isSound) this.refuse(`accessors[${index}] extends beyond its buffer`);
    const bytes = new DataView(this.binary.buffer, this.binary.byteOffset, this.binary.byteLength);
    const get = { 1: "getUint8", 2: "getUint16", 4: List === Uint32Array ? "getUint32" : "getFloat32" }[size];
    const values = isIndex ? new Uint32Array(count) : new Float32Array(count * width);
    for (let i = 0; i < count; ++i)
      for (let c = 0; c < width; ++c) {
        const value = bytes[get](begin + i * stride + c * size, true);
        if (!Number.isFinite(value)) this.refuse(`accessors[${index}] has a number that is not finite`);
        values[i * width + c] = isIndex ? value : value / most;
      }
    return values;
  }

  nodeMatrix(node) {
    const numbers = (list, count) => {
      if (!Array.isArray(list) || list.length !== count || !list.every(Number.isFinite))
        this.refuse("has a node whose transform is not numeric");
      return list;
    };
    if (node.matrix !== undefined) return Float64Array.from(numbers(node.matrix, 16));
    const [x, y, z, w] = numbers(node.rotation ?? [0, 0, 0, 1], 4);
    const scale = numbers(node.scale ?? [1, 1, 1], 3);
    const place = numbers(node.translation ?? [0, 0, 0], 3);
    const columns = [
      [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
      [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
      [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]];
    return Float64Array.from([...columns.flatMap((column, i) => [...column.map((one) => one * scale[i]), 0]),
      ...place, 1]);
  }

  /** Adds a primitive's corners to the lists of an object. */
  append(primitive, object, uvSet) {
    if ((primitive?.mode ?? TRIANGLES) !== TRIANGLES) return;
    const attributes = primitive?.attributes;
    if (attributes?.POSITION === undefined) return;
    if (attributes[`TEXCOORD_${uvSet}`] === undefined)
      this.refuse(`object '${object.name}' has no texture coordinates of set ${uvSet} (TEXCOORD_${uvSet})`);
    const positions = this.values(attributes.POSITION, "VEC3", false);
    const uvs = this.values(attributes[`TEXCOORD_${uvSet}`], "VEC2", false);
    const count = positions.length / 3;
    if (uvs.length / 2 !== count)
      this.refuse(`object '${object.name}' has ${uvs.length / 2} texture coordinates and ${count} vertices`);
    const indices = primitive.indices === undefined
      ? Uint32Array.from({ length: count }, (_, i) => i) : this.values(primitive.indices, "SCALAR", true);
    for (let i = 0; i + 2 < indices.length; i += 3)
      for (const index of indices.subarray(i, i + 3)) {
        if (index >= count)
          this.refuse(`object '${object.name}' has a triangle with vertex ${index}, expected one below ${count}`);
        object.positions.push(...positions.subarray(3 * index, 3 * index + 3));
        object.uvs.push(uvs[2 * index], 1 - uvs[2 * index + 1]); // v grows downwards in glTF
      }
  }

  read(uvSet) {
    const objects = new Map();
    const scene = this.json.scenes === undefined ? null : this.entry("scenes", this.json.scene ?? 0);
    const children = new Set(this.entries("nodes").flatMap((_, i) => this.entries("children", this.entry("nodes", i))));
    const roots = this.entries("nodes").map((_, i) => i).filter((i) => !children.has(i));
    const open = (scene === null ? roots : this.entries("nodes", scene)).map((index) => [index, identity()]);
    const visited = new Set();
    while (open.length > 0) {
      const [index, parent] = open.pop();
      if (visited.has(index)) this.refuse(`has nodes[${index}] in two places, or inside itself`);
      visited.add(index);
      const node = this.entry("nodes", index);
      const objectToWorld = multiplied(parent, this.nodeMatrix(node));
      for (const child of this.entries("children", node)) open.push([child, objectToWorld]);
      if (node.mesh === undefined) continue;
      const mesh = this.entry("meshes", node.mesh);
      const object = { name: String(node.name ?? mesh.name ?? ""), objectToWorld, positions: [], uvs: [] };
      for (const primitive of this.entries("primitives", mesh)) this.append(primitive, object, uvSet);
      if (object.positions.length === 0) continue;
      if (!objectToWorld.every(Number.isFinite))
        this.refuse(`object '${object.name}' has a transform matrix that is not finite`);
      if (objects.has(object.name)) this.refuse(`object '${object.name}' appears twice`);
      objects.set(object.name, object);
    }
    return objects;
  }
}

/**
 * Returns objects by name: `{ name, objectToWorld, positions, uvs }`. Each triangle has three corners; v grows upwards.
 */
export function readGlb(bytes, name, uvSet) { return new Glb(bytes, name).read(uvSet); }

/** Maps the texture coordinates of all corners by a mapping of the description. Returns [corners][2] of the texture. */
export function mappedCorners(uvs, mapping) {
  const { linear: [a, b, c, d], offset, hasCut, cut } = mapping;
  const corners = new Float32Array(uvs.length);
  for (let t = 0; t < uvs.length; t += 6) {
    // Shifts the triangle by whole periods, so that it is on the right side of a cut. If the triangle straddles a cut,
    // its middle determines the side.
    const shift = [0, 1].map((axis) => {
      if (!hasCut[axis]) return 0;
      const values = [uvs[t + axis], uvs[t + 2 + axis], uvs[t + 4 + axis]];
      return -Math.floor(0.5 * (Math.min(...values) + Math.max(...values)) - cut[axis]);
    });
    for (let k = t; k < t + 6; k += 2) {
      const u = uvs[k] + shift[0];
      const v = uvs[k + 1] + shift[1];
      corners[k] = a * u + b * v + offset[0];
      corners[k + 1] = c * u + d * v + offset[1];
    }
  }
  return corners;
}
