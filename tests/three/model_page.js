// SPDX-License-Identifier: Apache-2.0
// Pictures of models by three.js, beside the mean of many samples a pixel of one of them without mips: what
// model_pictures.mjs asks of a page.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
import { addPoints, GltfLobes, lobesOf } from "@multum/three";
import { compared, toByte } from "./linear_pictures.js";

const TILE = 1024; // pixels a side that are drawn at once
const DATA_MAPS = ["normalMap", "roughnessMap", "metalnessMap", "aoMap"];
const renderer = new THREE.WebGLRenderer({ antialias: false });
const ktx2 = new KTX2Loader().setTranscoderPath("/modules/three/examples/jsm/libs/basis/").detectSupport(renderer);
const room = new THREE.PMREMGenerator(renderer).fromScene(new RoomEnvironment(), 0.01).texture;

function materialsOf(model) {
  const found = new Set();
  model.traverse(({ material }) => { if (material) found.add(material); });
  return [...found];
}

const loaded = new Map(); // promises, for all views of a page

function load(model) {
  const key = JSON.stringify(model);
  if (!loaded.has(key)) loaded.set(key, loadAnew(model));
  return loaded.get(key);
}

/**
 * `lobes`: by the plugin; `points`: evaluations of a pixel's light without lobes, three.js's own shading where unset;
 * `options`: of either; `unfiltered`: its maps of normals and of the surface have no mips. All maps have the renderer's
 * most anisotropic filter.
 */
async function loadAnew({ url, lobes = false, points, options = {}, unfiltered = false }) {
  const loader = new GLTFLoader().setKTX2Loader(ktx2);
  if (lobes) loader.register((parser) => new GltfLobes(parser, renderer, options));
  const gltf = await loader.loadAsync(url), anisotropy = renderer.capabilities.getMaxAnisotropy();
  for (const material of materialsOf(gltf.scene)) {
    for (const [name, map] of Object.entries(material)) {
      if (!map?.isTexture) continue;
      if (unfiltered && DATA_MAPS.includes(name)) Object.assign(map, { minFilter: THREE.LinearFilter, generateMipmaps: false });
      else map.anisotropy = anisotropy;
      map.needsUpdate = true;
    }
    if (points !== undefined && material.isMeshStandardMaterial)
      addPoints(material, { evaluations: points, ...options });
  }
  return gltf;
}

/** Linear floats of `width` x `height` pixels, each the mean of `samples` x `samples`. */
function drawn(scene, camera, width, height, samples) {
  const made = new Float32Array(4 * width * height), tile = Math.floor(TILE / samples);
  const target = new THREE.WebGLRenderTarget(tile * samples, tile * samples, { type: THREE.HalfFloatType });
  const halves = new Uint16Array(4 * (tile * samples) ** 2);
  renderer.setRenderTarget(target);
  for (let top = 0; top < height; top += tile)
    for (let left = 0; left < width; left += tile) {
      const side = tile * samples;
      camera.setViewOffset(width * samples, height * samples, left * samples, top * samples, side, side);
      renderer.render(scene, camera);
      renderer.readRenderTargetPixels(target, 0, 0, side, side, halves);
      for (let y = 0; y < side; ++y)
        for (let x = 0; x < side; ++x) {
          const [column, row] = [left + Math.floor(x / samples), top + Math.floor((side - 1 - y) / samples)];
          if (column >= width || row >= height) continue;
          for (let c = 0; c < 4; ++c)
            made[4 * (row * width + column) + c] += THREE.DataUtils.fromHalfFloat(halves[4 * (y * side + x) + c]) /
              samples ** 2;
        }
    }
  renderer.setRenderTarget(null);
  target.dispose();
  camera.clearViewOffset();
  return made;
}

/**
 * The mean of `frames` x `frames` pictures, each shifted by a part of a pixel, as temporal antialiasing has them; each
 * with `edges` samples of edges.
 */
function settled(scene, camera, width, height, frames, edges) {
  const made = new Float32Array(4 * width * height), halves = new Uint16Array(made.length);
  const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.HalfFloatType, samples: edges });
  renderer.setRenderTarget(target);
  for (let frame = 0; frame < frames ** 2; ++frame) {
    const shift = (k) => (k + 0.5) / frames - 0.5;
    camera.setViewOffset(width, height, shift(frame % frames), shift(Math.floor(frame / frames)), width, height);
    renderer.render(scene, camera);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, halves);
    for (let y = 0; y < height; ++y)
      for (let i = 0; i < 4 * width; ++i)
        made[4 * y * width + i] += THREE.DataUtils.fromHalfFloat(halves[4 * (height - 1 - y) * width + i]) /
          frames ** 2;
  }
  renderer.setRenderTarget(null);
  target.dispose();
  camera.clearViewOffset();
  return made;
}

/** Pictures side by side, of each the rectangle [x, y, width, height] enlarged `zoom` times, as a JPEG in base64. */
async function strip(pictures, width, [x0, y0, w, h], zoom) {
  const gap = 4, canvas = new OffscreenCanvas(pictures.length * (w * zoom + gap) - gap, h * zoom);
  const context = canvas.getContext("2d");
  context.fillStyle = "#888";
  context.fillRect(0, 0, canvas.width, canvas.height);
  pictures.forEach((pixels, number) => {
    const image = context.createImageData(w * zoom, h * zoom);
    for (let y = 0; y < h * zoom; ++y)
      for (let x = 0; x < w * zoom; ++x)
        for (let c = 0; c < 4; ++c)
          image.data[4 * (y * w * zoom + x) + c] = c === 3 ? 255
            : toByte(pixels[4 * ((y0 + Math.floor(y / zoom)) * width + x0 + Math.floor(x / zoom)) + c]);
    context.putImageData(image, number * (w * zoom + gap), 0);
  });
  const blob = await canvas.convertToBlob({ type: "image/jpeg", quality: 0.88 });
  let text = "";
  for (const byte of new Uint8Array(await blob.arrayBuffer())) text += String.fromCharCode(byte);
  return btoa(text);
}

/** A view of all of `model` from `distance`, `direction` from its middle, and what of the picture to enlarge. */
function framed(model, { direction, distance, ...view }) {
  const box = new THREE.Box3().setFromObject(model), target = box.getCenter(new THREE.Vector3());
  const eye = new THREE.Vector3(...direction).normalize().multiplyScalar(distance).add(target);
  const reach = box.getSize(new THREE.Vector3()).length() / 2;
  const seen = reach / (distance * Math.tan(view.angle * Math.PI / 360)); // of half the picture
  const share = Math.min(1, seen), { width, height } = view;
  const [w, h] = [Math.ceil(width * share), Math.ceil(height * share)];
  return { ...view, eye: eye.toArray(), target: target.toArray(), zoom: Math.max(1, Math.round(1 / share)),
    crop: [(width - w) >> 1, (height - h) >> 1, w, h] };
}

/**
 * `models`: [{ url, lobes, points, options }], the first the one whose unfiltered samples are the reference. `asked`: { eye, target,
 * angle, width, height, samples, frames, edges, light, intensity, room, crop, zoom }, or direction and distance in
 * place of eye, target, crop and zoom. Returns { models: [{ error, energy, lobed }], zoom, strip }, the reference first
 * in the strip; `lobed`: how many materials draw lobes.
 */
async function pictures(models, asked) {
  const unfiltered = await load({ ...models[0], unfiltered: true });
  const view = asked.direction ? framed(unfiltered.scene, asked) : asked, { width, height } = view;
  const camera = new THREE.PerspectiveCamera(view.angle, width / height, 0.01, 1000);
  camera.position.set(...view.eye);
  camera.lookAt(...view.target);
  const sceneOf = (model) => {
    const scene = new THREE.Scene();
    scene.background = new THREE.Color(0, 0, 0);
    const light = new THREE.DirectionalLight(0xffffff, view.intensity);
    light.position.set(...view.light);
    scene.add(model, light);
    if (view.room > 0) scene.environment = room;
    scene.environmentIntensity = view.room;
    return scene;
  };
  const reference = drawn(sceneOf(unfiltered.scene), camera, width, height, view.samples);
  const shown = [reference], found = [];
  for (const model of models) {
    const gltf = await load(model);
    const lobed = materialsOf(gltf.scene).filter((material) => lobesOf(material) !== null).length;
    shown.push(settled(sceneOf(gltf.scene), camera, width, height, view.frames, view.edges));
    found.push({ ...compared(shown.at(-1), reference), lobed });
  }
  const error = renderer.getContext().getError();
  if (error !== 0) throw new Error(`GL error ${error}`);
  return { models: found, zoom: view.zoom, strip: await strip(shown, width, view.crop, view.zoom) };
}

globalThis.lab = { pictures, load };
