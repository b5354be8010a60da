// SPDX-License-Identifier: Apache-2.0
// Makes the fragment shader of a physical material shade several points per pixel, each over its part of the footprint.
// The light of the points is averaged before tone mapping. three.js's own text becomes the body of a loop, and
// interpolated values are moved to each point.

/** Returns `text` with `from` replaced by `to`. Throws Error if `text` does not contain `from`. */
export function replaced(text, from, to, revision) {
  if (!text.includes(from))
    throw new Error(`@multum/three: found no ${from.trim()} in the shaders of three.js r${revision}, expected one as ` +
      "r187 has it: a newer version of the package may support this release");
  return text.replace(from, () => to);
}

// The names of three.js's varyings. `multum_NAME` is the value of NAME at the point.
const MOVED = "vUv vMapUv vAlphaMapUv vLightMapUv vAoMapUv vBumpMapUv vNormalMapUv vEmissiveMapUv vMetalnessMapUv " +
  "vRoughnessMapUv vAnisotropyMapUv vClearcoatMapUv vClearcoatNormalMapUv vClearcoatRoughnessMapUv vIridescenceMapUv " +
  "vIridescenceThicknessMapUv vSheenColorMapUv vSheenRoughnessMapUv vSpecularMapUv vSpecularColorMapUv " +
  "vSpecularIntensityMapUv vNormal vTangent vBitangent vViewPosition vColor";
const DECLARED = new RegExp(`varying (vec[234]) (${MOVED.split(" ").join("|")});`, "g");
const BODY = ["#include <map_fragment>", "#include <opaque_fragment>"]; // the body's first line, the line after it

const movable = (text) => text.replace(DECLARED, (declared, type, name) => `${declared}
${type} multum_${name}, multum_along_x_${name}, multum_along_y_${name};
void multum_derive_${name}() {
  multum_along_x_${name} = dFdx(${name});
  multum_along_y_${name} = dFdy(${name});
}
void multum_move_${name}(vec2 by) {
  multum_${name} = ${name} + by.x * multum_along_x_${name} + by.y * multum_along_y_${name};
}
#define ${name} multum_${name}
`);

const each = (call) => MOVED.split(" ").map((name) => `#ifdef ${name}\n  ${call(name)};\n#endif\n`).join("");
const MOVE = `
void multum_derive() {
${each((name) => `multum_derive_${name}()`)}}
void multum_move(vec2 by) {  // offset from the pixel's middle, in pixels
${each((name) => `multum_move_${name}(by)`)}}
`;
// Defines the functions that differ for lobes, for materials without lobes.
const PLAIN = `
void multum_decide() {}
vec4 multum_map(int number, sampler2D map, vec2 st, vec2 along_x, vec2 along_y) {
  return texture2D(map, st, MULTUM_MAP_BIAS);
}
vec2 multum_shift(int evaluation) {
  return (vec2(evaluation % MULTUM_POINTS.x, evaluation / MULTUM_POINTS.x) + 0.5) / vec2(MULTUM_POINTS) - 0.5;
}
`;

const BEGIN = `
  vec4 multum_colour = diffuseColor;
  vec3 multum_light = vec3(0.0);
  float multum_alpha = 0.0, multum_transmission = 0.0;
  multum_derive();
  multum_move(vec2(0.0));
  multum_decide();
  for (int multum_evaluation = 0; multum_evaluation < MULTUM_EVALUATIONS; ++multum_evaluation) {
    float multum_weight = 1.0 / float(MULTUM_EVALUATIONS);
    multum_move(multum_shift(multum_evaluation));
    diffuseColor = multum_colour;
    reflectedLight = ReflectedLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    totalEmissiveRadiance = emissive;
#ifdef USE_CLEARCOAT
    clearcoatSpecularDirect = clearcoatSpecularIndirect = vec3(0.0);
#endif
#ifdef USE_SHEEN
    sheenSpecularDirect = sheenSpecularIndirect = vec3(0.0);
#endif
`;
const END = `
    multum_light += multum_weight * outgoingLight;
    multum_alpha += multum_weight * diffuseColor.a;
#ifdef USE_TRANSMISSION
    multum_transmission += multum_weight * material.transmissionAlpha;
#endif
  }
  diffuseColor.a = multum_alpha;
  vec3 outgoingLight = multum_light;
`;
// The alpha test is done once for the whole pixel, with its mean alpha.
const ALPHA_TESTS = ["alphatest_fragment", "alphahash_fragment"];

// GEOMETRY is three.js's line, which adds the largest change of a normal's component to the roughness. VARIANCE
// replaces this line. It adds the variance of the normals over the point's part of the pixel, for a box filter
// (Kaplanyan et al. 2016; Tokuyoshi and Kaplanyan 2019).
const GEOMETRY = "material.roughness += geometryRoughness;";
export const VARIANCE = `{
  vec3 along_x = dFdx(nonPerturbedNormal), along_y = dFdy(nonPerturbedNormal);
  float variance = (dot(along_x, along_x) + dot(along_y, along_y)) / (12.0 * float(MULTUM_EVALUATIONS));
  material.roughness = sqrt(sqrt(min(pow2(pow2(material.roughness)) + variance, 1.0)));
}`;

/**
 * Returns the fragment shader of a physical material that is shaded at MULTUM_EVALUATIONS points of each pixel. Maps
 * are sampled MULTUM_MAP_BIAS octaves coarser than for the whole pixel. `defines` are by name. `lobes`, if given, is
 * GLSL with multum_decide(), multum_shift() and multum_map(), whose first parameter numbers the lookups. `geometry` is
 * GLSL that adds the variance of the geometry's normals to the roughness. `edit(name, text)` returns the replacement of
 * a chunk's text.
 */
export function fragmentAtPoints(fragment, chunks, revision,
  { defines, lobes = null, geometry = VARIANCE, edit = (name, text) => text }) {
  const written = (text, isWanted) => movable(text.replace(/#include <(\w+)>/g, (include, name) =>
    isWanted(name) ? edit(name, chunks[name]) : include));
  for (const line of BODY) replaced(fragment, line, "", revision); // throws an Error if the line is missing
  const [main, first, behind] = ["void main() {", ...BODY].map((line) => fragment.indexOf(line));
  const declared = written(fragment.slice(0, main), (name) => /^(uv|normal|color)_pars_fragment$/.test(name));
  let body = ALPHA_TESTS.reduce((text, name) => replaced(text, `#include <${name}>`, "", revision),
    fragment.slice(first, behind));
  body = written(body, (name) => chunks[name] !== undefined);
  body = replaced(body, GEOMETRY, geometry, revision);
  let mapCount = 0;
  body = body.replace(/texture2D\( (\w+), (v\w+Uv) \)/g, (lookup, map, uv) =>
    `multum_map( ${mapCount++}, ${map}, ${uv}, multum_along_x_${uv}, multum_along_y_${uv} )`);
  const opaque = replaced(chunks.opaque_fragment, "material.transmissionAlpha", "multum_transmission", revision);
  const rest = ALPHA_TESTS.map((name) => `#include <${name}>\n`).join("") +
    replaced(fragment.slice(behind), BODY[1], opaque, revision);
  const head = Object.entries({ ...defines, MULTUM_MAP_COUNT: Math.max(1, mapCount) })
    .map(([name, value]) => `#define ${name} ${value}\n`).join("");
  return head + declared + MOVE + (lobes ?? PLAIN) + fragment.slice(main, first) + BEGIN + body + END + rest;
}
