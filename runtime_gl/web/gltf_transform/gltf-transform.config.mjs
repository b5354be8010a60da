// SPDX-License-Identifier: Apache-2.0
// Settings with which the command gltf-transform keeps lobes: gltf-transform COMMAND ... --config THIS_FILE
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
import { MultumLobes } from "./index.js";

export default { extensions: [...ALL_EXTENSIONS, MultumLobes] };
