// SPDX-License-Identifier: Apache-2.0
// Draws the model of engine_pictures.mjs with three.js, and its reference.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { HDRLoader } from "three/addons/loaders/HDRLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
import { drawn, settled } from "/tests/model_drawing.js";
import { eyeOf, makeCanvas, pixelsOf } from "./picture.js";

let renderer, ktx2, scene, camera, view;
const materials = () => {
  const found = [];
  scene.traverse(({ material }) => { if (material) found.push(material); });
  return found;
};

async function begin(asked) {
  view = asked;
  renderer = new THREE.WebGLRenderer({ canvas: makeCanvas(view.side), antialias: true, preserveDrawingBuffer: true });
  renderer.setSize(view.side, view.side, false);
  ktx2 = new KTX2Loader().setTranscoderPath("/three/examples/jsm/libs/basis/").detectSupport(renderer);
  camera = new THREE.PerspectiveCamera(view.angle, 1, 0.1, 100);
}

async function load({ model, normal, orm }) {
  const gltf = await new GLTFLoader().setKTX2Loader(ktx2).loadAsync(model);
  scene = new THREE.Scene().add(gltf.scene);
  scene.background = new THREE.Color(0);
  if (view.sky) {
    const equirect = await new HDRLoader().loadAsync(view.sky);
    equirect.mapping = THREE.EquirectangularReflectionMapping;
    scene.environment = new THREE.PMREMGenerator(renderer).fromEquirectangular(equirect).texture;
  } else {
    const light = new THREE.DirectionalLight(0xffffff, view.light);
    light.position.set(...view.towardsLight);
    scene.add(light);
  }
  for (const material of normal ? materials() : []) {
    const [normalMap, surface] = await Promise.all([normal, orm].map((url) => ktx2.loadAsync(url)));
    for (const map of [normalMap, surface])
      Object.assign(map, { wrapS: THREE.RepeatWrapping, wrapT: THREE.RepeatWrapping, colorSpace: THREE.NoColorSpace });
    normalMap.minFilter = surface.minFilter = THREE.LinearMipmapLinearFilter;
    normalMap.magFilter = surface.magFilter = THREE.LinearFilter;
    Object.assign(material, { normalMap, roughnessMap: surface, metalnessMap: surface, roughness: 1, metalness: 1 });
    material.normalScale.set(1, -1);
    material.needsUpdate = true;
  }
}

function look(place) {
  camera.position.set(...eyeOf(place));
  camera.lookAt(0, 0, 0);
}

async function picture(place) {
  look(place);
  renderer.render(scene, camera);
  return pixelsOf(renderer.domElement);
}

/**
 * Returns the linear picture of the loaded model without mips of data maps, each pixel the mean of `samples` x
 * `samples`, inside of the square of `crop` pixels in the middle.
 */
async function reference(place, samples, crop) {
  for (const material of materials())
    for (const map of [material.normalMap, material.roughnessMap])
      if (map?.generateMipmaps) Object.assign(map, { minFilter: THREE.LinearFilter, generateMipmaps: false,
        needsUpdate: true });
  look(place);
  const from = (view.side - crop) / 2;
  const pixels = drawn(renderer, scene, camera, { width: view.side, height: view.side, samples,
    crop: [from, from, crop, crop] });
  renderer.setSize(view.side, view.side, false);
  return [...pixels];
}

/** Returns the linear picture of a frame with four samples of edges per pixel. */
function linear(place) {
  look(place);
  const pixels = settled(renderer, scene, camera, { width: view.side, height: view.side, frames: 1, edges: 4 });
  renderer.setSize(view.side, view.side, false);
  return [...pixels];
}

globalThis.engine = { begin, load, picture, linear, reference };
