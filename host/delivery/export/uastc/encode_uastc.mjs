// SPDX-License-Identifier: Apache-2.0
// Encodes levels of textures as UASTC blocks by the npm package ktx2-encoder (Basis Universal, compiled to
// WebAssembly). Blocks know nothing of one another, so levels are encoded by strips, on as many threads as are asked
// for, and the bytes are always the same.
//
//   node encode_uastc.mjs PLAN.json
//
// PLAN: {"encoder": FOLDER or "", "threads": 2, "effort": 1, "input": FILE, "output": FILE, "decoded": FILE, "levels":
// [{"width": 4, "height": 4}, ...]}. The input is RGBA of 8 bits, level after level (level_file.h);
// the output are blocks of 16 bytes in rows, level after level. "decoded", which may be missing, is a file that
// gets the blocks' texels in the form of the input. Without "input" the package is only looked for. Exit code 3: it is
// not there.
import { closeSync, existsSync, openSync, readFileSync, readSync, writeSync } from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { Worker, isMainThread, workerData } from "node:worker_threads";

const STRIP_TEXELS = 1 << 17; // of a thread's share at a time; the encoder takes at most 12 million
const BLOCK_SIDE = 4;
const BLOCK_BYTES = 16;

// Folders that may hold the package, in node's order: what was said, those above, those of the system.
function findEncoder(said) {
  const above = [];
  for (let at = process.cwd(); ; at = path.dirname(at)) {
    above.push(path.join(at, "node_modules"));
    if (at === path.dirname(at)) break;
  }
  const folders = said !== "" ? [said, path.join(said, "node_modules")] : [
    ...above,
    ...(process.env.NODE_PATH ?? "").split(path.delimiter).filter((folder) => folder !== ""),
    path.join(path.dirname(process.execPath), "../lib/node_modules"),
    "/usr/local/lib/node_modules", "/usr/lib/node_modules", "/usr/share/nodejs",
  ];
  for (const folder of folders)
    for (const place of [path.join(folder, "ktx2-encoder"), folder]) {
      const module = path.join(place, "dist/node/index.js");
      if (existsSync(module) && existsSync(path.join(place, "dist/basis/basis_encoder.wasm"))) return module;
    }
  return undefined;
}

function stripsOf(levels) {
  const strips = [];
  let input = 0;
  let output = 0;
  for (const { width, height } of levels) {
    const rowsAtOnce = Math.max(1, Math.floor(STRIP_TEXELS / width / BLOCK_SIDE)) * BLOCK_SIDE;
    const blocks = Math.ceil(width / BLOCK_SIDE);
    for (let row = 0; row < height; row += rowsAtOnce) {
      const rows = Math.min(rowsAtOnce, height - row);
      strips.push({ width, rows, input: input + 4 * width * row,
        output: output + BLOCK_BYTES * blocks * (row / BLOCK_SIDE),
        bytes: BLOCK_BYTES * blocks * Math.ceil(rows / BLOCK_SIDE) });
    }
    input += 4 * width * height;
    output += BLOCK_BYTES * blocks * Math.ceil(height / BLOCK_SIDE);
  }
  return strips;
}

// The only level of a KTX2 file with one.
function levelOf(file) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const LEVEL_COUNT = 40, LEVEL_INDEX = 80;
  if (view.getUint32(LEVEL_COUNT, true) !== 1) throw new Error("the encoder wrote other levels than one");
  const offset = Number(view.getBigUint64(LEVEL_INDEX, true));
  return file.subarray(offset, offset + Number(view.getBigUint64(LEVEL_INDEX + 8, true)));
}

// The texels of such a file, by the package's own decoder.
async function texelsOf(file, { width, rows }, encoder) {
  const RGBA32 = 13; // of its formats
  const decoder = new (await encoder.init()).KTX2File(file);
  try {
    const texels = new Uint8Array(4 * width * rows);
    if (!decoder.startTranscoding() || !decoder.transcodeImage(texels, 0, 0, 0, RGBA32, 0, -1, -1))
      throw new Error("the encoder cannot decode what it wrote");
    return texels;
  } finally {
    decoder.close();
    decoder.delete();
  }
}

async function work({ plan, encoder, strips, next }) {
  console.log = () => {}; // the encoder tells of each slice
  const { NodeBasisEncoder } = await import(pathToFileURL(encoder).href);
  const basis = new NodeBasisEncoder();
  const input = openSync(plan.input, "r"), output = openSync(plan.output, "r+");
  const decoded = plan.decoded === undefined ? undefined : openSync(plan.decoded, "r+");
  for (let i; (i = Atomics.add(next, 0, 1)) < strips.length;) {
    const strip = strips[i];
    const texels = new Uint8Array(4 * strip.width * strip.rows);
    if (readSync(input, texels, 0, texels.length, strip.input) !== texels.length) throw new Error("levels are cut");
    const file = await basis.encode(texels, {
      isUASTC: true, isKTX2File: true, generateMipmap: false, needSupercompression: false, isPerceptual: false,
      isInputSRGB: false, isSetKTX2SRGBTransferFunc: false, uastcLDRQualityLevel: plan.effort,
      imageDecoder: async (data) => ({ data, width: strip.width, height: strip.rows }),
    });
    const blocks = levelOf(file);
    if (blocks.length !== strip.bytes) throw new Error(`found ${blocks.length} bytes, expected ${strip.bytes}`);
    writeSync(output, blocks, 0, blocks.length, strip.output);
    if (decoded !== undefined) writeSync(decoded, await texelsOf(file, strip, basis), 0, texels.length, strip.input);
  }
  for (const descriptor of [input, output, decoded]) if (descriptor !== undefined) closeSync(descriptor);
}

if (isMainThread) {
  const plan = JSON.parse(readFileSync(process.argv[2], "utf8"));
  const encoder = findEncoder(plan.encoder);
  if (encoder === undefined) process.exit(3);
  if (plan.input !== undefined) {
    const strips = stripsOf(plan.levels);
    closeSync(openSync(plan.output, "w"));
    const shared = { plan, encoder, strips, next: new Int32Array(new SharedArrayBuffer(4)) };
    const count = Math.max(1, Math.min(plan.threads, strips.length));
    await Promise.all(Array.from({ length: count }, () => new Promise((resolve, reject) => {
      const worker = new Worker(new URL(import.meta.url), { workerData: shared });
      worker.once("error", reject);
      worker.once("exit", (code) => (code === 0 ? resolve() : reject(new Error(`a thread ended with ${code}`))));
    })));
  }
} else {
  await work(workerData);
}
