// SPDX-License-Identifier: Apache-2.0
// Materials of three.js that draw lobes: their shaders get them as they are compiled (onBeforeCompile), and nothing
// else of a material changes.
import { ClampToEdgeWrapping, MirroredRepeatWrapping, ObjectSpaceNormalMap, REVISION, ShaderChunk } from "three";
import { fragmentWithLobes } from "./lobe_shading.js";

const TAPS_MAX = 16;
// Of MeshPhysicalMaterial: what asks for more of a normal than lobes have.
const REFUSED = ["anisotropy", "sheen", "retroreflectivity", "diffuseRoughness"];
const states = new WeakMap(); // of materials with lobes: { lobes, onBeforeCompile, customProgramCacheKey }

const wrapCode = (wrapping) => ({ [ClampToEdgeWrapping]: 1, [MirroredRepeatWrapping]: 2 })[wrapping] ?? 0;

function checkMaterial(material) {
  const refuse = (found, expected) => {
    throw new Error(`material '${material?.name ?? ""}': found ${found}, expected ${expected}`);
  };
  if (!material?.isMeshStandardMaterial)
    refuse(material?.type ?? "no material", "a MeshStandardMaterial or MeshPhysicalMaterial");
  if (!material.normalMap) refuse("no normalMap", "the map that its lobes were baked from, which has their level 0");
  if (material.normalMapType === ObjectSpaceNormalMap) refuse("normals in object space", "a map in tangent space");
  const { x, y } = material.normalScale;
  if (Math.abs(Math.abs(x) - 1) > 1e-6 || Math.abs(Math.abs(y) - 1) > 1e-6)
    refuse(`normalScale ${x}, ${y}`, "1 or -1: another scale is baked into lobes (multum bake --normal-scale)");
  for (const name of REFUSED)
    if (material[name] > 0) refuse(`${name} ${material[name]}`, "0: lobes do not know it");
}

function checkOptions({ taps, levelBias }) {
  if (!Number.isInteger(taps) || taps < 1 || taps > TAPS_MAX)
    throw new Error(`taps: found ${taps}, expected a whole number from 1 to ${TAPS_MAX}`);
  if (!Number.isFinite(levelBias)) throw new Error(`levelBias: found ${levelBias}, expected a number`);
}

/**
 * Has `material` draw `lobes` (LobeTexture) where its normal map is filtered. Its roughness stays the surface's own.
 * `taps`: trilinear lookups along a pixel's longer axis, 1 to 16; `levelBias`: octaves added to the level of lobes
 * (docs/FILTER.md). Throws Error where the material cannot have them. Clones of the material have none.
 */
export function addLobes(material, lobes, { taps = 2, levelBias = -0.25 } = {}) {
  checkMaterial(material);
  checkOptions({ taps, levelBias });
  if (!lobes?.texture?.isCompressedArrayTexture || lobes.ggxTable === null)
    throw new Error(`material '${material.name}': found no lobes, or disposed ones, expected a LobeTexture`);
  removeLobes(material);
  const { onBeforeCompile, customProgramCacheKey } = material;
  const own = ["onBeforeCompile", "customProgramCacheKey"].filter((name) => Object.hasOwn(material, name));
  states.set(material, { lobes, own, onBeforeCompile, customProgramCacheKey });
  const defines = () => ({ MULTUM_TAPS: taps, MULTUM_LOBE_COUNT: lobes.lobeCount,
    MULTUM_LOBE_LAYERS: lobes.layersPerLobe, MULTUM_FIRST_LEVEL: lobes.firstLevel,
    MULTUM_WRAP_S: wrapCode(material.normalMap?.wrapS), MULTUM_WRAP_T: wrapCode(material.normalMap?.wrapT) });
  material.onBeforeCompile = (shader, renderer) => {
    checkMaterial(material);
    onBeforeCompile.call(material, shader, renderer);
    Object.assign(shader.uniforms, { u_lobe_layers: { value: lobes.texture }, u_level_bias: { value: levelBias },
      u_lobe_unpacking: { value: lobes.unpacking }, u_ggx_lobe_table: { value: lobes.ggxTable } });
    shader.fragmentShader = fragmentWithLobes(shader.fragmentShader, defines(), ShaderChunk, REVISION);
  };
  // The default key is the text of onBeforeCompile, which is no longer the material's own.
  material.customProgramCacheKey = () => [onBeforeCompile.toString(), customProgramCacheKey.call(material), "multum",
    ...Object.values(defines())].join(" ");
  material.needsUpdate = true;
}

/** Has `material` draw as it did before; nothing where it has no lobes. */
export function removeLobes(material) {
  const state = states.get(material);
  if (state === undefined) return;
  for (const name of ["onBeforeCompile", "customProgramCacheKey"]) {
    if (state.own.includes(name)) material[name] = state[name];
    else delete material[name];
  }
  states.delete(material);
  material.needsUpdate = true;
}

/** The LobeTexture that `material` draws; null: none. */
export function lobesOf(material) { return states.get(material)?.lobes ?? null; }
