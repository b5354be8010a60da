// SPDX-License-Identifier: Apache-2.0
// Draws the model of engine_pictures.mjs with CesiumJS.
import { eyeOf, frames, makeCanvas, pixelsOf } from "./picture.js";

const { Cesium } = globalThis;
const MIDDLE = new Cesium.Cartesian3(1e7, 0, 0); // the place of the model, away from the middle of the Earth
let scene, model, view;

async function begin(asked) {
  view = asked;
  scene = new Cesium.Scene({ canvas: makeCanvas(view.side), scene3DOnly: true, msaaSamples: 4,
    contextOptions: { webgl: { preserveDrawingBuffer: true, antialias: true, alpha: false } } });
  Object.assign(scene, { backgroundColor: Cesium.Color.BLACK, highDynamicRange: false });
  const size = Math.hypot(...view.towardsLight);
  scene.light = new Cesium.DirectionalLight({ intensity: view.light, color: Cesium.Color.WHITE,
    direction: new Cesium.Cartesian3(...view.towardsLight.map((part) => -part / size)) });
  Object.assign(scene.camera.frustum, { fov: view.angle * Math.PI / 180, aspectRatio: 1, near: 0.1, far: 100 });
}

async function load({ model: url }) {
  if (model) scene.primitives.remove(model);
  model = await Cesium.Model.fromGltfAsync({ url, modelMatrix: Cesium.Matrix4.fromTranslation(MIDDLE),
    upAxis: Cesium.Axis.Z, forwardAxis: Cesium.Axis.X, incrementallyLoadTextures: false,
    environmentMapOptions: { enabled: false } });
  model.imageBasedLighting.imageBasedLightingFactor = new Cesium.Cartesian2(0, 0);
  scene.primitives.add(model);
  while (!model.ready) {
    scene.render();
    await frames(1);
  }
}

async function picture(place) {
  const eye = new Cesium.Cartesian3(...eyeOf(place)), { camera } = scene, up = new Cesium.Cartesian3(0, 1, 0);
  const direction = Cesium.Cartesian3.normalize(Cesium.Cartesian3.negate(eye, new Cesium.Cartesian3()),
    new Cesium.Cartesian3());
  const right = Cesium.Cartesian3.normalize(Cesium.Cartesian3.cross(direction, up, new Cesium.Cartesian3()),
    new Cesium.Cartesian3());
  camera.setView({ destination: Cesium.Cartesian3.add(MIDDLE, eye, new Cesium.Cartesian3()),
    orientation: { direction, up: Cesium.Cartesian3.cross(right, direction, new Cesium.Cartesian3()) } });
  for (let frame = 0; frame < 3; ++frame) scene.render();
  return pixelsOf(scene.canvas);
}

globalThis.engine = { begin, load, picture };
