// SPDX-License-Identifier: Apache-2.0
// Reads lobe textures for three.js, written by `multum export NAME.ndf.exr --lobes -o NAME.ktx2`
// (docs/reference/lobe_textures.md, "Lobes for GPUs"). three.js's KTX2Loader makes single-layer textures of such
// formats, so this module uses the parser inside it.
import { ClampToEdgeWrapping, CompressedArrayTexture, DataTexture, FileLoader, HalfFloatType, LinearFilter,
  LinearMipmapLinearFilter, Loader, LoaderUtils, MirroredRepeatWrapping, RED_GREEN_RGTC2_Format, RepeatWrapping,
  RGBAFormat, UnsignedByteType } from "three";
import { KHR_SUPERCOMPRESSION_NONE, KHR_SUPERCOMPRESSION_ZSTD, read, VK_FORMAT_BC5_UNORM_BLOCK,
  VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R8G8B8A8_UNORM } from "three/addons/libs/ktx-parse.module.js";
import { ZSTDDecoder } from "three/addons/libs/zstddec.module.js";
import { decodeBc5 } from "./bc5.js";
import { ggxLobeTable } from "./multum_lobes.js";

const SIDE_MAX = 16384, LOBES_MAX = 8;
const BYTES_OF_TEXEL = { [VK_FORMAT_R8G8B8A8_UNORM]: 4, [VK_FORMAT_R16G16B16A16_SFLOAT]: 8 };
// docs/reference/lobe_textures.md allows clamping instead of a black border.
const WRAPPING = { periodic: RepeatWrapping, clamp: ClampToEdgeWrapping, mirror: MirroredRepeatWrapping,
  black: ClampToEdgeWrapping };

const levelSize = (side, level) => Math.max(1, side >> level);
const isWhole = (value, low, high) => Number.isInteger(value) && value >= low && value <= high;

function levelBytes(format, width, height) {
  if (format === VK_FORMAT_BC5_UNORM_BLOCK) return 16 * Math.ceil(width / 4) * Math.ceil(height / 4);
  return width * height * BYTES_OF_TEXEL[format];
}

/** The table of GGX over lobes. All lobe textures share it, and it is disposed of with the last one. */
const sharedTable = {
  texture: null,
  users: 0,
  take() {
    if (this.users++ === 0) {
      const { width, height, data } = ggxLobeTable;
      this.texture = new DataTexture(data, width, height, RGBAFormat, HalfFloatType);
      this.texture.minFilter = this.texture.magFilter = LinearFilter;
      this.texture.needsUpdate = true;
    }
    return this.texture;
  },
  giveBack() {
    if (--this.users > 0) return;
    this.texture.dispose();
    this.texture = null;
  },
};

/** Lobes on the GPU, for any number of materials. */
export class LobeTexture {
  /** `facts` is the checked JSON of the file's key multumLobes. */
  constructor(texture, facts, layersPerLobe) {
    this.texture = texture;
    this.facts = facts;
    this.lobeCount = facts.lobes.length;
    this.layersPerLobe = layersPerLobe;
    this.firstLevel = facts.firstLevel;
    this.unpacking = new Float32Array(facts.lobes.flatMap((one) => [...one.columns.flat(), ...one.offset]));
    this.ggxTable = sharedTable.take();
    this.colours = null; // { texture, range, layersPerFour }: LobeLoader.parseColours()
  }

  /** Returns the number of bytes on the GPU, without the 8 KB of the table. */
  get byteCount() {
    const all = [...this.texture.mipmaps, ...(this.colours?.texture.mipmaps ?? [])];
    return all.reduce((sum, { data }) => sum + data.byteLength, 0);
  }

  /** Dispose of materials with these lobes first, or give them others. */
  dispose() {
    if (this.ggxTable === null) return;
    this.texture.dispose();
    this.colours?.texture.dispose();
    sharedTable.giveBack();
    this.ggxTable = null;
  }
}

/** Returns the JSON of a key. Its version must be 1. */
function jsonOf(container, key, refuse) {
  const text = container.keyValue[key];
  if (text === undefined) refuse(`no key ${key}`, "a KTX2 file of multum export --lobes or multum gltf --lobes");
  let facts;
  try {
    facts = JSON.parse(typeof text === "string" ? text : new TextDecoder().decode(text).replace(/\0+$/, ""));
  } catch (error) {
    refuse(`a key ${key} that is not JSON (${error.message})`, "that of the export");
  }
  if (facts?.version !== 1) refuse(`version ${facts?.version} of ${key}`, "1: is this package older than multum?");
  return facts;
}

function checkSides({ pixelWidth, pixelHeight, layerCount }, facts, refuse) {
  const sides = [facts.mapWidth, facts.mapHeight];
  if (!isWhole(facts.firstLevel, 1, 14) || !(facts.wrapS in WRAPPING) || !(facts.wrapT in WRAPPING))
    refuse(`first level ${facts.firstLevel}, wrap modes ${facts.wrapS} and ${facts.wrapT}`, "those of the export");
  if (!sides.every((side) => isWhole(side, 1, 2 * SIDE_MAX)) ||
      pixelWidth !== levelSize(facts.mapWidth, facts.firstLevel) ||
      pixelHeight !== levelSize(facts.mapHeight, facts.firstLevel))
    refuse(`${pixelWidth} x ${pixelHeight} texels in ${layerCount} layers`,
      `level ${facts.firstLevel} of a map of ${sides.join(" x ")}`);
}

function factsOf(container, refuse) {
  const facts = jsonOf(container, "multumLobes", refuse);
  if (facts.meanCosine !== undefined)
    refuse("roughness in the lobes (meanCosine)", "lobes of normals only, of a bake without --roughness");
  const isVector = (one) => Array.isArray(one) && one.length === 4 && one.every(Number.isFinite);
  const isLobe = (one) => Array.isArray(one?.columns) && one.columns.length === 4 && one.columns.every(isVector) &&
    isVector(one.offset);
  if (!Array.isArray(facts.lobes) || !isWhole(facts.lobes.length, 1, LOBES_MAX) || !facts.lobes.every(isLobe))
    refuse("lobes without four columns and an offset each", `1 to ${LOBES_MAX} with them`);
  checkSides(container, facts, refuse);
  const { pixelWidth, pixelHeight, layerCount, vkFormat } = container;
  const found = `${pixelWidth} x ${pixelHeight} texels in ${layerCount} layers`;
  const layers = (vkFormat === VK_FORMAT_BC5_UNORM_BLOCK ? 2 : 1) * facts.lobes.length;
  if (layerCount !== layers) refuse(found, `${layers} layers for ${facts.lobes.length} lobes`);
  return facts;
}

/** Checks the facts of colours that belong to `lobes`. */
function colourFactsOf(container, lobes, refuse) {
  const facts = jsonOf(container, "multumLobeColours", refuse);
  checkSides(container, facts, refuse);
  const own = lobes.facts, count = lobes.lobeCount, { vkFormat, layerCount } = container;
  if (facts.lobes !== count || facts.mapWidth !== own.mapWidth || facts.mapHeight !== own.mapHeight ||
      facts.wrapS !== own.wrapS || facts.wrapT !== own.wrapT)
    refuse(`colours of ${facts.lobes} lobes of a map of ${facts.mapWidth} x ${facts.mapHeight}`,
      `of ${count} of ${own.mapWidth} x ${own.mapHeight}, as the lobes have`);
  if (vkFormat !== VK_FORMAT_BC5_UNORM_BLOCK || layerCount !== 2 * Math.ceil(count / 4))
    refuse(`VkFormat ${vkFormat} in ${layerCount} layers`, `141 (BC5) in ${2 * Math.ceil(count / 4)}`);
  if (!(facts.range > 0 && Number.isFinite(facts.range))) refuse(`a range of ${facts.range}`, "a number above 0");
  return facts;
}

function checkShape({ vkFormat, pixelWidth, pixelHeight, pixelDepth, faceCount, levels }, refuse) {
  if (vkFormat !== VK_FORMAT_BC5_UNORM_BLOCK && !(vkFormat in BYTES_OF_TEXEL))
    refuse(`VkFormat ${vkFormat}`, "141 (BC5), 37 (RGBA8) or 97 (RGBA16F)");
  if (!isWhole(pixelWidth, 1, SIDE_MAX) || !isWhole(pixelHeight, 1, SIDE_MAX) || pixelDepth !== 0 || faceCount !== 1)
    refuse(`${pixelWidth} x ${pixelHeight} x ${pixelDepth} texels, ${faceCount} faces`,
      `a 2D texture with sides of at most ${SIDE_MAX}`);
  const most = 1 + Math.floor(Math.log2(Math.max(pixelWidth, pixelHeight)));
  if (!isWhole(levels.length, 1, most)) refuse(`${levels.length} levels`, `1 to ${most}`);
}

/** Returns the bytes of each level. Each level must have the length that the format requires. */
async function levelsOf(container, refuse) {
  const { levels, supercompressionScheme, vkFormat, pixelWidth, pixelHeight, layerCount } = container;
  let zstd = null;
  if (supercompressionScheme === KHR_SUPERCOMPRESSION_ZSTD) {
    zstd = new ZSTDDecoder();
    await zstd.init();
  } else if (supercompressionScheme !== KHR_SUPERCOMPRESSION_NONE) {
    refuse(`supercompression ${supercompressionScheme}`, "none or Zstandard");
  }
  return levels.map(({ levelData, uncompressedByteLength }, level) => {
    const [width, height] = [levelSize(pixelWidth, level), levelSize(pixelHeight, level)];
    const expected = layerCount * levelBytes(vkFormat, width, height);
    const lengthOf = (length) => {
      if (length !== expected) refuse(`${length} bytes of level ${level}`, `${expected}`);
    };
    lengthOf(zstd ? uncompressedByteLength : levelData.byteLength);
    const data = zstd ? zstd.decode(levelData, expected) : levelData;
    lengthOf(data.byteLength);
    return { data, width, height };
  });
}

function textureOf(levels, { vkFormat, layerCount }, facts, decodesBlocks) {
  const isBlocks = vkFormat === VK_FORMAT_BC5_UNORM_BLOCK && !decodesBlocks;
  const isHalf = vkFormat === VK_FORMAT_R16G16B16A16_SFLOAT;
  const mipmaps = isHalf ? levels.map(({ data, ...size }) => ({ data: new Uint16Array(data.slice().buffer), ...size }))
    : decodesBlocks ? levels.map(({ data, ...size }) =>
      ({ data: decodeBc5(data, size.width, size.height, layerCount, 2), ...size })) : levels;
  const texture = new CompressedArrayTexture(mipmaps, mipmaps[0].width, mipmaps[0].height,
    decodesBlocks ? layerCount / 2 : layerCount, isBlocks ? RED_GREEN_RGTC2_Format : RGBAFormat,
    isHalf ? HalfFloatType : UnsignedByteType);
  texture.minFilter = mipmaps.length > 1 ? LinearMipmapLinearFilter : LinearFilter;
  texture.magFilter = LinearFilter;
  texture.wrapS = WRAPPING[facts.wrapS];
  texture.wrapT = WRAPPING[facts.wrapT];
  texture.generateMipmaps = false;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

/**
 * Loads lobe textures: `load`, `loadAsync` and `parse` as in three.js's other loaders, with a LobeTexture as result.
 *
 *     const lobes = await new LobeLoader().detectSupport(renderer).loadAsync("bricks.ktx2");
 */
export class LobeLoader extends Loader {
  constructor(manager) {
    super(manager);
    this.hasBlocks = false; // without detectSupport(), BC5 is decoded, which works everywhere and takes twice the bytes
  }

  detectSupport(renderer) {
    this.hasBlocks = renderer.extensions.has("EXT_texture_compression_rgtc");
    return this;
  }

  load(url, onLoad, onProgress, onError) {
    const loader = new FileLoader(this.manager);
    loader.setPath(this.path).setResponseType("arraybuffer").setRequestHeader(this.requestHeader)
      .setWithCredentials(this.withCredentials);
    const fail = (error) => {
      if (onError) onError(error);
      else console.error(error);
      this.manager.itemError(url);
    };
    loader.load(url, (buffer) => this.parse(buffer, LoaderUtils.resolveURL(url, this.path)).then(onLoad, fail),
      onProgress, fail);
  }

  /** Parses a file's bytes. `name` appears in errors. Rejects with an Error that says what was found and expected. */
  async parse(buffer, name = "lobe texture") {
    const { texture, facts, isBlocks } = await this.textureAndFacts(buffer, name, factsOf);
    return new LobeTexture(texture, facts, isBlocks ? 2 : 1);
  }

  /** Gives `lobes` their colours from a file's bytes. Call it before addLobes(). Rejects in the same way as parse(). */
  async parseColours(buffer, lobes, name = "colours of lobes") {
    const { texture, facts, isBlocks } = await this.textureAndFacts(buffer, name, (container, refuse) =>
      colourFactsOf(container, lobes, refuse));
    lobes.colours = { texture, range: facts.range, layersPerFour: isBlocks ? 2 : 1 };
  }

  async textureAndFacts(buffer, name, factsFrom) {
    const refuse = (found, expected) => { throw new Error(`${name}: found ${found}, expected ${expected}`); };
    // Readers of KTX2 assume that an array's buffer ends with the array.
    const bytes = ArrayBuffer.isView(buffer) ? new Uint8Array(buffer).slice() : new Uint8Array(buffer);
    let container;
    try {
      container = read(bytes);
    } catch (error) {
      refuse(`a file that cannot be read (${error.message})`, "a whole KTX2 file of multum export --lobes");
    }
    checkShape(container, refuse);
    const facts = factsFrom(container, refuse);
    const levels = await levelsOf(container, refuse).catch((error) => {
      if (error.message.startsWith(name)) throw error;
      refuse(`levels that cannot be decompressed (${error.message})`, "the levels that the export wrote");
    });
    const isBc5 = container.vkFormat === VK_FORMAT_BC5_UNORM_BLOCK;
    // WebGL supports block compression only for sides that are multiples of the block size.
    const isWholeBlocks = container.pixelWidth % 4 === 0 && container.pixelHeight % 4 === 0;
    const decodes = isBc5 && !(this.hasBlocks && isWholeBlocks);
    return { texture: textureOf(levels, container, facts, decodes), facts, isBlocks: isBc5 && !decodes };
  }
}
