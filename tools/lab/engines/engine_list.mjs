// SPDX-License-Identifier: Apache-2.0
// Lists the engines of engine_pictures.mjs and the view that they draw.
import { fileURLToPath } from "node:url";

const file = (name) => fileURLToPath(new URL(name, import.meta.url));
const TRANSCODER = "/three/examples/jsm/libs/basis/basis_transcoder.js";

/**
 * Distances in metres, angles in degrees, `side` and `crop` in pixels. `samples` is the number of samples along each
 * side of a pixel of the reference. `towardsLight` is the direction to the light and `light` its intensity in the units
 * of three.js. The far view is drawn `frames` times, each `step` degrees further around the sphere. The reference's
 * largest value is below `brightest`. `roughness` is a code of 8 bits.
 */
export const VIEW = { side: 172, angle: 40, near: 1, far: 6, crop: 42, samples: 48, frames: 8, step: 0.5, light: 1.2,
  towardsLight: [0.5, 0.7, 1], sunRadius: 5, texels: 1024, repeat: 12, roughness: 77, brightest: 16 };

/**
 * `module` and `scripts` make the page of browser.mjs. `gltf` contains the options of `multum gltf`, and `exported` the
 * options of `multum export` if the page also loads textures directly. With `sky`, a sun in the environment replaces
 * the directional light. `tone` names the tone mapping.
 */
export const ENGINES = [
  { name: "three", title: "three.js", module: "/engines/three_page.js", gltf: ["--for", "three"],
    exported: ["--for", "three"], package: file("../../../tests/service/web/node_modules/three/package.json") },
  { name: "babylon", title: "Babylon.js", module: "/engines/babylon_page.js", gltf: ["--for", "babylon"],
    exported: ["--for", "babylon"], scripts: ["/modules/babylonjs/babylon.js",
      "/modules/babylonjs-loaders/babylonjs.loaders.min.js", TRANSCODER, "/engines/basis_levels.js"],
    package: file("node_modules/babylonjs/package.json") },
  { name: "playcanvas", title: "PlayCanvas", module: "/engines/playcanvas_page.js", gltf: ["--for", "playcanvas"],
    exported: ["--for", "playcanvas"], package: file("node_modules/playcanvas/package.json") },
  { name: "model_viewer", title: "model-viewer", module: "/engines/model_viewer_page.js", gltf: ["--for", "three"],
    sky: true, package: file("node_modules/@google/model-viewer/package.json") },
  { name: "filament", title: "Filament", module: "/engines/filament_page.js", gltf: ["--for", "filament"],
    exported: ["--for", "filament"], scripts: ["/modules/filament/filament.js"],
    package: file("node_modules/filament/package.json") },
  { name: "cesium", title: "CesiumJS", module: "/engines/cesium_page.js", gltf: ["--format", "uastc"], tone: "neutral",
    before: 'CESIUM_BASE_URL = "/modules/cesium/Build/Cesium/"', scripts: ["/modules/cesium/Build/Cesium/Cesium.js"],
    package: file("node_modules/cesium/package.json") },
];
