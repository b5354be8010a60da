// SPDX-License-Identifier: Apache-2.0
// Prints what independent readers find in GLB files: the issues that gltf-validator reports, and the contents of each
// KTX2 image as ktx-parse reads them. The output is a JSON array with one object per file.
//
//   node gltf_reading.mjs FILE...
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

const require = createRequire(new URL("../../service/web/package.json", import.meta.url));
const validator = require("gltf-validator");
const { read } = await import(pathToFileURL(require.resolve("ktx-parse")).href);

function texturesOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (Buffer.from(bytes.subarray(0, 4)).toString() !== "glTF") return [];
  const length = view.getUint32(12, true);
  const json = JSON.parse(Buffer.from(bytes.subarray(20, 20 + length)).toString());
  const binary = bytes.subarray(28 + length);
  return (json.images ?? []).filter((image) => image.mimeType === "image/ktx2").map((image) => {
    const { byteOffset = 0, byteLength } = json.bufferViews[image.bufferView];
    const file = read(new Uint8Array(binary.subarray(byteOffset, byteOffset + byteLength)));
    const [descriptor] = file.dataFormatDescriptor;
    return { vkFormat: file.vkFormat, size: [file.pixelWidth, file.pixelHeight],
      supercompression: file.supercompressionScheme, model: descriptor.colorModel,
      primaries: descriptor.colorPrimaries, transfer: descriptor.transferFunction,
      block: [...descriptor.texelBlockDimension], samples: descriptor.samples.length,
      orientation: file.keyValue.KTXorientation,
      levels: file.levels.map((level) => level.uncompressedByteLength) };
  });
}

const found = [];
for (const path of process.argv.slice(2)) {
  const bytes = new Uint8Array(readFileSync(path));
  const fileOf = (uri) => join(dirname(path), decodeURIComponent(uri));
  const report = await validator.validateBytes(bytes, { uri: path,
    externalResourceFunction: async (uri) => new Uint8Array(readFileSync(fileOf(uri))) });
  const issues = (isOf) => report.issues.messages.filter(isOf).map((one) => `${one.code} ${one.pointer}`);
  found.push({ errors: report.issues.numErrors, warnings: report.issues.numWarnings,
    messages: issues(({ severity }) => severity < 2), infos: issues(({ severity }) => severity === 2),
    textures: texturesOf(bytes) });
}
console.log(JSON.stringify(found));
