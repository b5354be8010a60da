// SPDX-License-Identifier: Apache-2.0
// Draws the model of engine_pictures.mjs with Babylon.js.
import { eyeOf, makeCanvas, pixelsOf } from "./picture.js";

const { BABYLON } = globalThis;
let engine, scene, camera, view;

async function begin(asked) {
  view = asked;
  BABYLON.KhronosTextureContainer2.URLConfig.jsDecoderModule = "/engines/babylon_decoder.js";
  BABYLON.KhronosTextureContainer2.DefaultNumWorkers = 0;
  engine = new BABYLON.Engine(makeCanvas(view.side), true, { preserveDrawingBuffer: true });
}

function directTexture(url) {
  return new Promise((resolve, reject) => {
    const texture = new BABYLON.Texture(url, scene, { noMipmap: false, invertY: false, onLoad: () => resolve(texture),
      onError: (message, error) => reject(error ?? new Error(message)) });
    texture.gammaSpace = false;
  });
}

async function load({ model, normal, orm }) {
  scene = new BABYLON.Scene(engine);
  scene.useRightHandedSystem = true;
  scene.clearColor = new BABYLON.Color4(0, 0, 0, 1);
  camera = new BABYLON.TargetCamera("camera", BABYLON.Vector3.Zero(), scene);
  Object.assign(camera, { fov: view.angle * Math.PI / 180, minZ: 0.1, maxZ: 100 });
  const light = new BABYLON.DirectionalLight("light", new BABYLON.Vector3(...view.towardsLight).scale(-1), scene);
  light.intensity = view.light;
  await BABYLON.SceneLoader.AppendAsync("", model, scene, undefined, ".glb");
  for (const material of normal ? scene.materials : []) {
    const [bumpTexture, metallicTexture] = [await directTexture(normal), await directTexture(orm)];
    Object.assign(material, { bumpTexture, metallicTexture, metallic: 1, roughness: 1,
      useRoughnessFromMetallicTextureAlpha: false, useRoughnessFromMetallicTextureGreen: true,
      useMetallnessFromMetallicTextureBlue: true, useAmbientOcclusionFromMetallicTextureRed: true });
  }
  await scene.whenReadyAsync();
}

async function picture(place) {
  camera.position.fromArray(eyeOf(place));
  camera.setTarget(BABYLON.Vector3.Zero());
  scene.render();
  return pixelsOf(engine.getRenderingCanvas());
}

globalThis.engine = { begin, load, picture };
