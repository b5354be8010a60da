// SPDX-License-Identifier: Apache-2.0
// Decodes NAME.ndf.exr of vMF lobes (docs/reference/file_format.md) for a GPU, in a worker: the lobes in the layout of
// multum export --lobes --texels rgba16f (host/delivery/export/lobes/lobe_encoding.cpp), and the normals of level 0.
// Reads the part of OpenEXR ("OpenEXR File Layout", openexr.com) that multum writes: tiled parts with one level or mip
// levels, with 16-bit and 32-bit floats, and with the compressions none, RLE, ZIPS and ZIP. Checks all sizes in a file
// before it allocates memory for them.
//
//   magic, version | header of each part | 8 bytes per tile: its offset, parts and levels in order | tiles
//   tile: part (only in multi-part files), tile x, tile y, level x, level y, size: 4 bytes each | data
const EXR_MAGIC = [0x76, 0x2f, 0x31, 0x01];
const EXR_MULTI_PART = 0x1000, EXR_TILED = 0x200;
const EXR_PARTS_MAX = 32, EXR_ATTRIBUTES_MAX = 100, EXR_NAME_MAX = 255;
const EXR_SIDE_MAX = 2048; // same limit as in multum look, because the page holds a whole map
const EXR_TILE_MAX = 1024;
const EXR_VALUE_MAX = 1.01; // limit for values of lobes and normals, which are at most 1 before rounding
const EXR_COMPRESSIONS = ["none", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB"];
const EXR_HALF = 1, EXR_FLOAT = 2;
const PLAIN_UNPACKING = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 1, 1, 0, 0, 0, 0]; // channels x, y, a - z, a

const exrRefuse = (found, expected) => { throw new Error(`found ${found}, expected ${expected}`); };
const exrSide = (side, level) => Math.max(1, side >> level);
const exrLevels = (width, height) => 1 + Math.floor(Math.log2(Math.max(width, height)));

/** Reads bytes one after another. Throws at the end. */
class ExrCursor {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  take(count) {
    if (count > this.bytes.length - this.at) exrRefuse(`a file that ends after ${this.bytes.length} bytes`, "it whole");
    const from = this.at;
    this.at += count;
    return from;
  }

  word() { return this.view.getInt32(this.take(4), true); }

  text() {
    const from = this.at;
    while (this.bytes[this.take(1)] !== 0)
      if (this.at - from > EXR_NAME_MAX) exrRefuse(`a name of more than ${EXR_NAME_MAX} bytes`, "a header of OpenEXR");
    return new TextDecoder("latin1").decode(this.bytes.subarray(from, this.at - 1));
  }
}

/** Returns attributes by name, or null for the empty header that ends the headers. */
function exrHeader(cursor) {
  const attributes = new Map();
  for (let name = cursor.text(); name !== ""; name = cursor.text()) {
    const type = cursor.text(), size = cursor.word();
    if (size < 0 || attributes.size >= EXR_ATTRIBUTES_MAX || attributes.has(name))
      exrRefuse(`attribute ${name} twice, too many attributes or a negative size`, "a header of multum bake");
    const from = cursor.take(size);
    attributes.set(name, { type, bytes: cursor.bytes.subarray(from, from + size) });
  }
  return attributes.size === 0 ? null : attributes;
}

const exrWords = (bytes) => {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  return Array.from({ length: bytes.length >> 2 }, (_, i) => view.getInt32(4 * i, true));
};

/** Returns the bytes of attribute `name`, which must have type `type` and, if given, `size` bytes. */
function exrAttribute(attributes, name, type, size = undefined) {
  const found = attributes.get(name);
  if (found === undefined) exrRefuse(`no attribute ${name}`, "a file of multum bake");
  if (found.type !== type || (size !== undefined && found.bytes.length !== size))
    exrRefuse(`attribute ${name} of type ${found.type} and ${found.bytes.length} bytes`, type);
  return found.bytes;
}
const exrInt = (attributes, name) => exrWords(exrAttribute(attributes, name, "int", 4))[0];
const exrString = (attributes, name) =>
  new TextDecoder("latin1").decode(exrAttribute(attributes, name, "string")).replace(/ +$/, "");

/** Returns { name, type, bytes } of every channel, in the order of the file. */
function exrChannels(attributes) {
  const cursor = new ExrCursor(exrAttribute(attributes, "channels", "chlist"));
  const channels = [];
  for (let name = cursor.text(); name !== ""; name = cursor.text()) {
    const [type, , ...sampling] = [0, 1, 2, 3].map(() => cursor.word());
    if ((type !== EXR_HALF && type !== EXR_FLOAT) || sampling.some((one) => one !== 1) || channels.length >= 16)
      exrRefuse(`channel ${name} of type ${type}, every ${sampling.join(" and ")} texels`,
        "halfs or floats for every texel");
    channels.push({ name, type, bytes: 2 * type });
  }
  return channels;
}

/** Returns the layout of a part's data, and its map's `width` and `height` at its first level. */
function exrPart(attributes, width, height, levelCount) {
  const channels = exrChannels(attributes);
  const [left, top, right, bottom] = exrWords(exrAttribute(attributes, "dataWindow", "box2i", 16));
  if (left !== 0 || top !== 0 || right !== width - 1 || bottom !== height - 1)
    exrRefuse(`a data window from (${left}, ${top}) to (${right}, ${bottom})`, `one of ${width} x ${height}`);
  const compression = exrAttribute(attributes, "compression", "compression", 1)[0];
  if (compression > 3)
    exrRefuse(`compression ${EXR_COMPRESSIONS[compression] ?? compression}`, "none, RLE, ZIPS or ZIP (multum bake " +
      "--compression zip)");
  const tiles = exrAttribute(attributes, "tiles", "tiledesc", 9);
  const [tileWidth, tileHeight] = exrWords(tiles.subarray(0, 8)), mode = tiles[8];
  if (tileWidth < 1 || tileHeight < 1 || tileWidth > EXR_TILE_MAX || tileHeight > EXR_TILE_MAX)
    exrRefuse(`tiles of ${tileWidth} x ${tileHeight}`, `sides to ${EXR_TILE_MAX}`);
  if (mode !== (levelCount === 1 ? 0 : 1) && !(mode === 1 && width === 1 && height === 1))
    exrRefuse(`level mode ${mode}`, "mip-maps rounded down, and one level for the finest");
  const levels = Array.from({ length: levelCount }, (_, level) => {
    const [w, h] = [exrSide(width, level), exrSide(height, level)];
    return { width: w, height: h, across: Math.ceil(w / tileWidth), down: Math.ceil(h / tileHeight) };
  });
  return { channels, compression, tileWidth, tileHeight, levels,
    tileCount: levels.reduce((sum, { across, down }) => sum + across * down, 0) };
}

/** Returns a file's structure: data of its header, its parts by name, and the place of the tables of tiles. */
function exrPlan(bytes) {
  if (bytes.length < 8 || EXR_MAGIC.some((one, i) => bytes[i] !== one)) exrRefuse("no magic number of OpenEXR",
    "NAME.ndf.exr");
  const cursor = new ExrCursor(bytes);
  cursor.take(4);
  const version = cursor.word(), isMultiPart = (version & EXR_MULTI_PART) !== 0;
  if ((version & 0xff) !== 2 || (version & 0x800) !== 0 || (!isMultiPart && (version & EXR_TILED) === 0))
    exrRefuse(`version and flags ${version}`, "version 2, tiled or of several parts");
  const headers = [];
  for (let one = exrHeader(cursor); one !== null; one = isMultiPart ? exrHeader(cursor) : null)
    if (headers.push(one) > EXR_PARTS_MAX) exrRefuse(`more than ${EXR_PARTS_MAX} parts`, "a file of multum bake");
  if (headers.length === 0) exrRefuse("no header", "a file of multum bake");
  const [first] = headers;
  const representation = exrString(first, "multum:representation");
  if (representation !== "movmf") exrRefuse(`representation ${representation}`, "movmf: multum bake without --ndf");
  const formatVersion = exrInt(first, "multum:formatVersion");
  if (formatVersion !== 3)
    exrRefuse(`version ${formatVersion} of the format`, "3: lobes without roughness or weights in them");
  const [width, height, firstLevel, lobeCount] =
    ["mapWidth", "mapHeight", "firstLevel", "lobeCount"].map((name) => exrInt(first, `multum:${name}`));
  if (width < 1 || height < 1 || width > EXR_SIDE_MAX || height > EXR_SIDE_MAX)
    exrRefuse(`a map of ${width} x ${height}`, `sides of 1 to ${EXR_SIDE_MAX}`);
  const levelCount = exrLevels(width, height);
  if (levelCount < 2) exrRefuse("a map of one texel", "a map with more than one level");
  if (firstLevel < 0 || firstLevel >= levelCount) exrRefuse(`first level ${firstLevel}`, `0 to ${levelCount - 1}`);
  if (lobeCount < 1 || lobeCount > 8) exrRefuse(`${lobeCount} lobes`, "1 to 8");
  const lobesFrom = Math.max(firstLevel, 1), parts = new Map();
  let at = cursor.at;
  headers.forEach((header, number) => {
    // The part of a single-part file may have no name. It is then the only lobe.
    const name = isMultiPart ? exrString(header, "name") : "lobe.0";
    if (parts.has(name)) exrRefuse(`two parts ${name}`, "one of each name");
    const from = name === "finest" ? 0 : lobesFrom;
    const part = exrPart(header, exrSide(width, from), exrSide(height, from),
      name === "finest" ? 1 : levelCount - from);
    parts.set(name, { ...part, name, number, isMultiPart, tableAt: at });
    at += 8 * part.tileCount;
  });
  if (at > bytes.length) exrRefuse(`a file that ends after ${bytes.length} bytes`, "it whole");
  return { parts, width, height, firstLevel, lobesFrom, lobeCount, levelCount };
}

/** Inflates zlib's format to exactly `size` bytes. */
async function exrInflated(bytes, size) {
  const stream = new DecompressionStream("deflate");
  const writer = stream.writable.getWriter(), reader = stream.readable.getReader();
  Promise.allSettled([writer.write(bytes), writer.close()]); // the reader also throws these failures
  const read = () => reader.read().catch(() => exrRefuse("a tile that is not a complete zlib stream", "one"));
  const out = new Uint8Array(size);
  let at = 0;
  for (let one = await read(); !one.done; one = await read()) {
    if (one.value.length > size - at) {
      reader.cancel().catch(() => {});
      exrRefuse(`a tile of more than ${size} bytes`, `${size}`);
    }
    out.set(one.value, at);
    at += one.value.length;
  }
  if (at !== size) exrRefuse(`a tile of ${at} bytes`, `${size}`);
  return out;
}

/** Decodes run lengths: either a count -n and n bytes, or a count n and one byte that repeats n + 1 times. */
function exrUnrolled(bytes, size) {
  const out = new Uint8Array(size);
  let at = 0;
  for (let i = 0; i < bytes.length;) {
    const count = (bytes[i++] << 24) >> 24, length = count < 0 ? -count : count + 1;
    if (length > size - at || (count < 0 ? length > bytes.length - i : i >= bytes.length))
      exrRefuse(`run lengths of more than ${size} bytes, or cut off`, "a tile of RLE");
    if (count < 0) out.set(bytes.subarray(i, i + length), at);
    else out.fill(bytes[i], at, at + length);
    i += count < 0 ? length : 1;
    at += length;
  }
  if (at !== size) exrRefuse(`a tile of ${at} bytes`, `${size}`);
  return out;
}

/** Sums up differences, and interleaves the two halves, of even and of odd bytes. */
function exrTogether(bytes) {
  for (let i = 1; i < bytes.length; ++i) bytes[i] = bytes[i - 1] + bytes[i] - 128;
  const half = (bytes.length + 1) >> 1, out = new Uint8Array(bytes.length);
  for (let i = 0; i < bytes.length; ++i) out[i] = bytes[(i >> 1) + (i & 1) * half];
  return out;
}

async function exrTileBytes(data, compression, size) {
  if (data.length > size) exrRefuse(`a tile of ${data.length} bytes`, `${size} at most`);
  if (compression === 0 || data.length === size) return data.length === size ? data
    : exrRefuse(`a tile of ${data.length} bytes`, `${size}`);
  return exrTogether(compression === 1 ? exrUnrolled(data, size) : await exrInflated(data, size));
}

const EXR_FROM_HALF = Float64Array.from({ length: 65536 }, (_, bits) => {
  const exponent = (bits >> 10) & 31, fraction = bits & 1023, sign = bits & 0x8000 ? -1 : 1;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent === 0 ? fraction * 2 ** -24 : (1024 + fraction) * 2 ** (exponent - 25));
});

const exrFloat = new Float32Array(1), exrBits = new Uint32Array(exrFloat.buffer);
/** Returns the nearest 16-bit float, ties to even, of a value whose magnitude is at most 2. */
function exrHalf(value) {
  exrFloat[0] = Math.abs(value);
  const magnitude = exrBits[0], sign = value < 0 ? 0x8000 : 0;
  if (magnitude < 0x38800000) { // 16-bit floats below this value have steps of 2^-24; adding 1/2 rounds to them
    exrFloat[0] += 0.5;
    return sign | (exrBits[0] - 0x3f000000);
  }
  return sign | ((magnitude - 0x38000000 + 0xfff + ((magnitude >>> 13) & 1)) >>> 13);
}

/** Returns planes of the channels `wanted` of a level, by name. Calls `tick` after every tile. */
async function exrLevel(bytes, part, level, wanted, tick) {
  const { width, height, across, down } = part.levels[level];
  const planes = Object.fromEntries(wanted.map((name) => [name, new Float32Array(width * height)]));
  const texelBytes = part.channels.reduce((sum, one) => sum + one.bytes, 0);
  const file = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let table = part.tableAt + 8 * part.levels.slice(0, level).reduce((sum, one) => sum + one.across * one.down, 0);
  for (let y = 0; y < down; ++y)
    for (let x = 0; x < across; ++x, table += 8) {
      const place = Number(file.getBigUint64(table, true));
      const head = part.isMultiPart ? [part.number, x, y, level, level] : [x, y, level, level];
      const dataAt = place + 4 * head.length + 4;
      if (place < part.tableAt || dataAt > bytes.length)
        exrRefuse(`no offset of tile ${x}, ${y} of level ${level} of ${part.name}`, "a completely written file");
      head.forEach((one, i) => {
        if (file.getInt32(place + 4 * i, true) !== one)
          exrRefuse(`another tile at the offset of ${x}, ${y} of level ${level} of ${part.name}`, "it there");
      });
      const size = file.getInt32(dataAt - 4, true);
      if (size < 0 || size > bytes.length - dataAt)
        exrRefuse(`tile ${x}, ${y} of ${part.name} beyond the end of the file`, "it whole");
      const [left, top] = [x * part.tileWidth, y * part.tileHeight];
      const [w, h] = [Math.min(part.tileWidth, width - left), Math.min(part.tileHeight, height - top)];
      const tile = await exrTileBytes(bytes.subarray(dataAt, dataAt + size), part.compression, w * h * texelBytes);
      const view = new DataView(tile.buffer, tile.byteOffset, tile.byteLength);
      let at = 0;
      for (let row = top; row < top + h; ++row)
        for (const channel of part.channels) {
          const plane = planes[channel.name];
          const from = row * width + left;
          if (plane && channel.type === EXR_FLOAT)
            for (let i = 0; i < w; ++i) plane[from + i] = view.getFloat32(at + 4 * i, true);
          else if (plane) for (let i = 0; i < w; ++i) plane[from + i] = EXR_FROM_HALF[view.getUint16(at + 2 * i, true)];
          at += channel.bytes * w;
        }
      tick();
    }
  for (const name of wanted)
    for (const value of planes[name])
      if (!(Math.abs(value) <= EXR_VALUE_MAX)) exrRefuse(`${value} in channel ${name}`, "-1 to 1");
  return planes;
}

/** Writes x, y, s, a of a lobe's texels to `out` as 16-bit floats. s is chosen so that rounding keeps the spread. */
function exrEncodeLobe({ R, G, B, A }, out) {
  for (let i = 0; i < A.length; ++i) {
    const amplitude = exrHalf(Math.max(A[i], 0)), kept = EXR_FROM_HALF[amplitude];
    const scale = A[i] > 0 ? kept / A[i] : 0;
    const x = exrHalf(scale * R[i]), y = exrHalf(scale * G[i]);
    const [hx, hy] = [EXR_FROM_HALF[x], EXR_FROM_HALF[y]];
    const square = scale * scale * (R[i] ** 2 + G[i] ** 2 + B[i] ** 2) - hx * hx - hy * hy;
    const z = Math.sqrt(Math.max(square, 0));
    out[4 * i] = x;
    out[4 * i + 1] = y;
    out[4 * i + 2] = exrHalf(kept - (B[i] < 0 ? -z : z));
    out[4 * i + 3] = amplitude;
  }
}

/**
 * Returns { width, height, firstLevel, file, normals, means } of a file's bytes. `file` is as from parseLobes().
 * `normals` has x and y of level 0, or is null if the file leaves level 0 to the map. `means` has x and y of the first
 * stored level of lobes. Throws Error, which says what was found and expected.
 */
async function decodeExr(bytes, progress = () => {}) {
  const plan = exrPlan(bytes);
  const { parts, width, height, firstLevel, lobesFrom, lobeCount, levelCount } = plan;
  const partOf = (name, channels) => {
    const part = parts.get(name) ?? exrRefuse(`no part ${name}`, "this part, as multum bake writes it");
    for (const one of channels)
      if (!part.channels.some(({ name: found }) => found === one)) exrRefuse(`no channel ${one}`, `it in ${name}`);
    return part;
  };
  const axes = ["finest.normalX.X", "finest.normalY.X"];
  const finest = firstLevel === 0 ? partOf("finest", axes) : null;
  const lobes = Array.from({ length: lobeCount }, (_, j) => {
    const names = ["R", "G", "B", "A"].map((one) => `lobe${j}.vMF.${one}`);
    return { names, part: partOf(`lobe.${j}`, names) };
  });
  const total = lobes.reduce((sum, { part }) => sum + part.tileCount, finest?.tileCount ?? 0);
  let done = 0;
  const tick = () => progress(++done, total);
  let normals = null;
  if (finest !== null) {
    const planes = await exrLevel(bytes, finest, 0, axes, tick);
    normals = Float32Array.from({ length: 2 * width * height }, (_, i) => planes[axes[i & 1]][i >> 1]);
  }
  const [w, h] = [exrSide(width, lobesFrom), exrSide(height, lobesFrom)], means = new Float32Array(2 * w * h);
  const levels = Array.from({ length: levelCount - lobesFrom }, (_, level) =>
    new Uint16Array(4 * exrSide(w, level) * exrSide(h, level) * lobeCount));
  for (const [j, { names, part }] of lobes.entries())
    for (const [level, halves] of levels.entries()) {
      const planes = await exrLevel(bytes, part, level, names, tick);
      const [R, G, B, A] = names.map((name) => planes[name]);
      exrEncodeLobe({ R, G, B, A }, halves.subarray(4 * j * A.length, 4 * (j + 1) * A.length));
      if (level === 0) for (let i = 0; i < means.length; ++i) means[i] += (i & 1 ? G : R)[i >> 1];
    }
  const file = { format: 97, width: w, height: h, layers: lobeCount, levels: levels.map(({ buffer }) =>
    new Uint8Array(buffer)), keys: {}, lobes: { version: 1, mapWidth: width, mapHeight: height, firstLevel: lobesFrom,
    layersPerLobe: 1, lobes: lobes.map(() => ({})) }, unpacking: Float32Array.from(lobes.flatMap(() =>
    PLAIN_UNPACKING)) };
  return { width, height, firstLevel, file, normals, means };
}

globalThis.onmessage = async ({ data }) => {
  try {
    const decoded = await decodeExr(data, (done, total) => {
      if (done % 16 === 0) globalThis.postMessage({ done, total });
    });
    const buffers = [decoded.means, decoded.normals, ...decoded.file.levels].flatMap((one) => one?.buffer ?? []);
    globalThis.postMessage({ decoded }, buffers);
  } catch (error) {
    globalThis.postMessage({ error: errorText(error) });
  }
};
