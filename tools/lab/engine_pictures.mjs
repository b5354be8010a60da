// SPDX-License-Identifier: Apache-2.0
// Draws a hammered sphere before and after `multum gltf` with the engines of the web in headless Chromium. Writes a
// strip of pictures per engine, engine_NAME.jpg, and the page that lists what was drawn and measured.
//
//   node tools/lab/engine_pictures.mjs BIN_FOLDER PAGE.md IMAGES [ENGINE...]
//
// BIN_FOLDER contains multum. With names of engines, only these engines are drawn, and the page keeps the other results
// from engine_rows.json, which is next to the page. Needs Node.js, npm, Chromium and the packages of tests/service/web.
// The engines are installed into tools/lab/engines.
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { SURFACES, sphere } from "../../tests/three/bumpy_models.mjs";
import { makeGlb, pngOf } from "../../tests/three/glb_writer.mjs";
import { launch, open, serve } from "./engines/browser.mjs";
import { documentOf } from "./engines/document.mjs";
import { ENGINES, VIEW } from "./engines/engine_list.mjs";
import { levelsOfFile, levelsOfModel, matchedLevels } from "./engines/levels.mjs";
import { brightnessOf, energyOf, errorOf, flickerOf, middleOf, neutral, shownMiddleOf } from "./engines/measures.mjs";
import { skyBytes } from "./engines/sky.mjs";
import { stripOf } from "./engines/strip.mjs";

const [bin, pageFile, images, ...only] = process.argv.slice(2);
const HERE = fileURLToPath(new URL("engines/", import.meta.url));
const PACKAGES = fileURLToPath(new URL("../../tests/service/web/node_modules/", import.meta.url));
const NEAR = { azimuth: 17, elevation: 6, distance: VIEW.near };
const FAR = Array.from({ length: VIEW.frames }, (_, frame) =>
  ({ azimuth: 17 + frame * VIEW.step, elevation: 6, distance: VIEW.far }));
const middlesOf = (pictures) => pictures.map((one) => middleOf(one, VIEW.side, VIEW.crop));
const bytesOf = (text) => new Uint8Array(Buffer.from(text, "base64"));

/** Installs the engines, unless the installed packages are those of package-lock.json. */
function install() {
  const versions = (file) => JSON.stringify(Object.entries(JSON.parse(readFileSync(file, "utf8")).packages)
    .filter(([name]) => name !== "").map(([name, one]) => [name, one.version]).sort());
  const installed = path.join(HERE, "node_modules/.package-lock.json");
  if (existsSync(installed) && versions(installed) === versions(path.join(HERE, "package-lock.json"))) return;
  execFileSync("npm", ["ci", "--ignore-scripts", "--no-audit", "--no-fund", "--legacy-peer-deps"], { cwd: HERE,
    stdio: ["ignore", "ignore", "inherit"] });
}

/** Returns the version of multum, and the commit of this repository. */
function madeBy() {
  const said = (...words) => execFileSync(...words, { encoding: "utf8", cwd: HERE }).trim();
  const commit = said("git", ["rev-parse", "--short=12", "HEAD"]);
  return `${said(path.resolve(bin, "multum"), ["--version"])}, commit ${commit}`;
}

/** Returns an image of one colour. */
function constantImage(rgb) {
  const { texels: width } = VIEW, height = width;
  return { width, height, rgb: Uint8Array.from({ length: 3 * width * height }, (_, i) => rgb[i % 3]) };
}

/** Writes the model and its maps, and runs multum for each engine. */
function makeFiles(folder, engines) {
  const { normal, color } = SURFACES.hammered(VIEW.texels), orm = constantImage([255, VIEW.roughness, 255]);
  writeFileSync(path.join(folder, "sphere.glb"),
    makeGlb("hammered", { normal, color, surface: orm, mesh: sphere(0.5, VIEW.repeat) }));
  writeFileSync(path.join(folder, "normal.png"), pngOf(normal));
  writeFileSync(path.join(folder, "orm.png"), pngOf(orm));
  writeFileSync(path.join(folder, "sky.hdr"), skyBytes(VIEW));
  const run = (...words) => execFileSync(path.resolve(bin, "multum"), [...words, "--encoder", PACKAGES, "--quiet"],
    { cwd: folder, stdio: ["ignore", "ignore", "inherit"] });
  for (const { name, gltf, exported } of engines) {
    run("gltf", "sphere.glb", ...gltf, "-o", `${name}.glb`);
    if (exported) run("export", "normal.png", "--roughness", "orm.png", "--metalness", "orm.png", ...exported,
      "--no-measure", "-o", `${name}.ktx2`);
  }
}

/** Draws references under the light of an engine: linear values of each far view. */
async function drawReferences(browser, server, { sky }) {
  const { page } = await open(browser, server, ENGINES.find(({ name }) => name === "three"));
  await page.evaluate((view) => globalThis.engine.begin(view), { ...VIEW, sky: sky && "/files/sky.hdr" });
  await page.evaluate((model) => globalThis.engine.load(model), { model: "/files/sphere.glb" });
  const drawn = [];
  for (const place of FAR)
    drawn.push(await page.evaluate(([at, samples, crop]) => globalThis.engine.reference(at, samples, crop),
      [place, VIEW.samples, VIEW.crop]));
  await page.close();
  return drawn;
}

/** Returns { near, far, textures, complaints }: pictures of the model as bytes, and the textures of the context. */
async function drawModel(browser, server, engine, model) {
  const { page, complaints } = await open(browser, server, engine);
  try {
    await page.evaluate((view) => globalThis.engine.begin(view), { ...VIEW, sky: engine.sky && "/files/sky.hdr" });
    await page.evaluate((files) => globalThis.engine.load(files), model);
    const picture = async (place) =>
      bytesOf(await page.evaluate((at) => globalThis.engine.picture(at), place));
    const near = await picture(NEAR), far = [];
    for (const place of FAR) far.push(await picture(place));
    const linear = engine.name === "three" ? await page.evaluate((at) => globalThis.engine.linear(at), FAR[0]) : null;
    const textures = await page.evaluate((side) => globalThis.uploadedTextures(side), VIEW.texels);
    return { near, far, linear, textures, complaints };
  } finally {
    await page.close();
  }
}

/** Draws the far views with textures of `multum export`. Returns { levels, error }. */
async function measureDirect(browser, server, folder, engine, shown) {
  const [normal, orm] = ["normal", "orm"].map((kind) => `${engine.name}_${kind}.ktx2`);
  const { far, textures } = await drawModel(browser, server, engine, { model: "/files/sphere.glb",
    normal: `/files/${normal}`, orm: `/files/${orm}` });
  const files = [];
  for (const name of [normal, orm]) files.push(await levelsOfFile(browser, server, path.join(folder, name)));
  return { levels: matchedLevels(textures, files), error: errorOf(middlesOf(far), shown) };
}

/** Draws and measures an engine. Returns the row of the table, and the pictures of the strip. */
async function measure(browser, server, folder, engine, references) {
  const original = await drawModel(browser, server, engine, { model: "/files/sphere.glb" });
  const multum = await drawModel(browser, server, engine, { model: `/files/${engine.name}.glb` });
  const tone = engine.tone === "neutral" ? neutral : (rgb) => rgb;
  const shown = references.map((one) => shownMiddleOf(one, VIEW.side, VIEW.crop, tone));
  const ways = { original: middlesOf(original.far), multum: middlesOf(multum.far) };
  const row = { name: engine.name, levels: matchedLevels(multum.textures,
    await levelsOfModel(browser, server, folder, `${engine.name}.glb`)), complaints: multum.complaints };
  if (engine.exported)
    row.direct = await measureDirect(browser, server, folder, engine, shown).catch((error) =>
      ({ failure: String(error.message ?? error) }));
  for (const [way, frames] of Object.entries(ways))
    row[way] = { error: errorOf(frames, shown), energy: energyOf(frames, shown), flicker: flickerOf(frames),
      brightness: brightnessOf(frames) };
  row.reference = { flicker: flickerOf(shown), brightness: brightnessOf(shown) };
  if (engine.name === "three")
    for (const [way, { linear }] of Object.entries({ original, multum })) {
      const unclipped = (pixels) => shownMiddleOf(pixels.map((value) => value / VIEW.brightest), VIEW.side, VIEW.crop,
        (rgb) => rgb);
      row[way].linear = errorOf([unclipped(linear)], [unclipped(references[0])]);
    }
  return { row, pictures: { near: [original.near, multum.near], far: [original.far[0], multum.far[0]],
    reference: shown[0] } };
}

async function main() {
  const engines = ENGINES.filter(({ name }) => only.length === 0 || only.includes(name));
  install();
  const folder = mkdtempSync(path.join(os.tmpdir(), "multum-engines-"));
  const rowsFile = path.join(path.dirname(pageFile), "engine_rows.json");
  const rows = existsSync(rowsFile) ? JSON.parse(readFileSync(rowsFile, "utf8")) : {};
  const server = await serve(folder), browser = await launch(), references = {};
  try {
    makeFiles(folder, engines);
    for (const engine of engines) {
      const light = engine.sky ? "sky" : "light";
      references[light] ??= await drawReferences(browser, server, engine);
      const version = JSON.parse(readFileSync(engine.package, "utf8")).version;
      try {
        const { row, pictures } = await measure(browser, server, folder, engine, references[light]);
        rows[engine.name] = { ...row, version, made: madeBy() };
        writeFileSync(path.join(images, `engine_${engine.name}.jpg`),
          await stripOf(browser, server, `${engine.title} ${version}`, pictures));
      } catch (error) {
        rows[engine.name] = { name: engine.name, version, error: String(error.message ?? error) };
      }
      console.log(JSON.stringify(rows[engine.name]));
      writeFileSync(rowsFile, `${JSON.stringify(rows, null, 1)}\n`);
      const inOrder = ENGINES.filter(({ name }) => name in rows).map(({ name }) => rows[name]);
      writeFileSync(pageFile, documentOf(inOrder, path.basename(images)));
    }
  } finally {
    await browser.close();
    server.close();
    rmSync(folder, { recursive: true });
  }
}

await main();
