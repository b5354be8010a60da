// SPDX-License-Identifier: Apache-2.0
// Measures flicker and processor time of models that three.js draws in headless Chromium. PLAN.json is as for
// model_pictures.mjs, but has `view`, `frames` of a motion and `pairs` of times instead of views. Prints JSON by model:
// { motions: { zoom, pan, turn: { flicker, jump } }, seconds: [per frame], plainSeconds: [the same of the first model,
// each measured next to it], loadSeconds }. Exits with 77 (skipped) without a browser.
//
//   node model_motion.mjs PACKAGE PLAN.json
import { readdirSync, readFileSync } from "node:fs";
import path from "node:path";
import { pid } from "node:process";
import { executablePath, openPage } from "./addon_browser.mjs";

// The number of ticks per second, and the seconds that one measurement takes.
const MOTIONS = ["zoom", "pan", "turn"], TICKS = 100, SECONDS = 1.5;
const [packageFolder, planFile] = process.argv.slice(2);
const plan = JSON.parse(readFileSync(planFile, "utf8"));
const skip = (why) => { console.log(`skipped: ${why}`); process.exit(77); };
if (executablePath === undefined) skip("no Chromium (Debian package chromium-headless-shell)");
const { chromium } = await import("../service/web/node_modules/playwright-core/index.mjs").catch(() =>
  skip("no playwright-core: tools/install_dependencies test"));
const { page, complaints, close } = await openPage(chromium, { package: packageFolder, files: path.dirname(planFile),
  script: "model_page.js" });

/** { parent, seconds, isGpu } of every process. */
function processes() {
  const found = new Map();
  for (const name of readdirSync("/proc").filter((one) => /^\d+$/.test(one))) {
    try {
      const rest = readFileSync(`/proc/${name}/stat`, "utf8").split(") ").at(-1).split(" ");
      found.set(Number(name), { parent: Number(rest[1]), seconds: (Number(rest[11]) + Number(rest[12])) / TICKS,
        isGpu: readFileSync(`/proc/${name}/cmdline`, "utf8").includes("--type=gpu-process") });
    } catch { /* the process has ended */ }
  }
  return found;
}

/** Returns the processor seconds of the browser process that draws. */
function drawingSeconds() {
  const all = processes();
  const isOurs = (number) => number === pid || (all.has(number) && isOurs(all.get(number).parent));
  return [...all].filter(([number, one]) => one.isGpu && isOurs(number)).reduce((sum, [, one]) => sum + one.seconds, 0);
}

async function secondsOf(number, count) {
  const begin = drawingSeconds();
  await page.evaluate(([one, frames]) => globalThis.lab.repeat(one, "still", frames), [number, count]);
  return (drawingSeconds() - begin) / count;
}

async function times(models) {
  await page.evaluate((all) => globalThis.lab.hold(all), models); // loads everything before the measurements start
  const loads = await page.evaluate((all) => globalThis.lab.hold(all), models), counts = [];
  const found = loads.map((loadSeconds) => ({ loadSeconds, seconds: [], plainSeconds: [] }));
  for (let number = 0; number < models.length; ++number) {
    await secondsOf(number, 1); // compiles
    counts.push(Math.max(1, Math.ceil(SECONDS / Math.max(0.01, await secondsOf(number, 4)))));
  }
  for (let pair = 0; pair < plan.pairs; ++pair)
    for (let number = 1; number < models.length; ++number) {
      found[number].plainSeconds.push(await secondsOf(0, counts[0]));
      found[number].seconds.push(await secondsOf(number, counts[number]));
    }
  return found;
}

try {
  page.setDefaultTimeout(600000);
  const models = plan.models.map(({ file, ...ways }) => ({ url: `/files/${file}`, reach: plan.reach, ...ways }));
  await page.evaluate((model) => globalThis.lab.begin(model), { url: `/files/${plan.reference}`, reach: plan.reach });
  const names = (motion) => Array.from({ length: plan.frames }, (_, step) => `${motion} ${step}`);
  for (const motion of MOTIONS)
    for (let step = 0; step < plan.frames; ++step)
      await page.evaluate(async (view) => { await globalThis.lab.refer(view); },
        { ...plan.view, name: names(motion)[step], moved: { motion, step } });
  for (const model of models) await page.evaluate(async (one) => { await globalThis.lab.draw(one); }, model);
  const motions = models.map(() => ({}));
  for (const motion of MOTIONS)
    (await page.evaluate((all) => globalThis.lab.motion(all), names(motion))).forEach((found, number) => {
      motions[number][motion] = found;
    });
  await page.evaluate(async (view) => { await globalThis.lab.refer(view); },
    { ...plan.view, name: "still", samples: 1, grids: 0 });
  const timed = plan.pairs > 0 ? await times(models) : models.map(() => ({}));
  console.log(JSON.stringify({ models: models.map((_, number) => ({ motions: motions[number], ...timed[number] })),
    complaints }));
} finally {
  await close();
}
