// SPDX-License-Identifier: Apache-2.0
// Prints what three.js's KTX2Loader reads from KTX2 files in headless Chromium, as JSON: the names of the extensions
// for compressed textures, and one object per file. The object has the size, the loader's format and filter, and the
// texels of every level as a shader reads them (floats in base64). If a file cannot be loaded, its object has an error.
//
//   node tests/cli/exports/ktx2_in_three.mjs CHROMIUM FILE...
import { readFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "../../service/web/node_modules/playwright-core/index.mjs";

const [executablePath, ...files] = process.argv.slice(2);
const modules = fileURLToPath(new URL("../../service/web/node_modules/", import.meta.url));
const PATIENCE = 60000; // ms; the machine may be busy

const PAGE = `<!doctype html><script type="importmap">{"imports": {"three": "/modules/three/build/three.module.js",
  "three/addons/": "/modules/three/examples/jsm/"}}</script>
<script type="module">
  import * as THREE from "three";
  import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
  const renderer = new THREE.WebGLRenderer();
  const loader = new KTX2Loader().setTranscoderPath("/modules/three/examples/jsm/libs/basis/").detectSupport(renderer);
  const gl = renderer.getContext();

  // Draws a level at one pixel per texel, without filtering.
  function texelsOf(map, level, width, height) {
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType });
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      uniforms: { map: { value: map }, level: { value: level } },
      vertexShader: "void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }",
      fragmentShader: "uniform sampler2D map; uniform int level; out vec4 texel;"
        + "void main() { texel = texelFetch(map, ivec2(gl_FragCoord.xy), level); }",
    });
    const scene = new THREE.Scene().add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material));
    scene.children[0].frustumCulled = false;
    renderer.setRenderTarget(target);
    renderer.render(scene, new THREE.Camera());
    const texels = new Float32Array(4 * width * height);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, texels);
    target.dispose();
    let bytes = "";
    for (const byte of new Uint8Array(texels.buffer)) bytes += String.fromCharCode(byte);
    return { width, height, texels: btoa(bytes) };
  }

  globalThis.read = async (url) => {
    const map = await loader.loadAsync(url);
    const levels = map.mipmaps.map(({ width, height }, level) => texelsOf(map, level, width, height));
    const error = gl.getError();
    if (error !== 0) throw new Error("GL error " + error);
    return { width: map.image.width, height: map.image.height, format: map.format, isCompressed:
      map.isCompressedTexture === true, generateMipmaps: map.generateMipmaps, flipY: map.flipY,
      hasColours: map.colorSpace !== THREE.NoColorSpace && map.colorSpace !== THREE.LinearSRGBColorSpace, levels };
  };
  globalThis.extensions = gl.getSupportedExtensions().filter((name) => /compress/.test(name));
</script>`;

const browser = await chromium.launch({
  executablePath,
  args: ["--no-sandbox", "--headless=new", "--disable-dev-shm-usage", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader"],
});
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(PATIENCE);
  const problems = [];
  page.on("pageerror", (error) => problems.push(String(error)));
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !/GPU stall/.test(message.text()))
      problems.push(message.text());
  });
  await page.route("**/*", async (route) => {
    const name = decodeURIComponent(new URL(route.request().url()).pathname);
    if (name === "/") return route.fulfill({ contentType: "text/html", body: PAGE });
    const file = name.startsWith("/modules/") ? path.join(modules, name.slice("/modules/".length))
      : files[Number(/^\/file_(\d+)\.ktx2$/.exec(name)?.[1] ?? -1)];
    if (file === undefined) return route.fulfill({ status: 404 });
    const contentType = file.endsWith(".js") ? "text/javascript" : "application/octet-stream";
    return route.fulfill({ contentType, body: await readFile(file) });
  });
  await page.goto("http://files.test/");
  await page.waitForFunction(() => globalThis.extensions !== undefined);
  const found = [];
  for (const index of files.keys())
    found.push(await page.evaluate(async (url) => {
      try {
        return await globalThis.read(url);
      } catch (error) {
        return { error: String(error) };
      }
    }, `/file_${index}.ktx2`));
  const extensions = await page.evaluate(() => globalThis.extensions);
  console.log(JSON.stringify({ extensions, problems, files: found }));
} finally {
  await browser.close();
}
