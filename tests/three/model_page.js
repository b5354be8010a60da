// SPDX-License-Identifier: Apache-2.0
// Contains the page functions for model_pictures.mjs. three.js draws the models. For one model without mips, it also
// draws the mean of many samples per pixel.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { addPoints, GltfLobes, lobesOf } from "@multum/three";
import { compared } from "./linear_pictures.js";
import { drawn, settled, strip } from "./model_drawing.js";
import { changes, moved } from "./model_motion.js";
import { exactMaterial, shiftOfGrid } from "./exact_material.js";

const DATA_MAPS = ["normalMap", "roughnessMap", "metalnessMap", "aoMap"];
// This is the largest allowed noise of the reference, as a fraction of the error. It changes the error by at most 1 %,
// because sqrt(1 + 0.14^2) = 1.01.
const NOISE_SHARE = 0.14, NOISE_SMALL = 0.005;
const GRIDS_MAX = 16;
const renderer = new THREE.WebGLRenderer({ antialias: false });
const ktx2 = new KTX2Loader().setTranscoderPath("/modules/three/examples/jsm/libs/basis/").detectSupport(renderer);
let room = new THREE.PMREMGenerator(renderer).fromScene(new RoomEnvironment(), 0.01).texture; // the surroundings
const views = new Map(); // by name: { shot, reference, shown }
let begun = null, held = []; // { model, gltfs }; models that hold() loaded

function materialsOf(model) {
  const found = new Set();
  model.traverse(({ material }) => { if (material) found.add(material); });
  return [...found];
}

/** Scales `model` so that half of its diagonal is `reach` metres; without `reach` the model stays unchanged. */
function resized(model, reach) {
  if (reach === undefined) return;
  const size = new THREE.Box3().setFromObject(model).getSize(new THREE.Vector3()).length() / 2;
  model.scale.multiplyScalar(reach / size);
  model.updateMatrixWorld(true);
}

/**
 * Loads a model. With `lobes`, the plugin adds lobes. Otherwise `points` is the number of evaluations of a pixel's
 * light; if unset, three.js shades by itself. `options` are those of lobes or points. `exact` is the number of samples
 * along each side of a pixel over which every frame averages its shading. With `unfiltered` or `exact`, maps of normals
 * and of the surface have no mips. `reach` is half of the diagonal, in metres. All maps have the renderer's highest
 * anisotropy.
 */
async function load({ url, lobes = false, points, options = {}, unfiltered = false, exact, reach }) {
  const loader = new GLTFLoader().setKTX2Loader(ktx2);
  if (lobes) loader.register((parser) => new GltfLobes(parser, renderer, options));
  const gltf = await loader.loadAsync(url), anisotropy = renderer.capabilities.getMaxAnisotropy();
  resized(gltf.scene, reach);
  for (const material of materialsOf(gltf.scene)) {
    for (const [name, map] of Object.entries(material)) {
      if (!map?.isTexture) continue;
      if ((unfiltered || exact) && DATA_MAPS.includes(name))
        Object.assign(map, { minFilter: THREE.LinearFilter, generateMipmaps: false });
      else map.anisotropy = anisotropy;
      map.needsUpdate = true;
    }
    if (!material.isMeshStandardMaterial) continue;
    if (exact) exactMaterial(material, exact);
    else if (points !== undefined) addPoints(material, { evaluations: points, ...options });
  }
  return gltf;
}

/** Releases what the GPU holds of the model. */
function unload(gltf) {
  for (const lobes of gltf.userData.lobes ?? []) lobes.dispose();
  gltf.scene.traverse(({ geometry }) => geometry?.dispose());
  for (const material of materialsOf(gltf.scene)) {
    for (const map of Object.values(material)) if (map?.isTexture) map.dispose();
    material.dispose();
  }
}

/**
 * Returns a view of all of `model` from `distance` in `direction` from its centre, and the part of the picture to
 * enlarge.
 */
function framed(model, { direction, distance, ...view }) {
  const box = new THREE.Box3().setFromObject(model), target = box.getCenter(new THREE.Vector3());
  const eye = new THREE.Vector3(...direction).normalize().multiplyScalar(distance).add(target);
  const reach = box.getSize(new THREE.Vector3()).length() / 2;
  // The distance to the point where a ray touches the sphere.
  const away = Math.sqrt(Math.max(distance ** 2 - reach ** 2, 1e-9));
  // For each half of a picture.
  const seen = reach / (away * Math.tan(view.angle * Math.PI / 360)), { width, height } = view;
  const share = Math.min(1, seen), side = 2 * Math.ceil(0.5 * height * share);
  const [w, h] = [Math.min(width, side), Math.min(height, side)];
  return { ...view, eye: eye.toArray(), target: target.toArray(), zoom: Math.max(1, Math.round(1 / share)),
    crop: [(width - w) >> 1, (height - h) >> 1, w, h] };
}

/** Returns the shot of a model for `view`. */
function shotOf(view) {
  const camera = new THREE.PerspectiveCamera(view.angle, view.width / view.height, 0.01, 1000);
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
  return { ...view, camera, sceneOf };
}

function shotFrom(model, asked) {
  const view = asked.direction ? framed(model, asked) : asked;
  return shotOf(asked.moved ? { ...moved(view, asked.moved), crop: [0, 0, view.width, view.height] } : view);
}

const added = (sum, pixels) => pixels.forEach((value, i) => { sum[i] += value; });
const scaled = (pixels, factor) => pixels.map((value) => factor * value);

/**
 * Returns the mean of grids of `shot.samples` x `shot.samples` samples per pixel, each grid shifted by a part of a
 * sample. Also returns the floor over the same samples: one frame whose pixels have exact normals, colours and
 * curvature, so that only the edges of triangles differ. If `exact` is null, there is one grid and no floor. Otherwise
 * grids are added until the noise, half of the difference of two halves, is below NOISE_SHARE of the floor's error or
 * below NOISE_SMALL. There are at most as many samples as in `shot.grids` grids of the whole picture.
 */
function measured(shot, unfiltered, exact) {
  const { camera, width, height, samples, crop } = shot, scene = shot.sceneOf(unfiltered.scene);
  const grid = (number) => drawn(renderer, scene, camera,
    { width, height, samples, crop, shift: shiftOfGrid(number) });
  if (exact === null) return { pixels: grid(0), grids: 1 };
  const halves = [0, 1].map(() => new Float32Array(4 * width * height)), floor = new Float32Array(4 * width * height);
  const floorScene = shot.sceneOf(exact.scene);
  const most = Math.min(GRIDS_MAX, shot.grids * width * height / (crop[2] * crop[3]));
  for (let grids = 2; ; grids *= 2) {
    for (let number = grids === 2 ? 0 : grids / 2; number < grids; ++number) {
      added(halves[number % 2], grid(number));
      exact.setGrid(number);
      added(floor, settled(renderer, floorScene, camera, { ...shot, frames: 1 }));
    }
    const [a, b] = halves.map((half) => scaled(half, 2 / grids)), pixels = a.map((value, i) => (value + b[i]) / 2);
    const noise = compared(a, b).error / 2, found = compared(scaled(floor, 1 / grids), pixels);
    if (noise <= Math.max(NOISE_SHARE * found.error, NOISE_SMALL) || 2 * grids > most)
      return { pixels, floorPixels: scaled(floor, 1 / grids), grids, noise, floor: found };
  }
}

const toText = (pixels) => {
  let text = "";
  for (const byte of new Uint8Array(pixels.buffer)) text += String.fromCharCode(byte);
  return btoa(text);
};
const toPixels = (text) => new Float32Array(Uint8Array.from(atob(text), (one) => one.charCodeAt(0)).buffer);

/** Replaces the room by an EXR picture of the surroundings, latitude and longitude. */
async function surround(url) {
  const picture = await new EXRLoader().loadAsync(url);
  room = new THREE.PMREMGenerator(renderer).fromEquirectangular(picture).texture;
  picture.dispose();
}

/** Begins with another model, { url, reach }, whose references are drawn next. */
async function begin(model) {
  views.clear();
  if (begun) Object.values(begun.gltfs).forEach(unload);
  begun = { model, gltfs: { unfiltered: await load({ ...model, unfiltered: true }) } };
}

/** Returns the properties in which shading is exact, for the reference's grids of samples. */
async function exactOf(samples) {
  begun.gltfs.exact ??= await load({ ...begun.model, exact: samples });
  const { scene } = begun.gltfs.exact;
  return { scene, setGrid(number) { for (const one of materialsOf(scene)) one.userData.setGrid?.(number); } };
}

/**
 * Draws the reference of a view: { name, eye, target, angle, width, height, samples, frames, edges, light, intensity,
 * room, crop, zoom, moved }, or with direction and distance instead of eye, target, crop and zoom. With `grids` it also
 * draws the floor. `moved` is { motion, step } of model_motion.js. Returns { pixels, grids, noise, floor }, with pixels
 * as text. If `kept` has an earlier result, this result is returned without drawing.
 */
async function refer(view, kept = null) {
  const { unfiltered } = begun.gltfs, shot = shotFrom(unfiltered.scene, view);
  const reference = kept ? { ...kept, pixels: toPixels(kept.pixels) }
    : measured(shot, unfiltered, view.grids ? await exactOf(view.samples) : null);
  views.set(view.name, { shot, reference, shown: [reference.pixels] });
  return { ...reference, floorPixels: undefined, pixels: toText(reference.pixels) };
}

/**
 * Draws `model`, { url, lobes, points, options, reach }, in all views. Returns { error, energy, lobed } by view;
 * `lobed` is the number of materials that draw lobes.
 */
async function draw(model) {
  const gltf = await load(model), found = {};
  const lobed = materialsOf(gltf.scene).filter((material) => lobesOf(material) !== null).length;
  for (const [name, { shot, reference, shown }] of views) {
    shown.push(settled(renderer, shot.sceneOf(gltf.scene), shot.camera, shot));
    found[name] = { ...compared(shown.at(-1), reference.pixels), lobed };
  }
  unload(gltf);
  const error = renderer.getContext().getError();
  if (error !== 0) throw new Error(`GL error ${error}`);
  return found;
}

/** Returns the reference of a view and the picture of draw() next to each other: { zoom, strip }, a JPEG in base64. */
async function side(name) {
  const { shot, shown } = views.get(name);
  return { zoom: shot.zoom, strip: await strip(shown, shot.width, shot.crop, shot.zoom) };
}

/** Returns the results of changes() for each picture of draw(), in order, for the views `names`, neighbours in time. */
function motion(names) {
  const floors = names.map((name) => views.get(name).reference.floorPixels);
  const [references, ...drawn] = views.get(names[0]).shown.map((_, number) =>
    names.map((name) => views.get(name).shown[number]));
  return drawn.map((frames) => changes(frames, references, floors));
}

/** Loads models for repeat(). Returns the seconds that each took. */
async function hold(models) {
  held = [];
  const seconds = [];
  for (const model of models) {
    const begin = performance.now();
    held.push(await load(model));
    seconds.push((performance.now() - begin) / 1000);
  }
  return seconds;
}

/** Draws `count` frames of held model `number` in the view `name`, and waits for the last. */
function repeat(number, name, count) {
  const { shot } = views.get(name), scene = shot.sceneOf(held[number].scene), pixel = new Uint16Array(4);
  const { width, height, edges: samples } = shot;
  const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.HalfFloatType, samples });
  renderer.setRenderTarget(target);
  for (let frame = 0; frame < count; ++frame) renderer.render(scene, shot.camera);
  renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel);
  renderer.setRenderTarget(null);
  target.dispose();
}

globalThis.lab = { begin, surround, refer, draw, side, motion, hold, repeat };
