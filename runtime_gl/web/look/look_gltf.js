// SPDX-License-Identifier: Apache-2.0
// Joins a dropped JSON glTF and the files that it names to one binary glTF for look_glb.js. The buffers follow one
// another, and the image of the first normal map is included. The constants have the same values as in glb.js.
const GLTF_BYTES_MAX = 256e6; // limit for all files together

/** Returns the file name of a uri. A uri with an invalid encoding is not decoded. */
function nameOfUri(uri) {
  let path = uri;
  try {
    path = decodeURIComponent(uri);
  } catch { /* as it stands */ }
  return path.split("/").at(-1);
}

/** Returns the Set of file names that a glTF refers to. */
function filesOfGltf(json) {
  const uris = [json.buffers, json.images].flatMap((list) => (Array.isArray(list) ? list : [])).map((one) => one?.uri);
  return new Set(uris.filter((uri) => typeof uri === "string" && !uri.startsWith("data:")).map(nameOfUri));
}

/** Returns the JSON of a file's bytes. Throws Error if it is damaged. */
function parsedGltf(bytes) {
  let json = null;
  try {
    json = JSON.parse(new TextDecoder().decode(bytes));
  } catch { /* refused below */ }
  if (json === null || typeof json !== "object" || Array.isArray(json)) throw new Error("its JSON is damaged");
  return json;
}

/** Returns the bytes of `uri`: data in base64, or one of `files`, a Map of File by name. */
async function bytesOfUri(uri, files) {
  if (uri.startsWith("data:")) {
    const [head, data] = uri.split(",", 2);
    if (!head.endsWith(";base64") || data === undefined) throw new Error("has data that is not in base64");
    if (data.length / 4 * 3 > GLTF_BYTES_MAX) throw new Error(`has more than ${GLTF_BYTES_MAX / 1e6} MB of data`);
    const text = atob(data), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    return bytes;
  }
  const file = files.get(nameOfUri(uri));
  if (file === undefined)
    throw new Error(`names ${nameOfUri(uri)}, which was not dropped with it: drop all files together`);
  return bytesOfFile(file);
}

/** Joins the JSON and its files to a binary glTF. Throws Error for files that are missing, too large or too short. */
async function glbOfGltf(json, files) {
  if (json.asset?.version !== "2.0") throw new Error(`is glTF of version ${json.asset?.version}, expected 2.0`);
  const parts = [];
  let length = 0;
  const add = (bytes) => {
    const at = length;
    if (at + bytes.length > GLTF_BYTES_MAX)
      throw new Error(`has more than ${GLTF_BYTES_MAX / 1e6} MB of buffers and images, expected at most that`);
    parts.push([at, bytes]);
    length += bytes.length + (-bytes.length & 3);
    return at;
  };
  const list = (key) => (Array.isArray(json[key]) ? json[key] : []);
  const begins = [];
  for (const [i, buffer] of list("buffers").entries()) {
    if (typeof buffer?.uri !== "string") throw new Error(`its buffer ${i} names no file, expected one`);
    const bytes = await bytesOfUri(buffer.uri, files);
    if (!(bytes.length >= buffer.byteLength))
      throw new Error(`found ${bytes.length} bytes in its buffer ${i}, expected ${buffer.byteLength}`);
    begins.push([add(bytes), buffer.byteLength]);
  }
  const bufferViews = list("bufferViews").map((view) => {
    const [begin, end] = (Number.isInteger(view?.buffer) ? begins[view.buffer] : undefined) ?? [];
    if (begin === undefined) throw new Error(`names buffer ${view?.buffer}, of ${begins.length}`);
    const from = view.byteOffset ?? 0;
    if (!(from >= 0 && from + view.byteLength <= end)) throw new Error("has a view beyond its buffer");
    return { ...view, buffer: 0, byteOffset: begin + from };
  });
  const used = list("materials").find((one) => one?.normalTexture !== undefined);
  const source = list("textures")[used?.normalTexture?.index]?.source;
  const images = list("images").map((image) => ({ ...image }));
  if (typeof images[source]?.uri === "string") {
    const bytes = await bytesOfUri(images[source].uri, files);
    images[source].bufferView = bufferViews.length;
    bufferViews.push({ buffer: 0, byteOffset: add(bytes), byteLength: bytes.length });
  }
  return packedGlb({ ...json, bufferViews, images, buffers: [{ byteLength: length }] }, parts, length);
}

/** `parts` are the [place, bytes] of a binary chunk of `length` bytes. */
function packedGlb(json, parts, length) {
  const text = new TextEncoder().encode(JSON.stringify(json)), padded = text.length + (-text.length & 3);
  const bytes = new Uint8Array(28 + padded + length).fill(0x20, 20, 20 + padded), view = new DataView(bytes.buffer);
  [MAGIC, 2, bytes.length, padded, CHUNK_JSON].forEach((one, i) => view.setUint32(4 * i, one, true));
  bytes.set(text, 20);
  [length, CHUNK_BINARY].forEach((one, i) => view.setUint32(20 + padded + 4 * i, one, true));
  for (const [at, part] of parts) bytes.set(part, 28 + padded + at);
  return bytes;
}
