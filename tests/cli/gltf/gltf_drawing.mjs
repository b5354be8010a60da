// SPDX-License-Identifier: Apache-2.0
// Draws models with three.js in headless Chromium, from far and from near. Compares each picture from far with a
// reference of the first model, which averages many samples per pixel and so shows the highlights without mips.
//
//   node gltf_drawing.mjs CHROMIUM SCREENSHOT PLAN
//
// PLAN: JSON, {"models": [FILE...], "distances": [near, far], "light": [x, y, z]}; the first model is the original.
// Prints JSON: for each distance and model {"error": mean |picture - reference| over mean reference, "energy": mean
// picture over mean reference}.
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "../../service/web/node_modules/playwright-core/index.mjs";

const [executablePath, screenshot, planText] = process.argv.slice(2);
const plan = JSON.parse(planText);
const THREE_FOLDER = fileURLToPath(new URL("../../service/web/node_modules/three/", import.meta.url));
const PICTURES = fileURLToPath(new URL("../../three/linear_pictures.js", import.meta.url));
const ORIGIN = "http://multum.test/"; // no network is used: this script answers every request

const PAGE = `<!doctype html><meta charset="utf-8"><style>body{margin:8px;background:#222}
canvas{image-rendering:pixelated;width:256px;height:256px;margin:4px}</style><div id="all"></div>
<script type="importmap">{"imports":{"three":"./three/build/three.module.js","three/addons/":"./three/examples/jsm/"}}
</script><script type="module">
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
import { compared } from "./linear_pictures.js";
const plan = ${JSON.stringify({ ...plan, models: plan.models.map((file, i) => `model${i}/${path.basename(file)}`) })};
const SIDE = 64, SAMPLES = 12; // the pixels per side of a picture, and the samples per pixel in each direction
const renderer = new THREE.WebGLRenderer({ antialias: false });
renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
const ktx2 = new KTX2Loader().setTranscoderPath("./three/examples/jsm/libs/basis/").detectSupport(renderer);
const loader = new GLTFLoader().setKTX2Loader(ktx2);

function draw(scene, camera, side) {
  const target = new THREE.WebGLRenderTarget(side, side, { type: THREE.FloatType });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const pixels = new Float32Array(4 * side * side);
  renderer.readRenderTargetPixels(target, 0, 0, side, side, pixels);
  target.dispose();
  return pixels;
}
// Returns a picture in which each pixel is the mean of SAMPLES x SAMPLES drawn pixels.
function averaged(pixels) {
  const side = SIDE * SAMPLES, made = new Float32Array(4 * SIDE * SIDE);
  for (let y = 0; y < side; ++y)
    for (let x = 0; x < side; ++x)
      for (let c = 0; c < 4; ++c)
        made[4 * (Math.floor(y / SAMPLES) * SIDE + Math.floor(x / SAMPLES)) + c] +=
          pixels[4 * (y * side + x) + c] / (SAMPLES * SAMPLES);
  return made;
}
function show(pixels, title) {
  const figure = document.createElement("span"), canvas = document.createElement("canvas");
  canvas.width = canvas.height = SIDE;
  const context = canvas.getContext("2d"), image = context.createImageData(SIDE, SIDE);
  for (let y = 0; y < SIDE; ++y)
    for (let x = 0; x < SIDE; ++x)
      for (let c = 0; c < 4; ++c)
        image.data[4 * (y * SIDE + x) + c] =
          c === 3 ? 255 : 255 * Math.min(1, pixels[4 * ((SIDE - 1 - y) * SIDE + x) + c]) ** (1 / 2.2);
  context.putImageData(image, 0, 0);
  figure.title = title;
  figure.append(canvas);
  document.querySelector("#all").append(figure);
}
async function run() {
  const models = [];
  for (const name of plan.models) models.push((await loader.loadAsync(name)).scene);
  const result = [];
  for (const distance of plan.distances) {
    const camera = new THREE.PerspectiveCamera(plan.angle ?? 30, 1, 0.01, 1000);
    camera.position.set(...(plan.from ?? [0.3, 0.2, 1])).normalize().multiplyScalar(distance);
    camera.lookAt(0, 0, 0);
    const row = [];
    let reference;
    for (const [number, model] of models.entries()) {
      const scene = new THREE.Scene();
      scene.background = new THREE.Color(0, 0, 0);
      scene.add(model);
      const box = new THREE.Box3().setFromObject(model), centre = box.getCenter(new THREE.Vector3());
      const size = box.getSize(new THREE.Vector3());
      const whole = 2 / Math.max(size.x, size.y, size.z);
      model.scale.multiplyScalar(whole);
      model.position.sub(centre.multiplyScalar(whole));
      const light = new THREE.DirectionalLight(0xffffff, plan.intensity ?? 2);
      light.position.set(...plan.light);
      scene.add(light);
      if (number === 0) {
        reference = averaged(draw(scene, camera, SIDE * SAMPLES));
        show(reference, "reference");
      }
      const picture = draw(scene, camera, SIDE);
      show(picture, plan.models[number]);
      row.push(compared(picture, reference));
      model.scale.setScalar(1);
      model.position.setScalar(0);
    }
    document.querySelector("#all").append(document.createElement("br"));
    result.push(row);
  }
  return result;
}
globalThis.result = run();
</script>`;

const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--headless=new",
  "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
const complaints = [];
try {
  const page = await browser.newPage({ viewport: { width: 300 * (plan.models.length + 1), height: 40 + 280 *
    plan.distances.length } });
  page.setDefaultTimeout(60000);
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("console", (message) => {
    if (message.type() === "error" || (message.type() === "warning" && !/GL Driver|GPU stall/.test(message.text())))
      complaints.push(message.text());
  });
  await page.route("**/*", async (route) => {
    const name = decodeURIComponent(new URL(route.request().url()).pathname.slice(1));
    const model = /^model(\d+)\/((?!.*\.\.).*)$/.exec(name);
    const types = { ".js": "text/javascript", ".wasm": "application/wasm" };
    if (name === "") await route.fulfill({ body: PAGE, contentType: "text/html" });
    else if (name === "linear_pictures.js")
      await route.fulfill({ body: await readFile(PICTURES), contentType: types[".js"] });
    else if (model)
      await route.fulfill({ body: await readFile(path.join(path.dirname(plan.models[model[1]]), model[2])) });
    else if (name.startsWith("three/") && !name.includes(".."))
      await route.fulfill({ body: await readFile(path.join(THREE_FOLDER, name.slice(6))),
        contentType: types[path.extname(name)] ?? "application/octet-stream" });
    else await route.fulfill({ status: 404, body: "" });
  });
  await page.goto(ORIGIN);
  await page.waitForFunction(() => globalThis.result !== undefined);
  const result = await page.evaluate(() => globalThis.result);
  await writeFile(screenshot, await page.screenshot());
  console.log(JSON.stringify({ result, complaints: complaints.filter((one) => !/favicon/.test(one)) }));
} finally {
  await browser.close();
}
