// SPDX-License-Identifier: Apache-2.0
// Draws models by three.js and @multum/three in headless Chromium. PLAN.json: { models: [{ file, lobes, points, options }], views: [of
// model_page.js, named] }, the first model the one that the reference is of, files beside the plan. Writes
// NAME.jpg of each view to OUT; prints JSON: by view, error and energy of each model. Exit code 77: no browser here.
//
//   node model_pictures.mjs PACKAGE PLAN.json OUT
import { readFileSync, writeFileSync } from "node:fs";
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
try {
  const models = plan.models.map(({ file, ...ways }) => ({ url: `/files/${file}`, ...ways }));
  const found = {};
  for (const { name, ...view } of plan.views) {
    page.setDefaultTimeout(600000);
    const drawn = await page.evaluate(([all, one]) => globalThis.lab.pictures(all, one), [models, view]);
    writeFileSync(path.join(out, `${name}.jpg`), Buffer.from(drawn.strip, "base64"));
    found[name] = { models: drawn.models, zoom: drawn.zoom };
  }
  console.log(JSON.stringify({ views: found, complaints }));
} finally {
  await close();
}
