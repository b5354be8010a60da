// SPDX-License-Identifier: Apache-2.0
// Builds the site with tools/site and opens every page in headless Chromium, at widths of 360 and 1280 pixels, in light
// and dark mode. No page may scroll sideways, no picture or link may be dead, and no request may leave the site. The
// search must find the word "lobes" on pages from a server and on pages from a disk. Exits with 77 (skipped) if
// something is missing.
//
//   node site_browser_test.mjs OUTPUT_FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync } from "node:fs";
import http from "node:http";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { lowContrasts } from "../service/page_contrast.mjs";
import { misplaced } from "../service/page_layout.mjs";

const [output] = process.argv.slice(2).map((folder) => path.resolve(folder));
const site = path.join(output, "site"), screenshots = path.join(output, "screenshots");
const tools = fileURLToPath(new URL("../../tools", import.meta.url));
const skip = (why) => { console.log(`skipped: ${why}`); process.exit(77); };
const executablePath = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"].find(existsSync);
if (executablePath === undefined) skip("no Chromium: tools/install_dependencies test");
// The theme's folder on Debian 12 and on Debian 13.
const themes = ["/usr/share/mkdocs/themes/material", "/usr/lib/python3/dist-packages/material/templates"];
if (!themes.some(existsSync)) skip("no mkdocs-material: tools/install_dependencies site");
const { chromium } = await import("../service/web/node_modules/playwright-core/index.mjs").catch(() =>
  skip("no playwright-core: tools/install_dependencies test"));
const SIZES = [{ width: 360, height: 740 }, { width: 1280, height: 800 }];
const SCHEMES = ["light", "dark"];
const TYPES = { ".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".json": "application/json",
  ".svg": "image/svg+xml", ".png": "image/png", ".jpg": "image/jpeg", ".txt": "text/plain" };
// The test keeps screenshots of these pages, narrow in light colours and wide in dark colours.
const SHOWN = new Set(["index", "tutorials/engine_mips", "how-to/draw_lobes", "reference/commands",
  "reference/file_format", "explanation/accuracy", "evidence/ACCURACY", "contributing/ARCHITECTURE"]);
const screenshotOf = (name) => ({ path: path.join(screenshots, `${name.replace(/\W/g, "_")}.png`) });

execFileSync(path.join(tools, "site"), ["-o", site, "--no-install", "--no-check"], { stdio: "inherit" });
rmSync(screenshots, { recursive: true, force: true });
mkdirSync(screenshots, { recursive: true });
const files = readdirSync(site, { recursive: true }).filter((file) => statSync(path.join(site, file)).isFile());
const LIVE = "live.html"; // a page of multum look, in a frame of the first page; tests/look tests such pages
const pages = files.filter((file) => file.endsWith(".html") && file !== LIVE).sort();
assert.ok(pages.length > 20, `${pages.length} pages`);

// Matches addresses on other machines from which a file would be loaded. Pages may contain links to other machines. The
// script of the theme mentions http://a only to test how browsers parse addresses.
const FOREIGN = {
  ".html": /<(?:script|img|iframe|source|link)\b[^>]*(?:src|href)="(?:https?:)?\/\/[^"]*"/g,
  ".css": /url\(["']?(?:https?:)?\/\/[^)]*\)|@import[^;]*/g,
  ".js": /["'`]https?:\/\/(?!a\/?["'`]|a\/c%20d)[^"'`]*["'`]/g,
};
function foreignLoads() {
  const found = [];
  // The file contains the text of pages.
  for (const file of files.filter((one) => one !== path.join("search", "search_index.js"))) {
    const pattern = FOREIGN[path.extname(file)];
    if (pattern === undefined) continue;
    const text = readFileSync(path.join(site, file), "utf8").replace(/\/\*[^]*?\*\//g, "");
    found.push(...(text.match(pattern) ?? []).map((load) => `${file}: ${load}`));
  }
  return found;
}
assert.deepEqual(foreignLoads(), []);

const server = http.createServer((request, response) => {
  const name = decodeURIComponent(new URL(request.url, "http://site").pathname).slice(1) || "index.html";
  const file = path.join(site, path.normalize(name));
  if (!file.startsWith(site) || !existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.writeHead(200, { "content-type": TYPES[path.extname(file)] ?? "application/octet-stream",
    "cache-control": "max-age=600" });
  response.end(readFileSync(file));
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const served = `http://127.0.0.1:${server.address().port}/`;
const onDisk = `${pathToFileURL(site).href}/`;

const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--headless=new",
  "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-gpu-compositing"] });
const faults = new Set();

async function openContext(base, size, colorScheme) {
  const context = await browser.newContext({ viewport: size, colorScheme, reducedMotion: "reduce" });
  const page = await context.newPage();
  page.setDefaultTimeout(60000);
  const tell = (what) => faults.add(`${page.url().replace(base, "")}: ${what}`);
  page.on("request", (request) => {
    if (!request.url().startsWith(base) && !/^(data|blob|about):/.test(request.url()))
      tell(`requests ${request.url()}`);
  });
  page.on("requestfailed", (request) => {
    if (request.failure().errorText !== "net::ERR_ABORTED") tell(`${request.url()}: ${request.failure().errorText}`);
  });
  page.on("response", (response) => { if (response.status() >= 400) tell(`${response.status()} ${response.url()}`); });
  page.on("pageerror", (error) => tell(String(error)));
  page.on("console", (message) => { if (message.type() === "error") tell(message.text()); });
  return { context, page };
}

const anchors = new Map(); // for each page
const links = []; // [page, target] within the site

/** Checks the page that is open, at one width. */
async function check(page, name, size, colorScheme) {
  const tell = (what) => faults.add(`${name}, ${size.width} px, ${colorScheme}: ${what}`);
  const state = await page.evaluate(() => ({
    width: document.documentElement.scrollWidth,
    scheme: document.body.dataset.mdColorScheme,
    raw: document.querySelector("article").innerText.match(/\{ #[\w-]+ \}|^\|.*\|$|^```.*$/m)?.[0],
  }));
  if (state.width > size.width) tell(`the page is ${state.width} px wide`);
  if (state.scheme !== (colorScheme === "dark" ? "slate" : "default")) tell(`its colours are ${state.scheme}`);
  if (state.raw !== undefined) tell(`Markdown shows: ${state.raw}`);
  if (colorScheme === "light") (await misplaced(page, "article")).forEach(tell);
  if (size.width === 1280) (await lowContrasts(page)).found.forEach((what) => tell(`contrast ${what}`));
  const stem = name.replace(/\.html$/, "");
  if (SHOWN.has(stem) && (size.width === 360) === (colorScheme === "light"))
    await page.screenshot(screenshotOf(`${stem}_${size.width}_${colorScheme}`));
}

async function walk(colorScheme) {
  const { context, page } = await openContext(served, SIZES[0], colorScheme);
  // The search is tested on its own. On every page, it would index the whole site again.
  await context.route("**/workers/search.*.js", (route) => route.fulfill({ contentType: "text/javascript", body: "" }));
  // showMaterials() tests this page.
  await context.route(`**/${LIVE}*`, (route) => route.fulfill({ contentType: "text/html", body: "" }));
  for (const name of pages) {
    await page.setViewportSize(SIZES[0]);
    await page.goto(served + name);
    // When the script of the theme runs, it wraps tables so that they scroll.
    await page.waitForFunction(() => [...document.querySelectorAll("article table:not([class])")].every((table) =>
      table.closest(".md-typeset__scrollwrap") !== null));
    const content = await page.evaluate(async () => {
      document.querySelectorAll("details").forEach((one) => { one.open = true; });
      const images = [...document.images];
      images.forEach((image) => { image.loading = "eager"; });
      await Promise.all(images.map((image) => image.decode().catch(() => undefined)));
      return {
        dead: images.filter((image) => image.naturalWidth === 0).map((image) => image.src),
        ids: [...document.querySelectorAll("[id]")].map((one) => one.id),
        targets: [...document.querySelectorAll("a[href]")].map((one) => one.href),
      };
    });
    content.dead.forEach((source) => faults.add(`${name}, ${colorScheme}: no picture at ${source}`));
    anchors.set(name, new Set(content.ids));
    if (colorScheme === "light") links.push(...content.targets.map((target) => [name, target]));
    // A page is loaded once and then resized, as users resize their windows.
    for (const size of SIZES) {
      await page.setViewportSize(size);
      await check(page, name, size, colorScheme);
    }
  }
  await context.close();
}

/** Types a word into the search and follows the first result that shows it. */
async function search(base, size) {
  const { context, page } = await openContext(base, size, "light");
  await page.goto(`${base}index.html`);
  if (size.width < 960) await page.click("label.md-header__button[for=__search]");
  await page.click("input.md-search__input");
  await page.keyboard.type("lobes", { delay: 20 });
  // Results of "l" and "lo" appear first, and some versions of the theme show titles alone.
  const result = page.locator(".md-search-result__link").filter({ hasText: /lobe/i }).first();
  await result.waitFor();
  await page.screenshot(screenshotOf(`search_${base === onDisk ? "disk" : "server"}_${size.width}`));
  await Promise.all([page.waitForURL((url) => !url.pathname.endsWith("/index.html")), result.click()]);
  assert.match((await page.locator("article").textContent()).toLowerCase(), /lobes/);
  await context.close();
}

/** The first page shows materials live, on a server and from a disk. */
async function showMaterials(base) {
  const { context, page } = await openContext(base, SIZES[1], "light");
  await page.goto(`${base}index.html`);
  await page.locator("iframe.live").scrollIntoViewIfNeeded();
  const frame = page.frameLocator("iframe.live");
  await frame.getByText("Map of 256 x 256, 4 lobes.").waitFor();
  assert.equal(await frame.locator("#problem").isVisible(), false);
  assert.deepEqual(await frame.locator("#map option").allTextContents(), ["Hammered metal", "Car paint", "Bricks"]);
  await page.screenshot(screenshotOf(`live_${base === onDisk ? "disk" : "server"}`));
  await context.close();
}

/** The button changes the colours, and the next page keeps them. */
async function changeColours() {
  const { context, page } = await openContext(served, SIZES[1], "light");
  await page.goto(served + pages[0]);
  await page.click("label[title='Use dark colours']");
  await page.goto(served + pages[1]);
  assert.equal(await page.evaluate(() => document.body.dataset.mdColorScheme), "slate");
  await context.close();
}

try {
  await Promise.all(SCHEMES.map(walk));
  for (const size of SIZES) {
    await search(served, size);
    await search(onDisk, size);
  }
  for (const base of [served, onDisk]) await showMaterials(base);
  await changeColours();
  for (const [page, target] of links) {
    if (!target.startsWith(served)) continue;
    const { pathname, hash } = new URL(target);
    const name = decodeURIComponent(pathname).slice(1) || "index.html";
    if (!existsSync(path.join(site, name))) faults.add(`${page}: a link leads to ${name}, which does not exist`);
    else if (hash && name.endsWith(".html") && !anchors.get(name).has(decodeURIComponent(hash.slice(1))))
      faults.add(`${page}: a link leads to ${hash}, which ${name} does not have`);
  }
} finally {
  await browser.close();
  server.close();
}
[...faults].forEach((fault) => console.log(fault));
console.log(`${pages.length} pages, ${links.length} links, ${faults.size} faults; screenshots: ${screenshots}`);
process.exit(faults.size > 0 ? 1 : 0);
