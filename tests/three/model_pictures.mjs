// SPDX-License-Identifier: Apache-2.0
// Draws models by three.js and @multum/three in headless Chromium. PLAN.json: { reference, models: [{ file, lobes,
// points, options }], reach, views: [of model_page.js, named], keep, strips, surroundings }, with files next to the
// plan. The file `reference`, or else the first model, gives the reference. `keep` maps views to files that keep their
// references. `surroundings` is an EXR picture that replaces the room.
// Writes NAME.jpg of each view to OUT unless `strips` is false. Prints JSON by view: error and energy of each model,
// and with `grids` the floor and the reference's noise. Exits with 77 (skipped) without a browser.
//
//   node model_pictures.mjs PACKAGE PLAN.json OUT
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { executablePath, openPage } from "./addon_browser.mjs";

const [packageFolder, planFile, out] = process.argv.slice(2);
const plan = JSON.parse(readFileSync(planFile, "utf8"));
const skip = (why) => { console.log(`skipped: ${why}`); process.exit(77); };
if (executablePath === undefined) skip("no Chromium (Debian package chromium-headless-shell)");
const { chromium } = await import("../service/web/node_modules/playwright-core/index.mjs").catch(() =>
  skip("no playwright-core: tools/install_dependencies test"));
const { page, complaints, close } = await openPage(chromium, { package: packageFolder, files: path.dirname(planFile),
  script: "model_page.js" });
const keep = plan.keep ?? {}; // maps the name of each view to the file of its reference
try {
  page.setDefaultTimeout(600000);
  const models = plan.models.map(({ file, ...ways }) => ({ url: `/files/${file}`, reach: plan.reach, ...ways }));
  const reference = { url: `/files/${plan.reference ?? plan.models[0].file}`, reach: plan.reach };
  const found = {};
  if (plan.surroundings) await page.evaluate((file) => globalThis.lab.surround(`/files/${file}`), plan.surroundings);
  await page.evaluate((model) => globalThis.lab.begin(model), reference);
  for (const view of plan.views) {
    const file = keep[view.name], isKept = file !== undefined && existsSync(file);
    const made = await page.evaluate(([one, before]) => globalThis.lab.refer(one, before),
      [view, isKept ? JSON.parse(readFileSync(file, "utf8")) : null]);
    if (file !== undefined && !isKept) writeFileSync(file, JSON.stringify(made));
    found[view.name] = { models: [], ...made, pixels: undefined };
  }
  for (const model of models)
    for (const [name, one] of Object.entries(await page.evaluate((asked) => globalThis.lab.draw(asked), model)))
      found[name].models.push(one);
  for (const { name } of plan.views) {
    if (plan.strips === false) break;
    const { strip, zoom } = await page.evaluate((one) => globalThis.lab.side(one), name);
    writeFileSync(path.join(out, `${name}.jpg`), Buffer.from(strip, "base64"));
    found[name].zoom = zoom;
  }
  console.log(JSON.stringify({ views: found, complaints }));
} finally {
  await close();
}
