// SPDX-License-Identifier: Apache-2.0
// Starts headless Chromium with three.js, the package @multum/three from `multum shaders`, and the files of a test.
import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";

const MODULES = fileURLToPath(new URL("../service/web/node_modules/", import.meta.url));
const HERE = fileURLToPath(new URL(".", import.meta.url));
const ORIGIN = "http://multum.test/"; // no network is used: this script answers every request
const TYPES = { ".js": "text/javascript", ".wasm": "application/wasm", ".png": "image/png" };

export const executablePath = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium",
  "/usr/local/bin/chromium"].find(existsSync);

/**
 * Returns { page, complaints, close }: a page after `script`, a module of this folder, has run. `files` are served at
 * /files/.
 */
export async function openPage(chromium, { package: packageFolder, files, script }) {
  const roots = { modules: MODULES, package: packageFolder, files, tests: HERE };
  const map = { three: "/modules/three/build/three.module.js", "three/addons/": "/modules/three/examples/jsm/",
    "@multum/three": "/package/index.js" };
  const html = `<!doctype html><meta charset="utf-8"><script type="importmap">${JSON.stringify({ imports: map })}` +
    `</script><script type="module" src="/tests/${script}"></script>`;
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--headless=new",
    "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
  try {
    const page = await browser.newPage();
    page.setDefaultTimeout(60000);
    const complaints = [];
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("console", (message) => {
      if (["error", "warning"].includes(message.type()) && !/GL Driver|GPU stall|favicon/.test(message.text()))
        complaints.push(message.text());
    });
    await page.route("**/*", async (route) => {
      const name = decodeURIComponent(new URL(route.request().url()).pathname.slice(1));
      const [root, ...rest] = name.split("/");
      if (name === "") return route.fulfill({ contentType: "text/html", body: html });
      if (name === "favicon.ico") return route.fulfill({ status: 204 });
      const file = root in roots && !rest.includes("..") ? path.join(roots[root], ...rest) : "";
      if (!existsSync(file)) return route.fulfill({ status: 404, body: "" });
      return route.fulfill({ contentType: TYPES[path.extname(file)] ?? "application/octet-stream",
        body: await readFile(file) });
    });
    await page.goto(ORIGIN);
    await page.waitForFunction(() => globalThis.lab !== undefined);
    return { page, complaints, close: () => browser.close() };
  } catch (error) {
    await browser.close();
    throw error;
  }
}
