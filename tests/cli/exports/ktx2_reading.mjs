// SPDX-License-Identifier: Apache-2.0
// Prints what ktx-parse, an independent reader, finds in KTX2 files: a JSON array with one object per file. The bytes
// of levels are in base64.
//
//   node tests/cli/exports/ktx2_reading.mjs FILE...
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const require = createRequire(new URL("../../service/web/package.json", import.meta.url));
const { read } = await import(pathToFileURL(require.resolve("ktx-parse")).href);

const text = (value) => (value instanceof Uint8Array ? Buffer.from(value).toString() : value);
const found = process.argv.slice(2).map((path) => {
  const file = read(new Uint8Array(readFileSync(path)));
  return {
    vkFormat: file.vkFormat,
    typeSize: file.typeSize,
    size: [file.pixelWidth, file.pixelHeight, file.pixelDepth],
    counts: [file.layerCount, file.faceCount],
    supercompression: file.supercompressionScheme,
    keys: Object.fromEntries(Object.entries(file.keyValue).map(([key, value]) => [key, text(value)])),
    descriptors: file.dataFormatDescriptor.map((one) => ({
      model: one.colorModel,
      primaries: one.colorPrimaries,
      transfer: one.transferFunction,
      flags: one.flags,
      block: [...one.texelBlockDimension],
      planes: [...one.bytesPlane],
      samples: one.samples.map((s) => [s.bitOffset, s.bitLength, s.channelType, s.sampleLower, s.sampleUpper]),
    })),
    levels: file.levels.map((level) => ({
      length: level.uncompressedByteLength,
      bytes: Buffer.from(level.levelData).toString("base64"),
    })),
  };
});
console.log(JSON.stringify(found));
