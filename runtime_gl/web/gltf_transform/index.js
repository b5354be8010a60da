// SPDX-License-Identifier: Apache-2.0
// Reads and writes the extension MULTUM_lobes in glTF-Transform.
export { Lobes, MaterialLobes } from "./lobe_properties.js";
export { MultumLobes } from "./multum_lobes.js";
