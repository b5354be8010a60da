// SPDX-License-Identifier: Apache-2.0
// Reads KTX2 files of multum, and makes the mips that engines make of a map with one normal per texel
// (host/delivery/export/accuracy/export_rules.cpp).
// host/delivery/look joins these classic scripts to one script, so they have no imports.
const KTX2_IDENTIFIER = [0xab, 0x4b, 0x54, 0x58, 0x20, 0x32, 0x30, 0xbb, 0x0d, 0x0a, 0x1a, 0x0a];
const VK_R8 = 9, VK_RG8 = 16, VK_RGBA8 = 37, VK_RGBA16F = 97, VK_BC5 = 141;
const SIDE_MAX = 16384, LAYERS_MAX = 64;

const levelSize = (side, level) => Math.max(1, side >> level);
const levelCount = (width, height) => 1 + Math.floor(Math.log2(Math.max(width, height)));

function texelBytes(format, width, height) {
  if (format === VK_BC5) return 16 * Math.ceil(width / 4) * Math.ceil(height / 4);
  return width * height * { [VK_R8]: 1, [VK_RG8]: 2, [VK_RGBA8]: 4, [VK_RGBA16F]: 8 }[format];
}

/**
 * Returns { format, width, height, layers, levels: [Uint8Array], keys }. Throws Error with what was found and expected.
 */
function parseKtx2(bytes) {
  const refuse = (found, expected) => { throw new Error(`found ${found}, expected ${expected}`); };
  if (bytes.length < 80 || KTX2_IDENTIFIER.some((one, i) => bytes[i] !== one))
    refuse("no KTX2 identifier", "a KTX2 file");
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const word = (at) => view.getUint32(at, true);
  const [format, width, height, depth, layers, faces, count, scheme] = [12, 20, 24, 28, 32, 36, 40, 44].map(word);
  if (![VK_R8, VK_RG8, VK_RGBA8, VK_RGBA16F, VK_BC5].includes(format))
    refuse(`VkFormat ${format}`, "9, 16, 37, 97 or 141");
  if (width < 1 || height < 1 || width > SIDE_MAX || height > SIDE_MAX)
    refuse(`${width} x ${height}`, `sides to ${SIDE_MAX}`);
  if (depth !== 0 || faces !== 1 || layers > LAYERS_MAX) refuse("a volume, a cube or too many layers", "a 2D texture");
  if (count < 1 || count > levelCount(width, height)) refuse(`${count} levels`, `1 to ${levelCount(width, height)}`);
  if (scheme !== 0) refuse(`supercompression ${scheme}`, "none (multum export without --zstd)");
  if (bytes.length < 80 + 24 * count) refuse("a file cut in its level index", "it whole");
  const levels = [];
  for (let level = 0; level < count; ++level) {
    const [offset, length] = [0, 8].map((at) => Number(view.getBigUint64(80 + 24 * level + at, true)));
    const expected = Math.max(layers, 1) * texelBytes(format, levelSize(width, level), levelSize(height, level));
    if (length !== expected) refuse(`${length} bytes of level ${level}`, expected);
    if (offset + length > bytes.length) refuse(`level ${level} beyond the end of the file`, "it whole");
    levels.push(bytes.subarray(offset, offset + length));
  }
  const keys = {};
  const end = Math.min(word(56) + word(60), bytes.length);
  for (let at = word(56); at + 4 <= end;) {
    const length = word(at);
    if (length > end - at - 4) refuse("a key longer than the key/value data", "it whole");
    const text = new TextDecoder().decode(bytes.subarray(at + 4, at + 4 + length));
    const middle = text.indexOf("\0");
    keys[text.slice(0, middle)] = text.slice(middle + 1).replace(/\0+$/, "");
    at += 4 + 4 * Math.ceil(length / 4);
  }
  return { format, width, height, layers, levels, keys };
}

/** Reads lobes of multum export --lobes. Returns the texture and `lobes`, the JSON of its key. Throws Error. */
function parseLobes(bytes) {
  const texture = parseKtx2(bytes);
  if (texture.keys.multumLobes === undefined)
    throw new Error("found no key multumLobes, expected a KTX2 of multum export --lobes");
  const lobes = JSON.parse(texture.keys.multumLobes);
  if (lobes.meanCosine !== undefined)
    throw new Error("found roughness in the lobes, expected lobes of normals only, of a bake without --roughness");
  const numbers = lobes.lobes?.flatMap?.((one) => [...one.columns.flat(), ...one.offset]) ?? [];
  const whole = (value, low, high) => Number.isInteger(value) && value >= low && value <= high;
  if (lobes.version !== 1 || !whole(lobes.lobes?.length, 1, 8) || numbers.length !== 20 * lobes.lobes.length ||
      !numbers.every(Number.isFinite) || !whole(lobes.mapWidth, 2, SIDE_MAX) || !whole(lobes.mapHeight, 1, SIDE_MAX) ||
      !whole(lobes.firstLevel, 1, 15) || lobes.layersPerLobe !== (texture.format === VK_BC5 ? 2 : 1) ||
      texture.layers !== lobes.layersPerLobe * lobes.lobes.length ||
      texture.width !== levelSize(lobes.mapWidth, lobes.firstLevel) ||
      texture.height !== levelSize(lobes.mapHeight, lobes.firstLevel))
    throw new Error("found numbers of multumLobes that do not fit the texture, expected those of the export");
  return { ...texture, lobes, unpacking: new Float32Array(numbers) };
}

/** Averages a level's texels by coverage, four floats per texel. */
function halved({ width, height, texels }) {
  const [w, h] = [levelSize(width, 1), levelSize(height, 1)];
  const out = new Float32Array(4 * w * h);
  const covered = (from, to, i) => {
    const shares = [];
    for (let k = Math.floor(i * from / to); k < Math.min(from, Math.ceil((i + 1) * from / to)); ++k)
      shares.push([k, (Math.min(k + 1, (i + 1) * from / to) - Math.max(k, i * from / to)) * to / from]);
    return shares;
  };
  const columns = Array.from({ length: w }, (_, x) => covered(width, w, x));
  for (let y = 0; y < h; ++y)
    for (const [row, rowShare] of covered(height, h, y))
      for (let x = 0; x < w; ++x)
        for (const [column, share] of columns[x])
          for (let c = 0; c < 4; ++c) out[4 * (y * w + x) + c] +=
            rowShare * share * texels[4 * (row * width + column) + c];
  return { width: w, height: h, texels: out };
}

/** Returns x and y of RG8 normals. */
const normalsOfBytes = (rg) => Float32Array.from(rg, (one) => 2 * one / 255 - 1);

/** Computes mean normals (x, y, z, 1) of all levels from x and y of level 0. */
function meanNormals(width, height, normals) {
  const texels = new Float32Array(4 * width * height);
  for (let i = 0; i < width * height; ++i) {
    const [x, y] = [normals[2 * i], normals[2 * i + 1]];
    texels.set([x, y, Math.sqrt(Math.max(0, 1 - x * x - y * y)), 1], 4 * i);
  }
  const levels = [{ width, height, texels }];
  while (levels.length < levelCount(width, height)) levels.push(halved(levels.at(-1)));
  return levels;
}

const kappaOf = (length) => {
  const r = Math.min(length, 1 - 1e-9);
  return Math.min(1e9, Math.max(1e-9, (3 * r - r ** 3) / (1 - r * r)));
};

/** Functions that return the perceptual roughness in an engine, from a mean normal's length and the base roughness. */
const ENGINE_RULES = {
  unreal: ["Unreal", (length, roughness) => {
    const a2 = Math.max(roughness, 1e-3) ** 4;
    if (a2 >= 1) return 1;
    const b = 2 * Math.max(0, (1 - length) / length - 0.00004) * (a2 - 1);
    return Math.min(1, Math.max(0, (b - a2) / (b - 1))) ** 0.25;
  }],
  unity: ["Unity HDRP", (length, roughness) =>
    Math.min(1, roughness ** 4 + Math.min(0.5 / kappaOf(length), 0.04)) ** 0.25],
  godot: ["Godot", (length, roughness) =>
    Math.min(1, Math.sqrt(roughness ** 2 + Math.min(0.75 / kappaOf(length), 0.16)))],
  filament: ["Filament", (length, roughness) => Math.min(1, Math.sqrt(roughness ** 2 + 2 / kappaOf(length)))],
};

/** Makes RGBA8 levels of one normal and one perceptual roughness per texel, by the `rule` for lengths. */
function ruledLevels(means, base, rule) {
  return means.map(({ width, height, texels }) => {
    const bytes = new Uint8Array(texels.length);
    for (let i = 0; i < texels.length; i += 4) {
      const length = Math.min(1, Math.max(1e-6, Math.hypot(texels[i], texels[i + 1], texels[i + 2])));
      for (let c = 0; c < 3; ++c) bytes[i + c] = Math.round(127.5 + 127.5 * texels[i + c] / length);
      bytes[i + 3] = Math.round(255 * rule(length, base));
    }
    return { width, height, bytes };
  });
}

/** Makes the same levels from the one-lobe export's two textures. */
function exportedLevels(normals, roughness) {
  return normals.levels.map((rg, level) => {
    const bytes = new Uint8Array(2 * rg.length);
    for (let i = 0; i < rg.length / 2; ++i) {
      const [x, y] = [2 * rg[2 * i] / 255 - 1, 2 * rg[2 * i + 1] / 255 - 1];
      bytes.set([rg[2 * i], rg[2 * i + 1], Math.round(127.5 + 127.5 * Math.sqrt(Math.max(0, 1 - x * x - y * y))),
        roughness.levels[level][i]], 4 * i);
    }
    return { width: levelSize(normals.width, level), height: levelSize(normals.height, level), bytes };
  });
}
