// SPDX-License-Identifier: Apache-2.0
// Reads a dropped binary glTF as one list of triangles on which the page draws its map. The list has positions with z
// up, normals, and texture coordinates from the image's first row. The same data is read as by glb.js for the player,
// plus normals. The first normal map among the materials is the model's image.
const CORNERS_MAX = 3e6;
const MODEL_RADIUS = 0.6; // radius about the middle of the model's box, which the camera looks at
const MODEL_DISTANCE = 0.9; // distance at which a model of this radius fills the picture

class FieldError extends Error {} // error type of glb.js

class ModelGlb extends Glb {
  constructor(bytes) {
    super(bytes, "the model");
    this.corners = 0;
    // glb.js identifies objects by their names.
    this.entries("nodes").forEach((node, i) => { if (typeof node === "object" && node !== null) node.name = `${i}`; });
  }

  append(primitive, object, uvSet) {
    const attributes = primitive?.attributes;
    const counted = primitive?.indices ?? attributes?.POSITION;
    if (counted !== undefined) this.corners += this.entry("accessors", counted).count;
    if (!(this.corners <= CORNERS_MAX)) this.refuse(`has more than ${CORNERS_MAX / 3} triangles`);
    const before = object.positions.length / 3;
    super.append(primitive, object, uvSet);
    const count = object.positions.length / 3 - before;
    object.normals ??= [];
    if (count === 0) return;
    const given = attributes.NORMAL === undefined ? null : this.values(attributes.NORMAL, "VEC3", false);
    const indices = primitive.indices === undefined ? null : this.values(primitive.indices, "SCALAR", true);
    if (given !== null && given.length !== this.values(attributes.POSITION, "VEC3", false).length)
      this.refuse("has different numbers of normals and positions");
    for (let i = 0; i < count; ++i) {
      const index = indices === null ? i : indices[i];
      const flat = given === null ? flatNormal(object.positions, before + i - (i % 3)) : null;
      object.normals.push(...(flat ?? given.subarray(3 * index, 3 * index + 3)));
    }
  }

  /** Returns a Blob of the first normal map inside the file, or null. */
  normalImage() {
    const used = this.entries("materials").find((one) => one?.normalTexture !== undefined);
    if (used === undefined) return null;
    const texture = this.entry("textures", used.normalTexture.index);
    if (texture.source === undefined) return null; // the source is in an extension
    const image = this.entry("images", texture.source);
    if (image.bufferView === undefined) return null;
    const view = this.entry("bufferViews", image.bufferView), from = view.byteOffset ?? 0;
    const isSound = [from, view.byteLength].every((one) => Number.isInteger(one) && one >= 0) &&
      this.binary !== undefined && from + view.byteLength <= this.binary.length;
    if (!isSound) this.refuse("has an image beyond its buffer");
    return new Blob([this.binary.subarray(from, from + view.byteLength)], { type: String(image.mimeType ?? "") });
  }
}

/** Returns the normal of the triangle whose first corner is `corner`. */
function flatNormal(positions, corner) {
  const at = (k) => [0, 1, 2].map((c) => positions[3 * (corner + k) + c]);
  const [a, b, c] = [at(0), at(1), at(2)];
  const [u, v] = [b.map((one, i) => one - a[i]), c.map((one, i) => one - a[i])];
  return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
}

/**
 * Returns { vertices, count, image } of a file. A corner has eight floats: position, normal, u, v. Throws FieldError.
 */
function readModel(bytes, target) {
  const glb = new ModelGlb(bytes);
  const objects = [...glb.read(0).values()];
  const count = objects.reduce((sum, { uvs }) => sum + uvs.length / 2, 0);
  if (count === 0) glb.refuse("has no triangles");
  const vertices = new Float32Array(8 * count);
  let at = 0;
  for (const { objectToWorld: m, positions, normals, uvs } of objects) {
    const turned = (x, y, z, w) => [0, 1, 2].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r] * w);
    // Transforms normals by the cofactors, which stay correct if the scales along the axes differ.
    const cofactors = [0, 1, 2].map((c) => crossed([...m.slice(4 * ((c + 1) % 3), 4 * ((c + 1) % 3) + 3)],
      [...m.slice(4 * ((c + 2) % 3), 4 * ((c + 2) % 3) + 3)]));
    for (let i = 0; i < uvs.length / 2; ++i, at += 8) {
      const [x, y, z] = turned(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2], 1);
      const n = [0, 1, 2].map((r) => cofactors.reduce((sum, column, c) => sum + column[r] * normals[3 * i + c], 0));
      const size = Math.hypot(...n) || 1;
      vertices.set([x, -z, y, n[0] / size, -n[2] / size, n[1] / size, uvs[2 * i], 1 - uvs[2 * i + 1]], at);
    }
  }
  const box = [0, 1, 2].map((c) => {
    let [low, high] = [Infinity, -Infinity];
    for (let i = c; i < vertices.length; i += 8) {
      low = Math.min(low, vertices[i]);
      high = Math.max(high, vertices[i]);
    }
    return [low, high];
  });
  const radius = Math.hypot(...box.map(([low, high]) => (high - low) / 2));
  if (!(radius > 0 && radius < Infinity)) glb.refuse(`has a radius of ${radius}`);
  for (let i = 0; i < vertices.length; i += 8)
    for (let c = 0; c < 3; ++c)
      vertices[i + c] = target[c] + MODEL_RADIUS / radius * (vertices[i + c] - (box[c][0] + box[c][1]) / 2);
  return { vertices, count, image: glb.normalImage() };
}
