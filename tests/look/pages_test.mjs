// SPDX-License-Identifier: Apache-2.0
// Checks the other pages of multum and its tools in headless Chromium, in narrow windows and at a zoom of 200 %. No
// part may be cut, covered or beyond the window, no text may be "undefined", and the figures of the demo must add up.
// Exits with 77 (skipped) if something is missing.
//
//   node pages_test.mjs BIN_FOLDER SCREENSHOTS
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { startLook } from "./look_browser.mjs";
import { NARROW, misplaced } from "../service/page_layout.mjs";

const [bin, screenshots] = process.argv.slice(2);
const look = await startLook(bin);
const { inFolder, run, complaints } = look;
const root = fileURLToPath(new URL("../..", import.meta.url));
mkdirSync(screenshots, { recursive: true });

async function openPage(file, options) {
  const page = await look.plainPage(options);
  await page.goto(pathToFileURL(inFolder(file)).href);
  await page.waitForFunction(() => document.readyState === "complete");
  await page.evaluate(() => document.querySelectorAll("details:not(#player)").forEach((one) => { one.open = true; }));
  return page;
}

/**
 * Checks that each chart's bars add up to its title's stage, and that rows of pictures have as many columns as the
 * first.
 */
async function checkDemo() {
  const page = await openPage("demo/index.html", { viewport: { width: 1280, height: 800 } });
  const bakes = await page.evaluate(() => [...document.querySelectorAll("svg")].filter((svg) =>
    svg.querySelector("rect.bar")).map((svg) => ({
    whole: Number(svg.textContent.match(/fit, seconds: ([\d.]+) together/)[1]),
    bars: [...svg.querySelectorAll("rect.bar title")].map((one) => Number(one.textContent.match(/[\d.e-]+$/)[0])),
    words: svg.closest(".charts").previousElementSibling.previousElementSibling.textContent })));
  assert.ok(bakes.length >= 2);
  for (const { whole, bars, words } of bakes) {
    const sum = (list) => list.reduce((all, one) => all + one, 0);
    assert.ok(Math.abs(sum(bars) - whole) < 0.02 * whole + 0.006, `bars of ${sum(bars)} s, ${whole} together`);
    const [stages, command] = words.split("; the whole command took ");
    const seconds = stages.match(/[\d.]+(?=,|$)/g).map(Number);
    assert.ok(Math.abs(sum(seconds) - parseFloat(command)) < 0.05, words);
  }
  const rows = await page.evaluate(() => [...document.querySelectorAll("h3[id^=view-]")].map((head) => {
    const [shown, differences] = [head.nextElementSibling.nextElementSibling,
      head.nextElementSibling.nextElementSibling.nextElementSibling.querySelector(".pictures")];
    return [shown, differences].map((one) => [...one.children].map((figure) => {
      const [picture, caption] = [figure.querySelector("img"), figure.querySelector("figcaption")].map((part) =>
        part.getBoundingClientRect());
      return { left: Math.round(picture.left), isAbove: picture.bottom <= caption.top + 1 && picture.height > 50,
        name: figure.querySelector("b").textContent };
    }));
  }));
  assert.ok(rows.length >= 3);
  for (const [shown, differences] of rows) {
    assert.deepEqual(differences, shown); // each difference picture is below its picture
    assert.ok(shown.every(({ isAbove }) => isAbove));
  }
}

try {
  run("multum", "testmap", "map", "--size", "32");
  run("multum", "export", "map_normal.png", "-o", "map.ktx2", "--page", "export.html");
  run("multum", "tradeoff", "map_normal.png", "-o", "costs.html", "--quick", "--no-pictures", "--target-error", "0.3");
  execFileSync("python3", ["-c", "import sys; sys.path.insert(0, sys.argv[1]); import tiny_animation; " +
    "tiny_animation.write_animation(sys.argv[2], 0.25, noise=0.3)", path.join(root, "tests/service"), inFolder("")]);
  run("multum", "infer", "animation.toml", "-o", "inferred", "--context", "osmesa");
  execFileSync(path.join(root, "tools/demo"), ["--size", "16", "--no-install", "--bin", bin, "--output",
    inFolder("demo")], { stdio: ["ignore", "ignore", "inherit"] });
  await checkDemo();
  for (const file of ["export.html", "costs.html", "inferred/report.html", "demo/index.html"])
    for (const options of NARROW) {
      const page = await openPage(file, options);
      const name = `${file.split("/")[0].replace(".html", "")}_${options.viewport.width}`;
      await page.screenshot({ path: path.join(screenshots, `${name}.png`), fullPage: true });
      assert.deepEqual(await misplaced(page), [], name);
      assert.doesNotMatch(await page.evaluate(() => document.body.innerText), /undefined|\bNaN\b|\[object/, name);
    }
  assert.deepEqual(complaints, []);
} finally {
  await look.end();
}
