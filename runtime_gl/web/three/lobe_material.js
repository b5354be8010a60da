// SPDX-License-Identifier: Apache-2.0
// Materials of three.js that draw lobes, or shade several points of a pixel. Their shaders get that as they are
// compiled (onBeforeCompile); nothing else of a material changes.
import { ClampToEdgeWrapping, MirroredRepeatWrapping, ObjectSpaceNormalMap, REVISION, ShaderChunk } from "three";
import { fragmentWithLobes } from "./lobe_shading.js";
import { fragmentAtPoints } from "./shading_points.js";

const TAPS_MAX = 16;
// Of MeshPhysicalMaterial: what asks for more of a normal than lobes have.
const REFUSED = ["anisotropy", "sheen", "retroreflectivity", "diffuseRoughness"];
const GRIDS = { 1: "ivec2(1)", 2: "ivec2(2, 1)", 4: "ivec2(2)", 8: "ivec2(4, 2)", 16: "ivec2(4)" }; // by evaluations
// Least spread of a pixel's normals, two levels finer, for which evaluations go to lobes: README.md, "Evaluations".
const LOBES_FROM = { auto: 0.002, points: 2, lobes: -1 };
const states = new WeakMap(); // of changed materials: { lobes, own, onBeforeCompile, customProgramCacheKey }

const wrapCode = (wrapping) => ({ [ClampToEdgeWrapping]: 1, [MirroredRepeatWrapping]: 2 })[wrapping] ?? 0;

function refuse(material, found, expected) {
  throw new Error(`material '${material?.name ?? ""}': found ${found}, expected ${expected}`);
}

function checkPhysical(material) {
  if (!material?.isMeshStandardMaterial)
    refuse(material, material?.type ?? "no material", "a MeshStandardMaterial or MeshPhysicalMaterial");
}

function checkMaterial(material) {
  checkPhysical(material);
  if (!material.normalMap)
    refuse(material, "no normalMap", "the map that its lobes were baked from, which has their level 0");
  if (material.normalMapType === ObjectSpaceNormalMap)
    refuse(material, "normals in object space", "a map in tangent space");
  const { x, y } = material.normalScale;
  if (Math.abs(Math.abs(x) - 1) > 1e-6 || Math.abs(Math.abs(y) - 1) > 1e-6)
    refuse(material, `normalScale ${x}, ${y}`,
      "1 or -1: another scale is baked into lobes (multum bake --normal-scale)");
  for (const name of REFUSED)
    if (material[name] > 0) refuse(material, `${name} ${material[name]}`, "0: lobes do not know it");
}

function checkNumbers(numbers) {
  for (const [name, value] of Object.entries(numbers))
    if (!Number.isFinite(value)) throw new Error(`${name}: found ${value}, expected a number`);
}

/** What the loop over evaluations is compiled with. `mapBias` is over the whole pixel. */
function evaluationDefines(evaluations, mapBias) {
  if (!Object.hasOwn(GRIDS, evaluations))
    throw new Error(`evaluations: found ${evaluations}, expected one of ${Object.keys(GRIDS).join(", ")}`);
  return { MULTUM_EVALUATIONS: evaluations, MULTUM_POINTS: GRIDS[evaluations],
    MULTUM_MAP_BIAS: (mapBias - 0.5 * Math.log2(evaluations)).toFixed(3) };
}

/** Evaluations that are spent on lobes: as many points as are a power of two and have `lobeCount` each; 1 at least. */
const lobePoints = (evaluations, lobeCount) => 2 ** Math.max(0, Math.floor(Math.log2(evaluations / lobeCount)));

/** `edit(shader, renderer)` is called as the material is compiled; `key()` tells programs apart. */
function change(material, lobes, edit, key) {
  restore(material);
  const { onBeforeCompile, customProgramCacheKey } = material;
  const own = ["onBeforeCompile", "customProgramCacheKey"].filter((name) => Object.hasOwn(material, name));
  states.set(material, { lobes, own, onBeforeCompile, customProgramCacheKey });
  material.onBeforeCompile = (shader, renderer) => {
    onBeforeCompile.call(material, shader, renderer);
    edit(shader);
  };
  // The default key is the text of onBeforeCompile, which is no longer the material's own.
  material.customProgramCacheKey = () =>
    [onBeforeCompile.toString(), customProgramCacheKey.call(material), "multum", key()].join(" ");
  material.needsUpdate = true;
}

function restore(material) {
  const state = states.get(material);
  if (state === undefined) return;
  for (const name of ["onBeforeCompile", "customProgramCacheKey"]) {
    if (state.own.includes(name)) material[name] = state[name];
    else delete material[name];
  }
  states.delete(material);
  material.needsUpdate = true;
}

/**
 * Has `material` draw `lobes` (LobeTexture) where its normal map is filtered. Its roughness stays the surface's own.
 *
 * `evaluations`: of the material's light in a pixel, 1, 2, 4, 8 or 16. `spend`: on "points", on "lobes", or on either,
 * pixel by pixel ("auto"). `taps`: trilinear lookups along the longer axis of a point's footprint, 1 to 16. `levelBias`
 * and `mapBias`: octaves added to the level of lobes and of all other maps. Throws Error where the material cannot have
 * lobes. Clones of the material have none.
 */
export function addLobes(material, lobes,
  { evaluations = 4, spend = "auto", taps = 1, levelBias = -0.5, mapBias = -0.5 } = {}) {
  checkMaterial(material);
  checkNumbers({ levelBias, mapBias });
  if (!Number.isInteger(taps) || taps < 1 || taps > TAPS_MAX)
    throw new Error(`taps: found ${taps}, expected a whole number from 1 to ${TAPS_MAX}`);
  if (!Object.hasOwn(LOBES_FROM, spend))
    throw new Error(`spend: found ${spend}, expected one of ${Object.keys(LOBES_FROM).join(", ")}`);
  if (!lobes?.texture?.isCompressedArrayTexture || lobes.ggxTable === null)
    throw new Error(`material '${material.name}': found no lobes, or disposed ones, expected a LobeTexture`);
  const spent = evaluationDefines(evaluations, mapBias), { lobeCount } = lobes;
  const defines = () => ({ ...spent, MULTUM_TAPS: taps, MULTUM_LOBE_COUNT: lobeCount,
    MULTUM_LOBE_LAYERS: lobes.layersPerLobe, MULTUM_FIRST_LEVEL: lobes.firstLevel,
    MULTUM_LOBE_POINTS: GRIDS[lobePoints(evaluations, lobeCount)], MULTUM_LOBES_FROM: LOBES_FROM[spend].toFixed(4),
    MULTUM_WRAP_S: wrapCode(material.normalMap?.wrapS), MULTUM_WRAP_T: wrapCode(material.normalMap?.wrapT) });
  change(material, lobes, (shader) => {
    checkMaterial(material);
    Object.assign(shader.uniforms, { u_lobe_layers: { value: lobes.texture }, u_level_bias: { value: levelBias },
      u_lobe_unpacking: { value: lobes.unpacking }, u_ggx_lobe_table: { value: lobes.ggxTable } });
    shader.fragmentShader = fragmentWithLobes(shader.fragmentShader, defines(), ShaderChunk, REVISION);
  }, () => Object.values(defines()).join(" "));
}

/**
 * Has `material`, without lobes, shade `evaluations` points of each pixel, 1, 2, 4, 8 or 16, and take the change of the
 * geometry's normals within a pixel for a variance of slopes. `mapBias`: octaves added to the level of its maps. Throws
 * Error where it is no physical material. Clones of the material are shaded as before.
 */
export function addPoints(material, { evaluations = 4, mapBias = -0.25 } = {}) {
  checkPhysical(material);
  checkNumbers({ mapBias });
  const defines = evaluationDefines(evaluations, mapBias);
  change(material, null, (shader) => {
    shader.fragmentShader = fragmentAtPoints(shader.fragmentShader, ShaderChunk, REVISION, { defines });
  }, () => Object.values(defines).join(" "));
}

/** Has `material` draw as it did before addLobes() or addPoints(); nothing where neither was called. */
export function removeLobes(material) { restore(material); }
export const removePoints = removeLobes;

/** The LobeTexture that `material` draws; null: none. */
export function lobesOf(material) { return states.get(material)?.lobes ?? null; }
