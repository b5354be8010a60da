// SPDX-License-Identifier: Apache-2.0
// Draws the model of engine_pictures.mjs with PlayCanvas.
import * as pc from "playcanvas";
import { eyeOf, makeCanvas, pixelsOf } from "./picture.js";

let app, camera, shown, view;

async function begin(asked) {
  view = asked;
  const basis = "/three/examples/jsm/libs/basis/basis_transcoder";
  pc.basisInitialize({ glueUrl: `${basis}.js`, wasmUrl: `${basis}.wasm`, fallbackUrl: `${basis}.js`, lazyInit: true });
  app = new pc.Application(makeCanvas(view.side), { graphicsDeviceOptions: { antialias: true,
    preserveDrawingBuffer: true } });
  app.graphicsDevice.maxPixelRatio = 1;
  app.setCanvasResolution(pc.RESOLUTION_FIXED, view.side, view.side);
  app.autoRender = false;
  app.scene.ambientLight = new pc.Color(0, 0, 0);
  camera = new pc.Entity("camera");
  camera.addComponent("camera", { fov: view.angle, nearClip: 0.1, farClip: 100, clearColor: new pc.Color(0, 0, 0),
    toneMapping: pc.TONEMAP_LINEAR, gammaCorrection: pc.GAMMA_SRGB });
  const light = new pc.Entity("light");
  light.addComponent("light", { type: "directional", intensity: view.light });
  // The light of an entity comes from the entity's positive y axis.
  light.setRotation(new pc.Quat().setFromDirections(pc.Vec3.UP, new pc.Vec3(...view.towardsLight).normalize()));
  app.root.addChild(camera);
  app.root.addChild(light);
  app.start();
}

const loaded = (url, kind) => new Promise((resolve, reject) => {
  app.assets.loadFromUrl(url, kind, (error, asset) => (error ? reject(new Error(error)) : resolve(asset.resource)));
});

async function load({ model, normal, orm }) {
  shown?.destroy();
  shown = (await loaded(model, "container")).instantiateRenderEntity();
  app.root.addChild(shown);
  for (const { material } of shown.findComponents("render").flatMap((one) => one.meshInstances)) {
    material.enableGGXSpecular = true; // otherwise, lights reflect by Blinn and Phong's model
    material.update();
  }
  for (const { material } of normal ? shown.findComponents("render").flatMap((one) => one.meshInstances) : []) {
    const [normalMap, surface] = [await loaded(normal, "texture"), await loaded(orm, "texture")];
    for (const map of [normalMap, surface]) map.minFilter = pc.FILTER_LINEAR_MIPMAP_LINEAR;
    Object.assign(material, { normalMap, metalnessMap: surface, metalnessMapChannel: "b", metalness: 1,
      glossMap: surface, glossMapChannel: "g", gloss: 1, glossInvert: true });
    material.update();
  }
}

async function picture(place) {
  camera.setPosition(...eyeOf(place));
  camera.lookAt(pc.Vec3.ZERO);
  app.renderNextFrame = true;
  app.tick?.(performance.now());
  app.render();
  return pixelsOf(app.graphicsDevice.canvas);
}

globalThis.engine = { begin, load, picture };
