// SPDX-License-Identifier: Apache-2.0
// Starts headless Chromium with three.js, the package @multum/three from `multum shaders`, and the files of a test.
import { createReadStream, existsSync, statSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";

const MODULES = fileURLToPath(new URL("../service/web/node_modules/", import.meta.url));
const HERE = fileURLToPath(new URL(".", import.meta.url));
const TYPES = { ".js": "text/javascript", ".wasm": "application/wasm", ".png": "image/png" };

export const executablePath = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium",
  "/usr/local/bin/chromium"].find(existsSync);

/**
 * Starts a server on a free port of the loopback interface, which sends `html` for / and the files of `roots`, folders
 * by the first part of a path. Returns its address. Files do not pass through Playwright, whose messages have at most
 * 100 MB.
 */
async function serve(html, roots) {
  const server = createServer(({ url }, response) => {
    const name = decodeURIComponent(new URL(url, "http://localhost").pathname.slice(1));
    const [root, ...rest] = name.split("/");
    if (name === "") return response.writeHead(200, { "Content-Type": "text/html" }).end(html);
    if (name === "favicon.ico") return response.writeHead(204).end();
    const file = root in roots && !rest.includes("..") ? path.join(roots[root], ...rest) : "";
    if (!statSync(file, { throwIfNoEntry: false })?.isFile()) return response.writeHead(404).end();
    response.writeHead(200, { "Content-Type": TYPES[path.extname(file)] ?? "application/octet-stream" });
    return createReadStream(file).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  server.unref(); // Node.js may end although the server still listens
  return `http://127.0.0.1:${server.address().port}/`;
}

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
  const address = await serve(html, roots);
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
    await page.goto(address);
    await page.waitForFunction(() => globalThis.lab !== undefined);
    return { page, complaints, close: () => browser.close() };
  } catch (error) {
    await browser.close();
    throw error;
  }
}
