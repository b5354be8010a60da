// SPDX-License-Identifier: Apache-2.0
// Contains the page functions for addon_test.mjs. three.js draws scenes with @multum/three, and the functions return
// linear floats.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { addLobes, addPoints, GltfLobes, LobeLoader, lobesOf, removeLobes, removePoints } from "@multum/three";
import { compared, toByte } from "./linear_pictures.js";

const renderer = new THREE.WebGLRenderer({ antialias: false });
renderer.shadowMap.enabled = true;
const files = new THREE.TextureLoader().setPath("/files/");
const loadLobes = (name, blocks = true) => {
  const loader = new LobeLoader().setPath("/files/");
  return (blocks ? loader.detectSupport(renderer) : loader).loadAsync(name);
};

async function loadNormals() {
  const map = await files.loadAsync("map_normal.png");
  map.flipY = false;
  map.wrapS = map.wrapT = THREE.RepeatWrapping;
  return map;
}

function texels(scene, camera, width, height) {
  const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const pixels = new Float32Array(4 * width * height);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
  renderer.setRenderTarget(null);
  target.dispose();
  const error = renderer.getContext().getError();
  if (error !== 0) throw new Error(`GL error ${error}`);
  return pixels;
}

/** Returns means of `samples` x `samples` pixels. */
function drawn(scene, camera, width, height, samples = 1) {
  if (samples === 1) return texels(scene, camera, width, height);
  const pixels = texels(scene, camera, width * samples, height * samples), made = new Float32Array(4 * width * height);
  for (let y = 0; y < height * samples; ++y)
    for (let x = 0; x < width * samples; ++x)
      for (let c = 0; c < 4; ++c)
        made[4 * (Math.floor(y / samples) * width + Math.floor(x / samples)) + c] +=
          pixels[4 * (y * width * samples + x) + c] / samples ** 2;
  return made;
}

/** multum-view's plane: x from -30 to 30, y from 0 to 60, one repeat of the map per unit, with row 0 at y = 60. */
function planeGeometry(hasTangents = false) {
  const geometry = new THREE.PlaneGeometry(60, 60, 120, 120).translate(0, 30, 0);
  const { position, uv } = geometry.attributes;
  for (let i = 0; i < uv.count; ++i) uv.setXY(i, position.getX(i) + 30, 60 - position.getY(i));
  if (hasTangents) {
    const tangents = Float32Array.from({ length: 4 * uv.count }, (_, i) => [1, 0, 0, 1][i % 4]);
    geometry.setAttribute("tangent", new THREE.BufferAttribute(tangents, 4));
  }
  return geometry;
}

function cameraAt(eye, target, aspect) {
  const camera = new THREE.PerspectiveCamera(40, aspect, 0.01, 200);
  camera.up.set(0, 0, 1);
  camera.position.set(...eye);
  camera.lookAt(...target);
  return camera;
}

const VIEWS = { low: [[0, 0, 0.3], [0, 1, -0.0939]], steep: [[0, 0.5, 1.2], [0, 1.1, 0]],
  far: [[0, 0, 2], [0.5, 5, 0]] };

/** multum-view's defaults that addon_test.mjs does not set by options. */
function surface(normalMap, { Material = THREE.MeshStandardMaterial, hasTangents = false, ...more } = {}) {
  const material = new Material({ color: 0x1a1a1a, roughness: 0.3, metalness: 0, normalMap, ...more });
  material.color.setScalar(0.1);
  // If a model has no tangents, three.js derives them from the texture coordinates. Here, v increases in the direction
  // -y.
  material.normalScale.set(1, hasTangents ? 1 : -1);
  return material;
}

const directional = (direction) => {
  const light = new THREE.DirectionalLight(0xffffff, Math.PI);
  light.position.set(...direction);
  return light;
};

function sceneOf(material, ...objects) {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0, 0, 0);
  const plane = new THREE.Mesh(planeGeometry(material.normalScale.y > 0), material);
  plane.receiveShadow = true;
  scene.add(plane, ...objects);
  return scene;
}

/**
 * Loads a model of one triangle by GLTFLoader with the plugin. `more` holds parts of the glTF, with buffer views in
 * base64.
 */
async function loadModel(material, more, views) {
  const bytes = views.map((one) => Uint8Array.from(atob(one), (c) => c.charCodeAt(0)));
  const corners = new Uint8Array(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer);
  const all = [corners, ...bytes], offsets = all.map((_, i) => all.slice(0, i).reduce((sum, one) =>
    sum + 4 * Math.ceil(one.length / 4), 0));
  const binary = new Uint8Array(offsets.at(-1) + all.at(-1).length);
  all.forEach((one, i) => binary.set(one, offsets[i]));
  const uri = URL.createObjectURL(new Blob([binary]));
  const json = { asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 0, TEXCOORD_0: 1 }, material: 0 }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
      { bufferView: 0, componentType: 5126, count: 3, type: "VEC2" }],
    buffers: [{ uri, byteLength: binary.length }],
    bufferViews: all.map(({ length }, i) => ({ buffer: 0, byteOffset: offsets[i], byteLength: length })),
    materials: [material], extensionsUsed: ["MULTUM_lobes"], ...more };
  const loader = new GLTFLoader().register((parser) => new GltfLobes(parser, renderer));
  return loader.parseAsync(JSON.stringify(json), "");
}

/** Compares a picture of three.js with a PNG of the same view: how many pixels differ by how many of 255. */
async function beside(pixels, width, height, url) {
  const image = await createImageBitmap(await (await fetch(url)).blob());
  const canvas = new OffscreenCanvas(width, height), context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  const want = context.getImageData(0, 0, width, height).data, histogram = [];
  let sum = 0, brightest = 0;
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x)
      for (let c = 0; c < 3; ++c) {
        const wanted = want[4 * (y * width + x) + c], difference =
          Math.abs(wanted - toByte(pixels[4 * ((height - 1 - y) * width + x) + c]));
        histogram[difference] = (histogram[difference] ?? 0) + 1;
        sum += difference;
        brightest = Math.max(brightest, wanted);
      }
  return { mean: sum / (3 * width * height), histogram: Array.from(histogram, (one) => one ?? 0), brightest };
}

/** Returns a picture as a PNG data address, for inspection. */
async function png(pixels, width, height) {
  const canvas = new OffscreenCanvas(width, height), context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x)
      for (let c = 0; c < 4; ++c)
        image.data[4 * (y * width + x) + c] = c === 3 ? 255 : toByte(pixels[4 * ((height - 1 - y) * width + x) + c]);
  context.putImageData(image, 0, 0);
  const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: "image/png" })).arrayBuffer());
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text);
}

globalThis.lab = { THREE, renderer, addLobes, addPoints, LobeLoader, lobesOf, removeLobes, removePoints, loadLobes,
  loadModel, loadNormals,
  drawn, cameraAt, VIEWS, surface, directional, sceneOf, planeGeometry, compared, beside, png };
