// SPDX-License-Identifier: Apache-2.0
// Draws the model of engine_pictures.mjs with Filament.
import { eyeOf, makeCanvas, pixelsOf } from "./picture.js";

const canvas = makeCanvas(1);
let Filament, engine, scene, camera, renderer, swapChain, shot, loader, asset, view;

async function begin(asked) {
  view = asked;
  await new Promise((resolve) => { globalThis.Filament.init([], resolve); });
  Filament = globalThis.Filament;
  Object.assign(canvas, { width: view.side, height: view.side });
  canvas.style.width = canvas.style.height = `${view.side}px`;
  engine = Filament.Engine.create(canvas, { preserveDrawingBuffer: true });
  scene = engine.createScene();
  swapChain = engine.createSwapChain();
  renderer = engine.createRenderer();
  renderer.setClearOptions({ clearColor: [0, 0, 0, 1], clear: true });
  camera = engine.createCamera(Filament.EntityManager.get().create());
  camera.setProjectionFov(view.angle, 1, 0.1, 100, Filament.Camera$Fov.VERTICAL);
  camera.setExposureDirect(1);
  shot = engine.createView();
  shot.setCamera(camera);
  shot.setScene(scene);
  shot.setViewport([0, 0, view.side, view.side]);
  shot.setColorGrading(Filament.ColorGrading.Builder().toneMapping(Filament.ColorGrading$ToneMapping.LINEAR)
    .build(engine));
  shot.setAntiAliasing(Filament.View$AntiAliasing.NONE);
  shot.setMultiSampleAntiAliasingOptions({ enabled: true, sampleCount: 4, customResolve: false });
  const light = Filament.EntityManager.get().create(), size = Math.hypot(...view.towardsLight);
  Filament.LightManager.Builder(Filament.LightManager$Type.DIRECTIONAL).color([1, 1, 1]).intensity(view.light)
    .direction(view.towardsLight.map((part) => -part / size)).castShadows(false).build(engine, light);
  scene.addEntity(light);
  loader = engine.createAssetLoader();
}

async function load({ model, normal, orm }) {
  if (asset) scene.removeEntities(asset.getEntities());
  const bytes = new Uint8Array(await (await fetch(model)).arrayBuffer());
  asset = loader.createAsset(bytes);
  await new Promise((resolve) => { asset.loadResources(resolve, null, null, 5); });
  const manager = engine.getRenderableManager();
  for (const entity of normal ? asset.getRenderableEntities() : []) {
    const one = manager.getMaterialInstanceAt(manager.getInstance(entity), 0);
    const sampler = new Filament.TextureSampler(Filament.MinFilter.LINEAR_MIPMAP_LINEAR, Filament.MagFilter.LINEAR,
      Filament.WrapMode.REPEAT);
    for (const [name, url] of [["normalMap", normal], ["metallicRoughnessMap", orm]]) {
      const file = new Uint8Array(await (await fetch(url)).arrayBuffer());
      one.setTextureParameter(name, engine.createTextureFromKtx2(file), sampler);
    }
    one.setFloatParameter("roughnessFactor", 1);
    one.setFloatParameter("metallicFactor", 1);
  }
  scene.addEntities(asset.getEntities());
}

async function picture(place) {
  camera.lookAt(eyeOf(place), [0, 0, 0], [0, 1, 0]);
  for (let frame = 0; frame < 2; ++frame) {
    renderer.render(swapChain, shot);
    engine.execute();
  }
  return pixelsOf(canvas);
}

globalThis.engine = { begin, load, picture };
