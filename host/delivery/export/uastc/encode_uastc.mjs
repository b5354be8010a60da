// SPDX-License-Identifier: Apache-2.0
// Encodes texture levels as UASTC blocks with the npm package ktx2-encoder (Basis Universal, compiled to WebAssembly).
// Blocks are independent. Strips of a level can therefore be encoded on any number of threads, and the bytes are always
// the same.
//
//   node encode_uastc.mjs PLAN.json
//
// PLAN: {"encoder": FOLDER or "", "threads": 2, "effort": 1, "input": FILE, "output": FILE, "decoded": FILE, "levels":
// [{"width": 4, "height": 4}, ...]}. The input is RGBA of 8 bits, level after level (level_file.h). The output is rows
// of 16-byte blocks, level after level. "normals" is true for normal maps, for which blocks are chosen by the angle
// errors of the normals. "decoded" is optional. This file receives the decoded texels in the format of the input.
// Without "input", the script only searches for the package. Exit code 3 means that the package is missing.
import { closeSync, existsSync, openSync, readFileSync, readSync, writeSync } from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { Worker, isMainThread, workerData } from "node:worker_threads";

const STRIP_TEXELS = 1 << 17; // texels of a strip; the encoder accepts at most 12 million
const BLOCK_SIDE = 4;
const BLOCK_BYTES = 16;

// Lists folders that may contain the package. As in node, the order is the given folder, the parent folders, and the
// system folders.
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

// Returns the level of a KTX2 file that has one level.
function levelOf(file) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const LEVEL_COUNT = 40, LEVEL_INDEX = 80;
  if (view.getUint32(LEVEL_COUNT, true) !== 1) throw new Error("the encoder did not write exactly one level");
  const offset = Number(view.getBigUint64(LEVEL_INDEX, true));
  return file.subarray(offset, offset + Number(view.getBigUint64(LEVEL_INDEX + 8, true)));
}

// Decodes the texels of a KTX2 file with one level, using the package's own decoder.
async function texelsOf(file, { width, rows }, encoder) {
  const RGBA32 = 13; // a format code of the decoder
  const decoder = new (await encoder.init()).KTX2File(file);
  try {
    const texels = new Uint8Array(4 * width * rows);
    if (!decoder.startTranscoding() || !decoder.transcodeImage(texels, 0, 0, 0, RGBA32, 0, -1, -1))
      throw new Error("the encoder cannot decode its own file");
    return texels;
  } finally {
    decoder.close();
    decoder.delete();
  }
}

async function blocksOf(texels, { width, rows }, plan, basis) {
  const file = await basis.encode(texels, {
    isUASTC: true, isKTX2File: true, generateMipmap: false, needSupercompression: false, isPerceptual: false,
    isInputSRGB: false, isSetKTX2SRGBTransferFunc: false, uastcLDRQualityLevel: plan.effort,
    imageDecoder: async (data) => ({ data, width, height: rows }),
  });
  return { file, blocks: levelOf(file) };
}

// Returns the positions of a block's texels in a strip. Texels beyond the edge repeat the last texels, as in the
// encoder.
function texelsOfBlock({ width, rows }, block) {
  const columns = Math.ceil(width / BLOCK_SIDE);
  const [x, y] = [BLOCK_SIDE * (block % columns), BLOCK_SIDE * Math.floor(block / columns)];
  return Array.from({ length: 16 }, (_, i) =>
    Math.min(x + i % BLOCK_SIDE, width - 1) + width * Math.min(y + Math.floor(i / BLOCK_SIDE), rows - 1));
}

// Returns three numbers from -1 to 1 per texel, which form a vector of any length.
function vectorsAt(texels, places) {
  const made = new Float64Array(48);
  places.forEach((place, i) => { for (let c = 0; c < 3; ++c) made[3 * i + c] = texels[4 * place + c] / 127.5 - 1; });
  return made;
}

function normalized(v) {
  const made = new Float64Array(v.length);
  for (let i = 0; i < v.length; i += 3) {
    const length = Math.hypot(v[i], v[i + 1], v[i + 2]) || 1;
    for (let c = 0; c < 3; ++c) made[i + c] = v[i + c] / length;
  }
  return made;
}

// Returns the directions of a block's texels and of the points between four texels. The mean that a sampler computes at
// such a point depends on the lengths of the normals.
function directionsOf(v) {
  const all = new Float64Array(48 + 27);
  all.set(v);
  for (let y = 0, to = 48; y < 3; ++y)
    for (let x = 0; x < 3; ++x, to += 3)
      for (let c = 0; c < 3; ++c) {
        const at = 3 * (x + 4 * y) + c;
        all[to + c] = v[at] + v[at + 3] + v[at + 12] + v[at + 15];
      }
  return normalized(all);
}

function squaredAngles(one, other) {
  let sum = 0;
  for (let i = 0; i < one.length; ++i) sum += (one[i] - other[i]) ** 2;
  return sum;
}

// Returns the same directions with other lengths, which the encoder stores differently. The encoder minimizes the error
// of all three numbers. If the ends of all normals are on one plane, this error corresponds to an angle error. The
// plane is perpendicular to `axis`. Returns null if a normal is behind the plane.
function onPlane(v, axis) {
  const unit = normalized(v), made = new Float64Array(48);
  let most = 1;
  for (let i = 0; i < 48; i += 3) {
    const height = unit[i] * axis[0] + unit[i + 1] * axis[1] + unit[i + 2] * axis[2];
    if (height < 0.05) return null;
    for (let c = 0; c < 3; ++c) most = Math.max(most, Math.abs(made[i + c] = unit[i + c] / height));
  }
  return made.map((value) => value / most);
}

const sumOf = (v) => [0, 1, 2].map((c) => v.reduce((sum, value, i) => (i % 3 === c ? sum + value : sum), 0));

const PLANES = [
  (v) => onPlane(v, normalized(sumOf(v))),
  (v) => onPlane(v, [0, 0, 1]),
];

// Replaces blocks if another coding of the same normals has a lower angle error.
async function improveNormals(texels, strip, found, plan, basis) {
  const worth = 16 * (0.1 * Math.PI / 180) ** 2; // blocks with errors below 0.1 degrees are good enough
  const wanted = new Map();
  for (let block = 0; block < found.blocks.length / BLOCK_BYTES; ++block) {
    const places = texelsOfBlock(strip, block), v = vectorsAt(texels, places);
    const directions = directionsOf(v);
    const error = squaredAngles(directionsOf(vectorsAt(found.texels, places)), directions);
    if (error > worth) wanted.set(block, { places, v, directions, error });
  }
  const inRow = Math.min(wanted.size, STRIP_TEXELS >> 8), all = [...wanted];
  if (inRow === 0) return;
  const packed = { width: BLOCK_SIDE * inRow, rows: BLOCK_SIDE * Math.ceil(all.length / inRow) };
  for (const plane of PLANES) {
    const input = new Uint8Array(4 * packed.width * packed.rows).fill(255);
    all.forEach(([, { v }], i) => {
      const other = plane(v) ?? v;
      texelsOfBlock(packed, i).forEach((place, k) => {
        for (let c = 0; c < 3; ++c) input[4 * place + c] = Math.round(127.5 * (other[3 * k + c] + 1));
      });
    });
    const { file, blocks } = await blocksOf(input, packed, plan, basis), decoded = await texelsOf(file, packed, basis);
    all.forEach(([block, one], i) => {
      const places = texelsOfBlock(packed, i);
      const error = squaredAngles(directionsOf(vectorsAt(decoded, places)), one.directions);
      if (error >= one.error) return;
      one.error = error;
      found.blocks.set(blocks.subarray(BLOCK_BYTES * i, BLOCK_BYTES * (i + 1)), BLOCK_BYTES * block);
      one.places.forEach((place, k) => found.texels.set(decoded.subarray(4 * places[k], 4 * places[k] + 4), 4 * place));
    });
  }
}

async function work({ plan, encoder, strips, next }) {
  console.log = () => {}; // the encoder logs every slice
  const { NodeBasisEncoder } = await import(pathToFileURL(encoder).href);
  const basis = new NodeBasisEncoder();
  const input = openSync(plan.input, "r"), output = openSync(plan.output, "r+");
  const decoded = plan.decoded === undefined ? undefined : openSync(plan.decoded, "r+");
  for (let i; (i = Atomics.add(next, 0, 1)) < strips.length;) {
    const strip = strips[i];
    const texels = new Uint8Array(4 * strip.width * strip.rows);
    if (readSync(input, texels, 0, texels.length, strip.input) !== texels.length)
      throw new Error("the file of levels is cut short");
    const found = await blocksOf(texels, strip, plan, basis);
    if (found.blocks.length !== strip.bytes)
      throw new Error(`found ${found.blocks.length} bytes, expected ${strip.bytes}`);
    if (decoded !== undefined || plan.normals) found.texels = await texelsOf(found.file, strip, basis);
    if (plan.normals) await improveNormals(texels, strip, found, plan, basis);
    writeSync(output, found.blocks, 0, found.blocks.length, strip.output);
    if (decoded !== undefined) writeSync(decoded, found.texels, 0, texels.length, strip.input);
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
