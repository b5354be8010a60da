// SPDX-License-Identifier: Apache-2.0
// Reads the levels of KTX2 files without the engines, and compares them with the levels on the GPU.
import { Buffer } from "node:buffer";
import { readFileSync } from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { createRequire } from "node:module";
import { ZSTDDecoder } from "../../../tests/service/web/node_modules/three/examples/jsm/libs/zstddec.module.js";
import { open } from "./browser.mjs";

const modules = new URL("../../../tests/service/web/node_modules/", import.meta.url);
const { read } = await import(pathToFileURL(createRequire(modules).resolve("ktx-parse")).href);
const RGBA8 = 37; // VK_FORMAT_R8G8B8A8_UNORM
const FORMATS = { 0x93b0: "ASTC 4x4", 0x8e8c: "BC7", 0x83f3: "BC3", 0x83f0: "BC1", 0x83f1: "BC1", 0x9278: "ETC2 RGBA8",
  0x9274: "ETC2 RGB8" };
const LINEAR_FILTERS = [9985, 9986, 9987]; // filters between or within mip levels; Filament's sampler replaces 9986

/** Returns the RGBA bytes of each level. */
async function levelsOf(browser, server, bytes) {
  const container = read(new Uint8Array(bytes));
  if (container.vkFormat === RGBA8) {
    const zstd = new ZSTDDecoder();
    await zstd.init();
    return container.levels.map(({ levelData, uncompressedByteLength }) =>
      (container.supercompressionScheme === 2 ? zstd.decode(levelData, uncompressedByteLength) : levelData));
  }
  const { page } = await open(browser, server, { module: "/engines/levels_page.js",
    scripts: ["/three/examples/jsm/libs/basis/basis_transcoder.js", "/engines/basis_levels.js"] });
  const texts = await page.evaluate((text) => globalThis.engine.levels(text), Buffer.from(bytes).toString("base64"));
  await page.close();
  return texts.map((text) => new Uint8Array(Buffer.from(text, "base64")));
}

export const levelsOfFile = (browser, server, file) => levelsOf(browser, server, readFileSync(file));

/** Returns the levels of a GLB's normal map and of its map of roughness and metalness. */
export async function levelsOfModel(browser, server, folder, name) {
  const glb = readFileSync(path.join(folder, name)), size = glb.readUInt32LE(12), found = [];
  const json = JSON.parse(glb.subarray(20, 20 + size)), [material] = json.materials;
  for (const { index } of [material.normalTexture, material.pbrMetallicRoughness.metallicRoughnessTexture]) {
    const texture = json.textures[index], source = texture.extensions?.KHR_texture_basisu?.source ?? texture.source;
    const { byteOffset = 0, byteLength } = json.bufferViews[json.images[source].bufferView];
    found.push(await levelsOf(browser, server, glb.subarray(28 + size + byteOffset).subarray(0, byteLength)));
  }
  return found;
}

const meanDifference = (a, b) => {
  let sum = 0;
  for (let i = 0; i < a.length; ++i) if (i % 4 !== 3) sum += Math.abs(a[i] - b[i]);
  return sum / (a.length * 0.75);
};

/**
 * Finds each file's levels among the textures of texture_levels.js. Returns, by file, { stored, read, filtered,
 * difference, format }: the numbers of levels in the file and on the GPU, and the largest mean difference of a level
 * (in codes of 8 bits).
 */
export function matchedLevels(textures, files) {
  const uploaded = textures.filter(({ generated }) => !generated).map((one) => ({ ...one,
    bytes: one.levels.map(({ texels }) => new Uint8Array(Buffer.from(texels, "base64"))) }));
  return files.map((levels) => {
    const [best] = uploaded.filter(({ bytes }) => bytes[0]?.length === levels[0].length)
      .sort((a, b) => meanDifference(a.bytes[0], levels[0]) - meanDifference(b.bytes[0], levels[0]));
    if (best === undefined) return { stored: levels.length, read: 0 };
    const same = best.bytes.filter((bytes, level) => bytes.length === levels[level]?.length);
    return { stored: levels.length, read: same.length, filtered: LINEAR_FILTERS.includes(best.minFilter),
      difference: Math.max(...same.map((bytes, level) => meanDifference(bytes, levels[level]))),
      format: FORMATS[best.levels[0].format] ?? (best.levels[0].format === undefined ? "RGBA8" :
        `0x${best.levels[0].format.toString(16)}`) };
  });
}
