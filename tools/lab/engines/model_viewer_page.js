// SPDX-License-Identifier: Apache-2.0
// Draws the model of engine_pictures.mjs with model-viewer. It has no directional light, so a sun in the environment
// lights the model.
import { frames, pixelsOf } from "./picture.js";

globalThis.ModelViewerElement = { ktx2TranscoderLocation: "/three/examples/jsm/libs/basis/" };
const { ModelViewerElement } = await import("/modules/@google/model-viewer/dist/model-viewer.min.js");
let viewer, view;

async function begin(asked) {
  view = asked;
  ModelViewerElement.minimumRenderScale = 1;
}

async function load({ model }) {
  viewer?.remove();
  viewer = document.createElement("model-viewer");
  viewer.style.cssText = `display: block; width: ${view.side}px; height: ${view.side}px; background: #000`;
  for (const [name, value] of Object.entries({ "environment-image": view.sky, "shadow-intensity": "0",
    "interaction-prompt": "none", "camera-target": "0m 0m 0m", "field-of-view": `${view.angle}deg`,
    "min-camera-orbit": "auto 0deg 0.1m", "max-camera-orbit": "auto 180deg 100m", "max-field-of-view": "90deg",
    "min-field-of-view": "10deg", "tone-mapping": "none", loading: "eager", src: model }))
    viewer.setAttribute(name, value);
  const done = new Promise((resolve, reject) => {
    viewer.addEventListener("load", resolve);
    viewer.addEventListener("error", ({ detail }) => reject(new Error(String(detail?.sourceError ?? detail?.type))));
  });
  document.body.append(viewer);
  await done;
}

async function picture({ azimuth, elevation, distance }) {
  viewer.cameraOrbit = `${azimuth}deg ${90 - elevation}deg ${distance}m`;
  await viewer.updateComplete;
  viewer.jumpCameraToGoal();
  await frames(4);
  const image = new Image();
  image.src = viewer.toDataURL("image/png");
  await image.decode();
  return pixelsOf(image, view.side);
}

globalThis.engine = { begin, load, picture };
