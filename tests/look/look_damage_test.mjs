// SPDX-License-Identifier: Apache-2.0
// Damages baked files and reads them with the decoder of multum look's page, without a browser. A finding is an error
// message that does not say what was found and what was expected, a number that is NaN or infinite, or a file that
// takes
// seconds.
//
//   node look_damage_test.mjs BIN_FOLDER [RUNS] [SEED]
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import vm from "node:vm";

const [bin, runs = "1000", seedText = String(Date.now() % 1e9)] = process.argv.slice(2);
const SLOW_MS = 5000; // a file of 16 x 16 texels takes some milliseconds, but the machine may be busy
const EXTREMES = [0, 1, -1, 2, 16, 255, 256, 65535, 0x7fffffff, -0x80000000, 0x7fc00000, 0x7f800000, 0x3f800000];
let state = Number(seedText) >>> 0;
console.log(`  seed ${state}`);
/** Returns a number from 0 to `count` - 1 by xorshift32 (Marsaglia 2003). */
const draw = (count) => {
  state = (state || 1) ^ (state << 13);
  state ^= state >>> 17;
  state = (state ^ (state << 5)) >>> 0;
  return state % count;
};

const decoder = new URL("../../runtime_gl/web/look/look_exr.js", import.meta.url);
globalThis.postMessage = () => {};
vm.runInThisContext(`${readFileSync(decoder, "utf8")}; globalThis.decodeExr = decodeExr;`);

const folder = mkdtempSync(path.join(os.tmpdir(), "multum-look-"));
const run = (...words) => execFileSync(path.join(bin, "multum"), words, { cwd: folder,
  stdio: ["ignore", "pipe", "pipe"] });
try {
  run("testmap", "map", "--size", "16");
  const files = ["none", "rle", "zip"].map((compression) => {
    run("bake", "map_normal.png", "-o", "map.ndf.exr", "--no-measure", "-q", "--lobes", "2", "--compression",
      compression, "--force");
    return readFileSync(path.join(folder, "map.ndf.exr"));
  });
  // Damages only bytes that the decoder reads: headers without their padding, tables, and tiles.
  const isRead = files.map((file) => {
    const [room, end] = [file.indexOf("[]   "), file.lastIndexOf("periodic,periodic\0\0")];
    return (at) => at < room || at > room + 33000 || at > end;
  });
  const counts = { read: 0, refused: 0 };
  for (let i = 0; i < Number(runs); ++i) {
    const which = draw(files.length);
    let bytes = Buffer.from(files[which]);
    for (let damage = draw(3); damage >= 0; --damage) {
      let at = draw(bytes.length - 8);
      while (!isRead[which](at)) at = draw(bytes.length - 8);
      const kind = draw(5);
      if (kind === 0) bytes[at] = draw(256);
      else if (kind === 1) bytes[at] ^= 1 << draw(8);
      else if (kind === 2) bytes.writeInt32LE(EXTREMES[draw(EXTREMES.length)], at);
      else if (kind === 3) bytes.copy(bytes, at, draw(bytes.length), bytes.length);
      else { bytes = bytes.subarray(0, 8 + at); break; }
    }
    const begin = performance.now();
    try {
      const decoded = await globalThis.decodeExr(new Uint8Array(bytes));
      for (const one of [decoded.normals ?? [], decoded.means]) assert.ok(one.every(Number.isFinite), `run ${i}`);
      counts.read += 1;
    } catch (error) {
      assert.match(error.message, /^found .*, expected /s, `run ${i}: ${error.stack}`);
      counts.refused += 1;
    }
    assert.ok(performance.now() - begin < SLOW_MS, `run ${i} takes ${performance.now() - begin} ms`);
  }
  console.log(`  ${counts.read} files were read, ${counts.refused} refused`);
  assert.ok(counts.read > 0 && counts.refused > Number(runs) / 4);
} finally {
  rmSync(folder, { recursive: true, force: true });
}
