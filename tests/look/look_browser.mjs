// SPDX-License-Identifier: Apache-2.0
// Contains the shared parts of the tests of multum look's page: programs in a folder of their own, headless Chromium,
// and open pages. Exits with code 77 (skipped) if something is missing.
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import { pathToFileURL } from "node:url";

const skip = (why) => { console.log(`skipped: ${why}`); process.exit(77); };

export async function startLook(bin) {
  const executablePath = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium",
    "/usr/local/bin/chromium"].find(existsSync);
  if (executablePath === undefined) skip("no Chromium (Debian package chromium)");
  if (!existsSync(path.join(bin, "multum-view"))) skip("no multum-view was built");
  const { chromium } = await import("../service/web/node_modules/playwright-core/index.mjs").catch(() =>
    skip("no playwright-core: tools/install_dependencies test"));
  const folder = mkdtempSync(path.join(os.tmpdir(), "multum-look-"));
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--headless=new",
    "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
  const complaints = []; // errors on pages, and requests to other hosts
  const inFolder = (name) => path.join(folder, name);
  const plainPage = async ({ before, ...options }) => {
    const context = await browser.newContext(options);
    if (before !== undefined) await context.addInitScript(before);
    const page = await context.newPage();
    page.setDefaultTimeout(60000);
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("request", (request) =>
      { if (!/^(data|blob|file):/.test(request.url())) complaints.push(request.url()); });
    return page;
  };
  return {
    plainPage,
    inFolder,
    complaints,
    run: (program, ...words) => execFileSync(path.join(bin, program), words, { cwd: folder, encoding: "utf8",
      stdio: ["ignore", "pipe", "pipe"], env: { ...process.env, DISPLAY: ":99" } }),
    // Pages draw half as many pixels per side as on a usual screen, because the tests draw without a GPU.
    open: async (file, hash = "", { width = 344, height = 700, deviceScaleFactor = 0.5, ...more } = {}) => {
      const page = await plainPage({ viewport: { width, height }, deviceScaleFactor, ...more });
      await page.goto(pathToFileURL(inFolder(file)).href + hash);
      // Polls with a timer, because some test pages have no animation frames.
      await page.waitForFunction(() => globalThis.multumLook?.frameMs !== undefined, undefined, { polling: 50 });
      await page.evaluate(() => { globalThis.multumLook.hasDrafts = false; });
      return page;
    },
    end: async () => {
      await browser.close();
      rmSync(folder, { recursive: true, force: true });
    },
  };
}

export const settled = (page) => page.evaluate(() => new Promise((resolve) =>
  requestAnimationFrame(() => requestAnimationFrame(resolve))));
/** Returns the page's text about its map, which appears with the next frame. */
export async function factsOf(page) {
  await page.evaluate(() => globalThis.multumLook.waiting);
  return page.textContent("#facts");
}
/** Puts `hash` into the page's address, and waits until the page has read it. */
export const goTo = (page, hash) => page.evaluate((text) => new Promise((resolve) => {
  if (location.hash.slice(1) === text) return resolve();
  addEventListener("hashchange", () => resolve(), { once: true });
  location.hash = text;
}), hash);
export const viewOf = (page) => page.evaluate(() => ({ ...globalThis.multumLook.view }));
export const pixelsOf = (page) => page.evaluate(() => document.getElementById("canvas").toDataURL());

/** Drops files, [name, bytes] each, onto the page and returns its message. */
export const drop = (page, ...files) => page.evaluate(async (list) => {
  await globalThis.multumLook.drops.take(list.map(([name, base64]) =>
    new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name)));
  return document.getElementById("problem").textContent;
}, files.map(([name, bytes]) => [name, bytes.toString("base64")]));
