// SPDX-License-Identifier: Apache-2.0
// @multum/three draws lobes of normals in three.js's physical materials. README.md explains the package.
export { LobeLoader, LobeTexture } from "./lobe_texture.js";
export { GltfLobes } from "./gltf_lobes.js";
export { addLobes, addPoints, lobesOf, removeLobes, removePoints } from "./lobe_material.js";
