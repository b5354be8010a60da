// SPDX-License-Identifier: Apache-2.0
// Tests that Babylon.js in headless Chromium reads the half-float DDS files of multum export: every level must have the
// same 16-bit floats as the KTX2 file of the same export, as ktx-parse reads it. Babylon 9 refuses other DX10 formats
// with a message.
//
//   node tests/cli/exports/dds_in_babylon_test.mjs FOLDER_OF_PROGRAMS WORK_FOLDER
//
// Exits with 77 (skipped) without Chromium or npm's packages.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, rmSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [programs, work] = process.argv.slice(2);
const modules = fileURLToPath(new URL("../../service/web/node_modules/", import.meta.url));
const SIDE = 64;
const PATIENCE = 60000; // ms; the machine may be busy

const browserPath = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"].find(existsSync);
const packages = ["babylonjs", "ktx-parse", "playwright-core"];
if (browserPath === undefined || !packages.every((name) => existsSync(modules + name))) {
  console.log("no Chromium, or no babylonjs, ktx-parse and playwright-core: tools/install_dependencies test");
  process.exit(77);
}
const { chromium } = await import(modules + "playwright-core/index.mjs");
const { read } = await import(pathToFileURL(createRequire(modules).resolve("ktx-parse")).href);

function multum(...options) {
  const run = spawnSync(path.join(programs, "multum"), options, { cwd: work, encoding: "utf8" });
  assert.equal(run.status, 0, run.stderr);
}

function floatOfHalf(bits) {
  const exponent = (bits >> 10) & 31, fraction = bits & 1023, sign = bits & 0x8000 ? -1 : 1;
  return sign * (exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15));
}

const PAGE = `<!doctype html><canvas id="canvas"></canvas><script src="/babylon.js"></script><script>
  const engine = new BABYLON.Engine(document.getElementById("canvas"), false), scene = new BABYLON.Scene(engine);
  globalThis.levelsOf = async (url, count) => {
    const texture = await new Promise((resolve, reject) => {
      const made = new BABYLON.Texture(url, scene, false, false, BABYLON.Texture.TRILINEAR_SAMPLINGMODE,
        () => resolve(made), (message) => reject(new Error(message)));
    });
    const levels = [];
    for (let level = 0; level < count; ++level) levels.push([...await texture.readPixels(0, level)]);
    return { ...texture.getSize(), levels };
  };
</script>`;

rmSync(work, { recursive: true, force: true });
mkdirSync(work, { recursive: true });
multum("testmap", "map", "--size", `${SIDE}`);
for (const [name, texels] of [["half.dds", "rgba16f"], ["half.ktx2", "rgba16f"], ["bytes.dds", "rgba8"]])
  multum("export", "map_normal.png", "-o", name, "--texels", texels, "--no-measure", "--quiet");

const browser = await chromium.launch({ executablePath: browserPath, args: ["--no-sandbox", "--disable-dev-shm-usage",
  "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(PATIENCE);
  const said = [];
  page.on("console", (message) => said.push(message.text()));
  await page.route("**/*", async (route) => {
    const name = new URL(route.request().url()).pathname;
    if (name === "/") return route.fulfill({ contentType: "text/html", body: PAGE });
    const file = name === "/babylon.js" ? modules + "babylonjs/babylon.js" : path.join(work, path.basename(name));
    return existsSync(file) ? route.fulfill({ body: await readFile(file) }) : route.fulfill({ status: 404 });
  });
  await page.goto("http://files.test/");
  for (const texture of ["normal", "orm"]) {
    const container = read(new Uint8Array(await readFile(path.join(work, `half_${texture}.ktx2`))));
    const found = await page.evaluate(([url, count]) => globalThis.levelsOf(url, count),
      [`/half_${texture}.dds`, container.levels.length]);
    assert.deepEqual([found.width, found.height, found.levels.length], [SIDE, SIDE, 7]);
    container.levels.forEach(({ levelData }, level) => {
      const halves = new Uint16Array(levelData.slice().buffer);
      assert.equal(found.levels[level].length, halves.length);
      halves.forEach((bits, i) => assert.ok(Math.abs(found.levels[level][i] - floatOfHalf(bits)) < 1e-6,
        `${texture}, level ${level}, value ${i}: found ${found.levels[level][i]}, expected ${floatOfHalf(bits)}`));
    });
    console.log(`${texture}: ${container.levels.length} levels are those of the KTX2 file`);
  }
  await page.evaluate(() => globalThis.levelsOf("/bytes_normal.dds", 1).catch(() => null));
  assert.ok(said.some((line) => line.includes("Unsupported FourCC code: DX10")), said.join("\n"));
} finally {
  await browser.close();
}
