// SPDX-License-Identifier: Apache-2.0
// Opens the page of an engine in headless Chromium, with a server on this machine.
import { createReadStream, existsSync, statSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { executablePath } from "../../../tests/three/addon_browser.mjs";

const HERE = fileURLToPath(new URL(".", import.meta.url)), ROOT = path.join(HERE, "../../..");
const THREE = path.join(ROOT, "tests/service/web/node_modules/three");
const TYPES = { ".js": "text/javascript", ".mjs": "text/javascript", ".json": "application/json", ".html": "text/html",
  ".wasm": "application/wasm", ".png": "image/png" };
const PATIENCE = 300000; // ms; software rendering on a busy machine is slow
const IMPORTS = { three: "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/",
  playcanvas: "/modules/playcanvas/build/playcanvas.mjs" };

/** Serves the engines, three.js, these pages and `files` under /files/. Returns { origin, close }. */
export async function serve(files) {
  const roots = { modules: path.join(HERE, "node_modules"), three: THREE, engines: HERE, files,
    tests: path.join(ROOT, "tests/three") };
  const pages = new Map();
  const server = createServer((request, response) => {
    const name = decodeURIComponent(new URL(request.url, "http://server").pathname.slice(1));
    const [root, ...rest] = name.split("/");
    if (pages.has(name)) return response.writeHead(200, { "content-type": "text/html" }).end(pages.get(name));
    const file = Object.hasOwn(roots, root) && !rest.includes("..") ? path.join(roots[root], ...rest) : "";
    if (!existsSync(file) || !statSync(file).isFile()) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": TYPES[path.extname(file)] ?? "application/octet-stream" });
    return createReadStream(file).pipe(response);
  });
  await new Promise((resolve) => { server.listen(0, "127.0.0.1", resolve); });
  return { pages, origin: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

/** Starts Chromium with software rendering. */
export async function launch() {
  if (executablePath === undefined) throw new Error("no Chromium: install the package chromium-headless-shell");
  const { chromium } = await import("../../../tests/service/web/node_modules/playwright-core/index.mjs").catch(() => {
    throw new Error("no playwright-core: run tools/install_dependencies test");
  });
  return chromium.launch({ executablePath, args: ["--no-sandbox", "--headless=new", "--disable-dev-shm-usage",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"] });
}

/**
 * Opens the page of an engine: `scripts` are plain scripts that run before the module `module`. Returns { page,
 * complaints }.
 */
export async function open(browser, server, { module, scripts = [], before = "" }) {
  const html = `<!doctype html><meta charset="utf-8"><style>body { margin: 0; background: #000 }</style><script ` +
    `type="importmap">${JSON.stringify({ imports: IMPORTS })}</script><script>${before}</script>` +
    scripts.map((url) => `<script src="${url}"></script>`).join("") + `<script type="module" src="${module}"></script>`;
  server.pages.set("page.html", html);
  const page = await browser.newPage({ viewport: { width: 400, height: 400 }, deviceScaleFactor: 1 });
  page.setDefaultTimeout(PATIENCE);
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("requestfailed", (request) => complaints.push(`failed: ${request.url()}`));
  page.on("response", (response) => {
    if (response.status() >= 400) complaints.push(`${response.status()}: ${response.url()}`);
  });
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !/GL Driver|GPU stall|favicon/.test(message.text()))
      complaints.push(message.text());
  });
  await page.addInitScript({ path: path.join(HERE, "texture_levels.js") });
  await page.goto(`${server.origin}page.html`);
  await page.waitForFunction(() => globalThis.engine !== undefined);
  return { page, complaints };
}
