// SPDX-License-Identifier: Apache-2.0
// Tests models on multum look's page: a square model, which is compared with the plane that the page draws by ray
// casting, a ball, a model with its own normal map, and damaged or hostile files. Exits with 77 (skipped) if something
// is missing.
//
//   node look_model_test.mjs BIN_FOLDER SCREENSHOTS
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import path from "node:path";
import { drop, goTo, pixelsOf, settled, startLook } from "./look_browser.mjs";

const [bin, screenshots] = process.argv.slice(2);
const look = await startLook(bin);
const { inFolder, run, complaints, open } = look;
mkdirSync(screenshots, { recursive: true });
const MEAN_MOST = 0.5; // in units of 1/255, within the square
const HALF_SIDE = 0.6 / Math.SQRT2; // half of the side of a square whose corners are at the radius of models on the
                                    // page

/** A binary glTF: `vertices` are [position, normal or null, texture coordinates], `image` the normal map's bytes. */
function glb(vertices, indices, { image = null, change = () => {} } = {}) {
  const floats = (column) => Buffer.from(Float32Array.from(vertices.flatMap((one) => one[column])).buffer);
  const hasNormals = vertices[0][1] !== null;
  const parts = [floats(0), ...(hasNormals ? [floats(1)] : []), floats(2),
    Buffer.from(Uint32Array.from(indices).buffer),
    ...(image ? [Buffer.concat([image, Buffer.alloc(-image.length & 3)])] : [])];
  let at = 0;
  const bufferViews = parts.map((part) => {
    at += part.length;
    return { buffer: 0, byteOffset: at - part.length, byteLength: part.length };
  });
  const of = (type, componentType, count) => ({ type, componentType, count });
  const types = [of("VEC3", 5126, vertices.length), ...(hasNormals ? [of("VEC3", 5126, vertices.length)] : []),
    of("VEC2", 5126, vertices.length), of("SCALAR", 5125, indices.length)];
  const uv = hasNormals ? 2 : 1;
  const json = { asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, ...(hasNormals ? { NORMAL: 1 } : {}), TEXCOORD_0: uv },
      indices: uv + 1, material: 0 }] }],
    accessors: types.map((one, bufferView) => ({ ...one, bufferView })), bufferViews, buffers: [{ byteLength: at }],
    materials: [image ? { normalTexture: { index: 0 } } : {}],
    ...(image ? { textures: [{ source: 0 }], images: [{ bufferView: uv + 2, mimeType: "image/png" }] } : {}) };
  change(json);
  const text = Buffer.from(JSON.stringify(json));
  const chunk = (type, bytes, fill) => {
    const padded = Buffer.concat([bytes, Buffer.alloc(-bytes.length & 3, fill)]), head = Buffer.alloc(8);
    head.writeUInt32LE(padded.length, 0);
    head.writeUInt32LE(type, 4);
    return Buffer.concat([head, padded]);
  };
  const body = Buffer.concat([chunk(0x4e4f534a, text, 32), chunk(0x004e4942, Buffer.concat(parts), 0)]);
  const head = Buffer.from("glTF\x02\0\0\0\0\0\0\0", "latin1");
  head.writeUInt32LE(12 + body.length, 8);
  return Buffer.concat([head, body]);
}

/** Returns the JSON of a binary glTF, and its buffer; `change` may change both. */
function gltf(bytes, change = () => {}) {
  const length = bytes.readUInt32LE(12), json = JSON.parse(bytes.subarray(20, 20 + length).toString());
  const parts = { json, buffer: bytes.subarray(28 + length, 28 + length + json.buffers[0].byteLength) };
  json.buffers[0].uri = "the%20buffer.bin";
  change(parts);
  return [["model.gltf", Buffer.from(JSON.stringify(json))], ["the buffer.bin", parts.buffer]];
}

// The texture coordinates equal those of the page's plane, except for whole numbers: u = x, v = -y. The z of glTF is -y
// on the page.
const square = (options) => glb([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, z]) =>
  [[7 * x, 2, 7 * z], options?.isFlat ? null : [0, 1, 0], [HALF_SIDE * x, HALF_SIDE * z - 0.76]]),
[0, 2, 1, 0, 3, 2], options);

function ball(rings = 32) {
  const vertices = [], indices = [];
  for (let i = 0; i <= rings; ++i)
    for (let j = 0; j <= 2 * rings; ++j) {
      const [a, b] = [Math.PI * i / rings, Math.PI * j / rings];
      const n = [Math.sin(a) * Math.sin(b), Math.cos(a), Math.sin(a) * Math.cos(b)];
      vertices.push([n, n, [j / rings, i / rings]]);
      const corner = i * (2 * rings + 1) + j;
      if (i < rings && j < 2 * rings)
        indices.push(corner, corner + 2 * rings + 1, corner + 1, corner + 1, corner + 2 * rings + 1,
          corner + 2 * rings + 2);
    }
  return glb(vertices, indices, { change: (json) => { // two unnamed nodes with the same mesh, one of them smaller and
                                                      // to the side
    json.nodes = [{ mesh: 0 }, { mesh: 0, scale: [0.5, 0.5, 0.5], translation: [1.4, 0.3, 0] }];
    json.scenes[0].nodes = [0, 1];
  } });
}

/** Returns the mean difference from the picture `url` inside the square, in 1/255, and the largest brightness there. */
const apart = (page, url) => page.evaluate(async ([want, half]) => {
  const image = new Image();
  image.src = want;
  await image.decode();
  const { width, height } = image;
  const rgba = (source) => {
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(source, 0, 0);
    return context.getImageData(0, 0, width, height).data;
  };
  const [a, b] = [rgba(image), rgba(document.getElementById("canvas"))];
  const camera = globalThis.lookCamera(globalThis.multumLook.view);
  const m = globalThis.raysOf(camera, width / height);
  let [sum, count, brightest] = [0, 0, 0];
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      const [s, t] = [2 * (x + 0.5) / width - 1, 1 - 2 * (y + 0.5) / height];
      const ray = [0, 1, 2].map((c) => m[c] * s + m[3 + c] * t + m[6 + c]);
      const reach = -camera.eye[2] / ray[2];
      const place = [camera.eye[0] + reach * ray[0], camera.eye[1] + reach * ray[1] - 0.76];
      if (!(ray[2] < 0) || Math.max(...place.map(Math.abs)) > 0.97 * half) continue;
      for (let c = 0; c < 3; ++c) {
        sum += Math.abs(a[4 * (y * width + x) + c] - b[4 * (y * width + x) + c]);
        brightest = Math.max(brightest, a[4 * (y * width + x) + c]);
        ++count;
      }
    }
  return { mean: sum / count, count, brightest };
}, [url, HALF_SIDE]);

try {
  run("multum", "testmap", "map", "--size", "128");
  run("multum", "testmap", "own", "--size", "128", "--seed", "5");
  run("multum", "bake", "map_normal.png", "-o", "map.ndf.exr", "--no-measure", "-q", "--green", "up");
  run("multum", "look", "map.ndf.exr", "--no-open");
  const page = await open("map.html");
  const views = ["light=sun&left=lobes&right=mip&elevation=60&distance=0.2&exposure=0",
    "light=sun&left=lobes&right=rule&elevation=35&azimuth=50&distance=0.5&exposure=0&lock=2&x=-0.5&y=0.5&z=0.7"];
  const at = async (hash) => {
    await goTo(page, hash);
    await settled(page);
    await settled(page);
    return pixelsOf(page);
  };
  const onModel = (hash) => at(`${hash}&shape=model`);
  const planes = [];
  for (const hash of views) planes.push(await at(hash));
  for (const isFlat of [false, true]) {
    assert.equal(await drop(page, ["square.glb", square({ isFlat })]), "");
    for (const [i, hash] of views.entries()) {
      const drawn = await onModel(hash);
      assert.notEqual(drawn, planes[i], "around the square the picture must be empty");
      const { mean, count, brightest } = await apart(page, planes[i]);
      console.log(`  ${hash}: mean difference ${mean.toFixed(3)} of 255 over ${count} values`);
      assert.ok(count > 5000 && brightest > 60, `${count} values, ${brightest}`);
      assert.ok(mean <= MEAN_MOST, `${hash}: ${mean}`);
    }
  }
  // Returns to the plane. The model stays in the list.
  await page.selectOption("#shape", "plane");
  await settled(page);
  assert.equal(await at(views[0]), planes[0]);
  assert.deepEqual(await page.locator("#shape option").allTextContents(), ["plane", "sphere",
    "ring", "square.glb"]);
  await page.selectOption("#shape", "model");
  const withMap = await onModel(views[0]);
  assert.notEqual(withMap, planes[0]);

  // The page draws the normal map of the model if it fits.
  assert.equal(await drop(page, ["own.glb", square({ image: readFileSync(inFolder("own_normal.png")) })]), "");
  assert.notEqual(await onModel(views[0]), withMap);
  run("multum", "testmap", "large", "--size", "160");
  assert.equal(await drop(page, ["large.glb", square({ image: readFileSync(inFolder("large_normal.png")) })]), "");

  // A model in JSON looks the same, whether it has separate files or embedded data. Its own normal map is also drawn.
  const own = square({ image: readFileSync(inFolder("own_normal.png")) });
  assert.equal(await drop(page, ["own.glb", own]), "");
  const withOwn = await onModel(views[0]);
  const apartImage = ({ json }) => { json.images[0] = { uri: "own_normal.png", mimeType: "image/png" }; };
  const [map, image] = [readFileSync(inFolder("map_normal.png")), ["own_normal.png",
    readFileSync(inFolder("own_normal.png"))]];
  const inItself = ({ json, buffer }) => {
    json.buffers[0].uri = `data:application/octet-stream;base64,${buffer.toString("base64")}`; };
  for (const files of [gltf(own), [image, ...gltf(own, apartImage)], gltf(own, inItself).slice(0, 1)]) {
    assert.equal(await drop(page, ["square.glb", square()], ["map_normal.png", map]), "");
    assert.notEqual(await onModel(views[0]), withOwn);
    assert.equal(await drop(page, ...files), "");
    assert.equal(await onModel(views[0]), withOwn);
  }
  for (const [words, files] of [
    ["names the buffer.bin, which was not dropped", gltf(own).slice(0, 1)],
    ["names own_normal.png, which was not dropped", gltf(own, apartImage)],
    ["expected 152", gltf(square(), (parts) => { parts.buffer = parts.buffer.subarray(0, 100); })],
    ["names no file", gltf(own, ({ json }) => { delete json.buffers[0].uri; })],
    ["names buffer 7, of 1", gltf(own, ({ json }) => { json.bufferViews[0].buffer = 7; })],
    ["view beyond its buffer", gltf(own, ({ json }) => { json.bufferViews[0].byteLength = 1e9; })],
    ["not in base64", gltf(own, ({ json }) => { json.buffers[0].uri = "data:,abc"; })],
    ["of version 1.0", gltf(own, ({ json }) => { json.asset.version = "1.0"; })],
    // A picture that belongs to such a model is not added to the list of maps.
    ["JSON is damaged", [["colour.png", map], ["model.gltf", Buffer.from("{ \"asset\": ")]]],
    ["names 50%.bin, which was not dropped", gltf(own, ({ json }) => { json.buffers[0].uri = "50%.bin"; })],
  ]) {
    const said = await drop(page, ...files);
    assert.ok(said.startsWith("model.gltf: ") && said.includes(words), `expected ${words}: ${said}`);
  }
  assert.equal(await onModel(views[0]), withOwn);

  // An unsupported file is refused with a message, and the drawn picture stays.
  const good = square(), before = await onModel(views[0]);
  const odd = (change) => square({ change });
  for (const [words, bytes] of [
    ["cut short", Buffer.concat([good.subarray(0, 8), Buffer.from([100, 0, 0, 0]), good.subarray(12, 100)])],
    ["its head says", good.subarray(0, 400)],
    ["JSON is damaged", Buffer.concat([good.subarray(0, 20), Buffer.from("}}"), good.subarray(22)])],
    ["more than 1000000 triangles", odd((json) => { json.accessors[3].count = 4e6; })],
    ["extends beyond its buffer", odd((json) => { json.accessors[0].count = 4e5; })],
    ["extends beyond its buffer", odd((json) => { json.accessors[3].count = 3e5; })],
    ["in two places", odd((json) => { json.nodes[0].children = [0]; json.scenes[0].nodes = [0]; })],
    ["different numbers of normals", odd((json) => { json.accessors[1].count = 3; })],
    ["has no texture coordinates", odd((json) => { delete json.meshes[0].primitives[0].attributes.TEXCOORD_0; })],
    ["has no triangles", odd((json) => { json.meshes = [{ primitives: [] }]; })],
    ["has a radius of 0", odd((json) => { json.nodes[0].scale = [0, 0, 0]; })],
    ["needs KHR_draco_mesh_compression", odd((json) => {
      json.extensionsRequired = ["KHR_draco_mesh_compression"]; })],
    ["image beyond its buffer", square({ image: Buffer.alloc(8), change: (json) => {
      json.bufferViews[4].byteLength = 1e9; } })],
  ]) {
    const said = await drop(page, ["odd.glb", bytes]);
    assert.ok(said.startsWith("odd.glb: ") && said.includes(words), `expected ${words}: ${said}`);
  }
  await settled(page);
  assert.equal(await pixelsOf(page), before);

  for (const colorScheme of ["light", "dark"]) {
    const small = await open("map.html", "#left=export&distance=1", { width: 360, height: 740, colorScheme,
      hasTouch: true, isMobile: true });
    assert.equal(await drop(small, ["ball.glb", ball()]), "");
    await settled(small);
    const [scroll, client] = await small.evaluate(() =>
      [document.documentElement.scrollWidth, document.documentElement.clientWidth]);
    assert.ok(scroll <= client, `the page is ${scroll} px wide in ${client}`);
    await small.screenshot({ path: path.join(screenshots, `look_model_360_${colorScheme}.png`), fullPage: true });
  }
  assert.deepEqual(complaints, []);
} finally {
  await look.end();
}
