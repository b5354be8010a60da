// SPDX-License-Identifier: Apache-2.0
// Draws two small models and two bumpy surfaces from `multum gltf --lobes` with three.js; with MULTUM_SWEEPS=all, four
// each. Compares plain mips, points, one lobe, several lobes, and the rule that spends evaluations on points or on
// lobes. All methods use the same number of evaluations. Checks which method has the lowest error, and by how much.
// Exits with 77 (skipped) if something is missing.
//
//   node models_test.mjs BIN_FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import { executablePath, openPage } from "./addon_browser.mjs";
import { writeModels, writeSurfaces } from "./bumpy_models.mjs";

const [bin] = process.argv.slice(2);
const skip = (why) => { console.log(`skipped: ${why}`); process.exit(77); };
if (executablePath === undefined) skip("no Chromium (Debian package chromium-headless-shell)");
const { chromium } = await import("../service/web/node_modules/playwright-core/index.mjs").catch(() =>
  skip("no playwright-core: tools/install_dependencies test"));

const TEXELS = 256;
const VIEW = { name: "far", distance: 5, direction: [0.3, 0.1, 1], angle: 45, width: 80, height: 100, samples: 8,
  frames: 1, edges: 4, light: [1, 1, 0.6], intensity: 3, room: 0.3, grids: 4 };
const NEAR = { ...VIEW, name: "near", angle: 1, grids: undefined }; // a texel covers many pixels
const USUAL = ["domes", "tower", "hammered_sphere", "flakes_sphere"];
const REACH = 1.2; // in metres, half of the diagonal of each model
const EVALUATIONS = 4;
const dressed = (name) => `${name}_dressed.glb`;
const ROWS = {
  plain: (name) => ({ file: `${name}.glb` }),
  points: (name) => ({ file: `${name}.glb`, points: EVALUATIONS }),
  one: (name) => ({ file: dressed(name) }),
  lobes: (name) => ({ file: dressed(name), lobes: true, options: { evaluations: EVALUATIONS, spend: "lobes" } }),
  rule: (name) => ({ file: dressed(name), lobes: true, options: { evaluations: EVALUATIONS } }),
};

const folder = mkdtempSync(path.join(os.tmpdir(), "multum-models-"));
const run = (...words) => execFileSync(path.join(bin, "multum"), words, { cwd: folder, encoding: "utf8",
  stdio: ["ignore", "pipe", "pipe"] });
const percent = (error) => `${(100 * error).toFixed(1)} %`;

/**
 * Returns { error, energy, lobed } by row, the noise of the floor and of the reference, and in `near` the errors of the
 * rows in a near view.
 */
async function measured(page, name) {
  await page.evaluate((model) => globalThis.lab.begin(model), { url: `/files/${name}.glb`, reach: REACH });
  const { floor, noise } = await page.evaluate((view) => globalThis.lab.refer(view), VIEW);
  await page.evaluate((view) => globalThis.lab.refer(view), NEAR);
  const found = { floor, noise, near: {} };
  for (const [row, asked] of Object.entries(ROWS)) {
    const { file, ...ways } = asked(name);
    const model = { url: `/files/${file}`, reach: REACH, ...ways };
    const { far, near } = await page.evaluate((asked) => globalThis.lab.draw(asked), model);
    found[row] = far;
    found.near[row] = near.error;
  }
  console.log(`  ${name}: ${Object.keys(ROWS).map((row) => `${row} ${percent(found[row].error)} ` +
    `(${found[row].energy.toFixed(3)})`).join(", ")}, floor ${percent(floor.error)}, noise ${percent(noise)}, ` +
    `near: ${Object.entries(found.near).map(([row, error]) => `${row} ${percent(error)}`).join(", ")}`);
  return found;
}

/** (error - floor) / (plain - floor). */
const share = (found, row) =>
  (found[row].error - found.floor.error) / (found.plain.error - found.floor.error);

// The rule's error may exceed the lower of the two errors of points and lobes by this number of percentage points. The
// goal is 0.3, which the listed models miss.
const RULE_ABOVE = { domes: 0.9, flakes_sphere: 0.5 }, RULE_GOAL = 0.3;
const ONE_GOAL = 0.2; // the number of percentage points by which the error of one lobe may exceed the error of plain
                      // mips
const SHARES_MOST = { // the largest allowed share of the gap between plain mips and the floor
  hammered_sphere: { one: 0.65, lobes: 0.3, rule: 0.3 }, flakes_sphere: { lobes: 0.65, rule: 0.65 },
  bricks_sphere: { one: 0.9, lobes: 0.5, rule: 0.5 }, water_sphere: { one: 0.8, lobes: 0.6, rule: 0.6 },
  domes: { one: 0.6, lobes: 0.2, rule: 0.2 }, barrel: { rule: 0.35 }, tower: { rule: 0.45 }, cover: { rule: 0.3 },
};

function check(name, found) {
  const above = (row, other) => 100 * (found[row].error - found[other].error);
  const holds = (value, most, what) =>
    assert.ok(value <= most, `${name}: ${what} ${value.toFixed(2)}, expected at most ${most}`);
  for (const row of Object.keys(ROWS)) holds(-above(row, "floor"), 0, `${row} below the floor by`);
  holds(Math.max(above("rule", "points"), above("rule", "lobes")), RULE_ABOVE[name] ?? RULE_GOAL,
    "points of the rule above the better of points and lobes");
  holds(above("one", "plain"), ONE_GOAL, "points of one lobe above plain mips");
  // On a strongly magnified map, three.js shades the map's own normals.
  for (const row of ["lobes", "rule"])
    holds(100 * Math.abs(found.near[row] - found.near.points), 0.02, `${row} from near differ from points by`);
  for (const [row, most] of Object.entries(SHARES_MOST[name] ?? {}))
    holds(share(found, row), most, `share of plain mips' error that ${row} keeps:`);
}

let browser;
try {
  const surfaces = writeSurfaces(folder, TEXELS).filter((name) => name.endsWith("_sphere"));
  const models = writeModels(folder, TEXELS);
  const names = [...models, ...surfaces].filter((name) => process.env.MULTUM_SWEEPS === "all" || USUAL.includes(name));
  run("shaders", "-o", "shaders");
  for (const name of names) run("gltf", `${name}.glb`, "--lobes", "--format", "rgba8", "-o", dressed(name));
  browser = await openPage(chromium, { package: path.join(folder, "shaders", "three"), files: folder,
    script: "model_page.js" });
  const found = {};
  for (const name of names) found[name] = await measured(browser.page, name);
  assert.deepEqual(browser.complaints, []);
  for (const name of names) check(name, found[name]);
} finally {
  if (browser) await browser.close();
  rmSync(folder, { recursive: true });
}
