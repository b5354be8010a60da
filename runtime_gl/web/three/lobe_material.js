// SPDX-License-Identifier: Apache-2.0
// Makes materials of three.js draw lobes, or shade several points per pixel. Only the shaders of the materials are
// edited, when they are compiled (onBeforeCompile).
import { ClampToEdgeWrapping, MirroredRepeatWrapping, ObjectSpaceNormalMap, REVISION, ShaderChunk } from "three";
import { fragmentWithLobes } from "./lobe_shading.js";
import { fragmentAtPoints } from "./shading_points.js";

const TAPS_MAX = 16;
// Features of MeshPhysicalMaterial that need more data about normals than lobes provide.
const REFUSED = ["anisotropy", "sheen", "retroreflectivity", "diffuseRoughness"];
const GRIDS = { 1: "ivec2(1)", 2: "ivec2(2, 1)", 4: "ivec2(2)", 8: "ivec2(4, 2)", 16: "ivec2(4)" }; // by evaluations
// The least spread of a pixel's normals at which evaluations are spent on lobes. The spread is read one level finer
// than the pixel's level (README.md, "Evaluations").
const LOBES_FROM = { auto: 0.002, points: 2, lobes: -1 };
const states = new WeakMap(); // changed materials: { lobes, own, onBeforeCompile, customProgramCacheKey }

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
    if (material[name] > 0) refuse(material, `${name} ${material[name]}`, "0: lobes do not support it");
}

function checkNumbers(numbers) {
  for (const [name, value] of Object.entries(numbers))
    if (!Number.isFinite(value)) throw new Error(`${name}: found ${value}, expected a number`);
}

/** Returns the defines for the loop over evaluations. `mapBias` is for the whole pixel. */
function evaluationDefines(evaluations, mapBias) {
  if (!Object.hasOwn(GRIDS, evaluations))
    throw new Error(`evaluations: found ${evaluations}, expected one of ${Object.keys(GRIDS).join(", ")}`);
  return { MULTUM_EVALUATIONS: evaluations, MULTUM_POINTS: GRIDS[evaluations],
    MULTUM_MAP_BIAS: (mapBias - 0.5 * Math.log2(evaluations)).toFixed(3) };
}

/** Returns the number of points with `lobeCount` evaluations each: a power of two, at least 1. */
const lobePoints = (evaluations, lobeCount) => 2 ** Math.max(0, Math.floor(Math.log2(evaluations / lobeCount)));

/** `edit(shader, renderer)` is called when the material is compiled; `key()` distinguishes programs. */
function change(material, lobes, edit, key) {
  restore(material);
  const { onBeforeCompile, customProgramCacheKey } = material;
  const own = ["onBeforeCompile", "customProgramCacheKey"].filter((name) => Object.hasOwn(material, name));
  states.set(material, { lobes, own, onBeforeCompile, customProgramCacheKey });
  material.onBeforeCompile = (shader, renderer) => {
    onBeforeCompile.call(material, shader, renderer);
    edit(shader);
  };
  // The default key is the text of onBeforeCompile, which this add-on has replaced.
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
 * Makes `material` draw `lobes` (LobeTexture) where its normal map is filtered. The roughness of
 * `material` must be that of the surface itself, without the effect of filtered normals.
 *
 * `evaluations` is the number of evaluations of the material's light per pixel: 1, 2, 4, 8 or 16. `spend` says on what
 * they are spent: "points", "lobes", or "auto", which decides for each pixel. `taps` is the number of trilinear lookups
 * along the longer axis of a point's footprint, 1 to 16. `levelBias` and `mapBias` are the octaves added to the level
 * of lobes and of all other maps. Throws Error if the material cannot have lobes. Clones of the material have no lobes.
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
    MULTUM_SPENT_LOBES: Math.min(lobeCount, evaluations),
    MULTUM_LOBE_LAYERS: lobes.layersPerLobe, MULTUM_FIRST_LEVEL: lobes.firstLevel,
    MULTUM_LOBE_POINTS: GRIDS[lobePoints(evaluations, lobeCount)], MULTUM_LOBES_FROM: LOBES_FROM[spend].toFixed(4),
    MULTUM_WRAP_S: wrapCode(material.normalMap?.wrapS), MULTUM_WRAP_T: wrapCode(material.normalMap?.wrapT),
    ...(lobes.colours && { MULTUM_COLOUR_LAYERS: lobes.colours.layersPerFour }) });
  change(material, lobes, (shader) => {
    checkMaterial(material);
    Object.assign(shader.uniforms, { u_lobe_layers: { value: lobes.texture }, u_level_bias: { value: levelBias },
      u_lobe_unpacking: { value: lobes.unpacking }, u_ggx_lobe_table: { value: lobes.ggxTable } });
    if (lobes.colours)
      Object.assign(shader.uniforms, { u_lobe_colours: { value: lobes.colours.texture },
        u_lobe_colour_range: { value: lobes.colours.range } });
    shader.fragmentShader = fragmentWithLobes(shader.fragmentShader, defines(), ShaderChunk, REVISION);
  }, () => Object.values(defines()).join(" "));
}

/**
 * Makes `material`, without lobes, shade `evaluations` points of each pixel: 1, 2, 4, 8 or 16. The change of the
 * geometry's normals within a pixel counts as a variance of slopes. `mapBias` is the number of octaves added to the
 * level of its maps. Throws Error if it is not a physical material. Clones of the material are shaded as before.
 */
export function addPoints(material, { evaluations = 4, mapBias = -0.25 } = {}) {
  checkPhysical(material);
  checkNumbers({ mapBias });
  const defines = evaluationDefines(evaluations, mapBias);
  change(material, null, (shader) => {
    shader.fragmentShader = fragmentAtPoints(shader.fragmentShader, ShaderChunk, REVISION, { defines });
  }, () => Object.values(defines).join(" "));
}

/** Makes `material` draw as before addLobes() or addPoints(). Does nothing if neither was called. */
export function removeLobes(material) { restore(material); }
export const removePoints = removeLobes;

/** Returns the LobeTexture that `material` draws, or null. */
export function lobesOf(material) { return states.get(material)?.lobes ?? null; }
