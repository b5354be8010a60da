// SPDX-License-Identifier: Apache-2.0
// Draws models by three.js and @multum/three in headless Chromium. PLAN.json: { models: [{ file, lobes, points,
// options }], views: [of model_page.js, named] }, the first model the one that the reference is of, files beside the
// plan. Writes NAME.jpg of each view to OUT; prints JSON: by view, error and energy of each model. Exit code 77: no
// browser here.
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
const kept = plan.keep ?? {}; // by view, the file of its reference
const readKept = () => Object.fromEntries(Object.entries(kept).filter(([, file]) => existsSync(file))
  .map(([name, file]) => [name, JSON.parse(readFileSync(file, "utf8"))]));
try {
  page.setDefaultTimeout(600000);
  const models = plan.models.map(({ file, ...ways }) => ({ url: `/files/${file}`, reach: plan.reach, ...ways }));
  const reference = { url: `/files/${plan.reference ?? plan.models[0].file}`, reach: plan.reach };
  const known = readKept(), found = {};
  for (const view of plan.views) {
    const made = await page.evaluate(([model, one, before]) => globalThis.lab.prepare(model, [one], before),
      [reference, view, known]);
    const { pixels, ...rest } = made[view.name];
    if (kept[view.name] && !known[view.name]) writeFileSync(kept[view.name], JSON.stringify(made[view.name]));
    found[view.name] = { models: [], ...rest };
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
