// SPDX-License-Identifier: Apache-2.0
// GLSL that the add-on inserts into the fragment shaders of MeshStandardMaterial and MeshPhysicalMaterial. The GLSL
// uses multum's own shading of lobes (multum_lobes.js). three.js calls four functions of a material, such as RE_Direct,
// after its shadows, attenuations and maps. The functions that depend on normals are replaced here by functions that
// add up over lobes. Lobes are converted to view space, where three.js shades.
import { lobesGlsl, lobeTextureGlsl } from "./multum_lobes.js";
import { fragmentAtPoints, replaced, VARIANCE } from "./shading_points.js";

// Computes the normal map's share. An 8-bit level 0 holds unit vectors except for rounding, so its four texels are
// fetched and normalised. Coarser levels are averages whose length matters.
const NORMAL_MAP = `
int multum_wrapped_texel(int i, int size, int mode) {
  if (mode == 1) return clamp(i, 0, size - 1);
  int period = mode == 0 ? size : 2 * size;
  i -= period * (i >= 0 ? i / period : -1 - (-1 - i) / period);
  return i < size ? i : period - 1 - i;
}

vec3 multum_decoded_normal(vec4 texel) {
  vec3 n = texel.xyz * 2.0 - 1.0;
#ifdef USE_PACKED_NORMALMAP
  n.z = sqrt(saturate(1.0 - dot(n.xy, n.xy)));
#endif
  return n;
}

vec3 multum_unit_normal(ivec2 texel, ivec2 size) {
  ivec2 place = ivec2(multum_wrapped_texel(texel.x, size.x, MULTUM_WRAP_S),
                      multum_wrapped_texel(texel.y, size.y, MULTUM_WRAP_T));
  return normalize(multum_decoded_normal(texelFetch(normalMap, place, 0)));
}

vec3 multum_finest_normal(vec2 st, float level) {
  ivec2 size = textureSize(normalMap, 0);
  vec2 place = st * vec2(size) - 0.5;
  ivec2 corner = ivec2(floor(place));
  vec2 share = fract(place);
  vec3 below = mix(multum_unit_normal(corner, size), multum_unit_normal(corner + ivec2(1, 0), size), share.x);
  vec3 above = mix(multum_unit_normal(corner + ivec2(0, 1), size), multum_unit_normal(corner + 1, size), share.x);
  vec3 unit = mix(below, above, share.y);
#if MULTUM_FIRST_LEVEL > 1
  vec3 averaged = multum_decoded_normal(textureLod(normalMap, st, max(level, 1.0)));
  return mix(unit, averaged, min(level, 1.0));
#else
  return unit;
#endif
}
`;

// A pixel's light is the mean of MULTUM_EVALUATIONS evaluations. Each evaluation shades one lobe at one point. If
// normals are similar and there are at least 4 evaluations, three.js's own material is shaded at several points.
// Otherwise evaluations are spent on lobes, or on points if the level is close to the levels of the normal map. All
// lobes of such a point are added up to one. If there are more lobes than evaluations, the most similar lobes are added
// up.
//
// Lobes are read at points, each over its part of the footprint, and turned by the frame of each place before they are
// added up. If a map was baked for a model with few polygons, it compensates for the turns of the model's interpolated
// normals.
const FETCH = `
uniform sampler2D u_ggx_lobe_table;
vec4 multum_lobes[MULTUM_LOBE_COUNT];  // (a r, a) in view space
vec4 multum_lobe;  // lobe of this evaluation, amplitude 1
// The level of lobes at which a pixel is about a third of a texel of the map wide.
const float MULTUM_MAGNIFIED = -2.0 - float(MULTUM_FIRST_LEVEL);
bool multum_lobes_pay = false, multum_is_plain = false, multum_maps_are_read = false;
vec4 multum_read_maps[MULTUM_MAP_COUNT];

#ifdef MULTUM_COLOUR_LAYERS
uniform sampler2DArray u_lobe_colours;  // lobes 4 k to 4 k + 3 in MULTUM_COLOUR_LAYERS layers
uniform float u_lobe_colour_range;
const float MULTUM_TINT_MAX = 4.0;  // limit relative to the common colour, because colours of lobes with few normals
                                    // are noisy
float multum_tints[MULTUM_LOBE_COUNT];  // a lobe's amplitude times its colour factor, minus its amplitude
float multum_tint = 1.0;  // the factor of the evaluation's lobe

void multum_add_tints(vec2 place, MultumFootprint on_lobes, float weight) {
  MultumFootprint footprint =
      multum_footprint_on(on_lobes, multum_lobe_map_size(), textureSize(u_lobe_colours, 0).xy);
  for (int k = 0; 4 * k < MULTUM_LOBE_COUNT; ++k) {
#if MULTUM_COLOUR_LAYERS == 2
    vec4 shares = vec4(multum_filtered(u_lobe_colours, place, float(2 * k), footprint).xy,
                       multum_filtered(u_lobe_colours, place, float(2 * k + 1), footprint).xy);
#else
    vec4 shares = multum_filtered(u_lobe_colours, place, float(k), footprint);
#endif
    for (int j = 4 * k; j < min(4 * k + 4, MULTUM_LOBE_COUNT); ++j)
      multum_tints[j] += weight * u_lobe_colour_range * (2.0 * shares[j - 4 * k] - 1.0);
  }
}
#endif

vec4 multum_turned(mat3 frame, vec4 lobe) {
  // Tangents that are not at right angles turn a lobe but keep its width.
  vec3 turned = frame * lobe.xyz;
  return vec4(turned * (length(lobe.xyz) / max(length(turned), 1e-12)), lobe.w);
}

vec4 multum_normal_map_part(vec2 st, MultumFootprint on_map) {
  float level = clamp(on_map.level, 0.0, float(MULTUM_FIRST_LEVEL - 1));
  vec2 place = multum_first_tap(st, on_map);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < on_map.tap_count; ++i) sum += multum_finest_normal(place + float(i) * on_map.tap_step, level);
  return multum_movmf_magnified(vec4(sum / float(on_map.tap_count), 1.0),
                                multum_footprint_longer_lod(on_map, textureSize(normalMap, 0)));
}

// Does the same as three.js's getTangentFrame(), with derivatives that are already computed.
mat3 multum_tangent_frame(vec3 n) {
  vec3 across_y = cross(-multum_along_y_vViewPosition, n), across_x = cross(n, -multum_along_x_vViewPosition);
  vec2 along_x = multum_along_x_vNormalMapUv, along_y = multum_along_y_vNormalMapUv;
  vec3 t = across_y * along_x.x + across_x * along_y.x, b = across_y * along_x.y + across_x * along_y.y;
  float square = max(dot(t, t), dot(b, b));
  float scale = square == 0.0 ? 0.0 : inversesqrt(square);
  return mat3(t * scale, b * scale, n);
}

// Returns the frame at \`shift\` pixels from the shaded point.
mat3 multum_frame(vec2 shift, float side) {
#ifdef FLAT_SHADED
  vec3 n = normalize(cross(dFdx(vViewPosition), dFdy(vViewPosition)));
#else
  vec3 n = normalize(vNormal + shift.x * multum_along_x_vNormal + shift.y * multum_along_y_vNormal);
#ifdef DOUBLE_SIDED
  n *= side;
#endif
#endif
#ifdef USE_TANGENT
  mat3 frame = mat3(normalize(vTangent), normalize(vBitangent), n);
#else
  mat3 frame = multum_tangent_frame(n);
#endif
#if defined(DOUBLE_SIDED) && !defined(FLAT_SHADED)
  frame[0] *= side;
  frame[1] *= side;
#endif
  frame[0] *= sign(normalScale.x);
  frame[1] *= sign(normalScale.y);
  return frame;
}

// Returns the footprint of a part of the pixel. \`part\` is a share of its width and height.
MultumFootprint multum_part_footprint(vec2 part) {
  vec2 size = vec2(multum_lobe_map_size());
  return multum_footprint_of(part.x * multum_along_x_vNormalMapUv * size, part.y * multum_along_y_vNormalMapUv * size,
                             size);
}

// Fetches the lobes of the part of the pixel about the shaded point, at \`count\` places in this part.
void multum_fetch_lobes(float count, vec2 part, float side) {
  vec2 size = vec2(multum_lobe_map_size());
  vec2 grid = multum_point_grid(count, length(part.x * multum_along_x_vNormalMapUv * size),
                                length(part.y * multum_along_y_vNormalMapUv * size));
  vec2 share = part / grid;
  MultumFootprint footprint = multum_part_footprint(share);
  MultumFootprint on_map = multum_footprint_on(footprint, multum_lobe_map_size(), textureSize(normalMap, 0));
  float map_share = multum_normal_map_share(footprint.level);
  for (int j = 0; j < MULTUM_LOBE_COUNT; ++j) multum_lobes[j] = vec4(0.0);
#ifdef MULTUM_COLOUR_LAYERS
  for (int j = 0; j < MULTUM_LOBE_COUNT; ++j) multum_tints[j] = 0.0;
#endif
  for (float i = 0.0; i < count; ++i) {
    vec2 shift = part * multum_point_place(i, grid);
    vec2 place = vNormalMapUv + shift.x * multum_along_x_vNormalMapUv + shift.y * multum_along_y_vNormalMapUv;
    mat3 frame = multum_frame(shift, side);
    MultumSurface surface = multum_fetch_surface(place, footprint);
    for (int j = 0; j < MULTUM_LOBE_COUNT; ++j)
      multum_lobes[j] += (1.0 - map_share) * multum_turned(frame, surface.lobes[j]);
#ifdef MULTUM_COLOUR_LAYERS
    if (multum_lobes_pay) multum_add_tints(place, footprint, 1.0 - map_share);
#endif
    if (map_share > 0.0) multum_lobes[0] += map_share * multum_turned(frame, multum_normal_map_part(place, on_map));
  }
#if MULTUM_SPENT_LOBES < MULTUM_LOBE_COUNT
  for (int left = MULTUM_LOBE_COUNT; multum_lobes_pay && left > MULTUM_SPENT_LOBES; --left) {
    ivec2 alike = multum_alike_parts(multum_lobes, left);
    multum_lobes[alike.x] += multum_lobes[alike.y];
    multum_lobes[alike.y] = multum_lobes[left - 1];
    multum_lobes[left - 1] = vec4(0.0);
  }
#endif
}

// Decides how to spend a pixel's evaluations. On a strongly magnified map, normals hardly change within a point, so
// three.js shades the points with the map's own normals. Otherwise, the decision depends on the spread of the normals
// around the pixel, read one level finer than the pixel's own level. Four neighbouring pixels share derivatives and
// must read textures together, because the lookups need these derivatives. These pixels use one place between them, so
// that all four decide in the same way.
void multum_decide() {
  MultumFootprint footprint = multum_part_footprint(vec2(1.0));
  vec2 side = 0.5 - mod(floor(gl_FragCoord.xy), 2.0);
  float level = footprint.level + side.x * dFdx(footprint.level) + side.y * dFdy(footprint.level);
  multum_is_plain = level <= MULTUM_MAGNIFIED;
#if MULTUM_EVALUATIONS >= 2
  bool is_near = multum_normal_map_share(level - 1.0) > 0.0;
  footprint.level = max(level - 1.0, 0.0);
  vec2 place = vNormalMapUv + side.x * multum_along_x_vNormalMapUv + side.y * multum_along_y_vNormalMapUv;
  MultumSurface surface = multum_fetch_surface(place, footprint);
  vec4 sum = vec4(0.0);
  for (int j = 0; j < MULTUM_LOBE_COUNT; ++j) sum += surface.lobes[j];
  bool is_alike = multum_movmf_spread(sum) <= MULTUM_LOBES_FROM;
  multum_is_plain = multum_is_plain || (is_alike && MULTUM_EVALUATIONS >= 4);
  multum_lobes_pay = MULTUM_LOBE_COUNT > 1 && !is_alike && !is_near;
#endif
}

ivec2 multum_points() { return multum_lobes_pay ? MULTUM_LOBE_POINTS : MULTUM_POINTS; }

// Reads all other maps over a point's part of the pixel. If evaluations are spent on lobes, there are fewer points. A
// point's maps are then means over several places, so that the number of places stays the same. The maps are read when
// the point's first lobe is shaded, and reused for its other lobes.
vec4 multum_map(int number, sampler2D map, vec2 st, vec2 along_x, vec2 along_y) {
  if (multum_maps_are_read) return multum_read_maps[number];
  ivec2 points = multum_points(), places = MULTUM_POINTS / points;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < places.x * places.y; ++i) {
    vec2 shift = ((vec2(i % places.x, i / places.x) + 0.5) / vec2(places) - 0.5) / vec2(points);
    sum += texture2D(map, st + shift.x * along_x + shift.y * along_y, MULTUM_MAP_BIAS);
  }
  multum_read_maps[number] = sum / float(places.x * places.y);
  return multum_read_maps[number];
}

// Returns the evaluation's point, in pixels from the pixel's middle.
vec2 multum_shift(int evaluation) {
  ivec2 points = multum_points();
  int point = multum_lobes_pay ? evaluation / MULTUM_SPENT_LOBES : evaluation;
  multum_maps_are_read = multum_lobes_pay && evaluation % MULTUM_SPENT_LOBES > 0;
  return multum_point_place(float(point), vec2(points));
}

// Sets the evaluation's lobe. Returns its weight.
float multum_take_lobe(int evaluation, vec3 normal, float side) {
  if (multum_is_plain) {
    multum_lobe = vec4(normal, 1.0);
    return 1.0 / float(MULTUM_EVALUATIONS);
  }
  ivec2 points = multum_points();
  vec2 part = 1.0 / vec2(points);
  int number = multum_lobes_pay ? evaluation % MULTUM_SPENT_LOBES : 0;
  if (number == 0) multum_fetch_lobes(max(4.0 * part.x * part.y, 1.0), part, side);
  vec4 sum = vec4(0.0);
  for (int j = 0; j < MULTUM_LOBE_COUNT; ++j) sum += multum_lobes[j];
  multum_lobe = multum_lobes_pay ? multum_lobes[number] : sum;
  float weight = part.x * part.y * multum_lobe.w / max(sum.w, 1e-6);
#ifdef MULTUM_COLOUR_LAYERS
  float tint = 1.0 + multum_tints[number] / max(multum_lobe.w, 1e-6);
  if (multum_lobes_pay) multum_tint = clamp(tint, 0.0, MULTUM_TINT_MAX);
#endif
  multum_lobe = vec4(multum_lobe.xyz / max(multum_lobe.w, 1e-6), 1.0);
  // With three lobes, only three of four evaluations are used.
  return multum_lobes_pay && evaluation >= points.x * points.y * MULTUM_SPENT_LOBES ? 0.0 : weight;
}
`;

const DIRECT = `
void RE_Direct_Multum(const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal,
                      const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal,
                      const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
  if (multum_is_plain) {
    RE_Direct_Physical(directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal,
                       material, reflectedLight);
    return;
  }
  vec3 l = directLight.direction, v = geometryViewDir;
  if (directLight.color == vec3(0.0)) return;
#ifdef USE_CLEARCOAT
  clearcoatSpecularDirect += saturate(dot(geometryClearcoatNormal, l)) * directLight.color *
                             BRDF_GGX_Clearcoat(l, v, geometryClearcoatNormal, material);
#endif
  vec3 h = normalize(l + v);
  float v_h = saturate(dot(v, h));
  float specular = multum_movmf_ggx_specular(u_ggx_lobe_table, multum_lobe, l, v, h,
                                             pow2(max(material.roughness, 0.045)));
  vec3 fresnel = F_Schlick(material.specularColorBlended, material.specularF90, v_h);
#ifdef USE_IRIDESCENCE
  fresnel = mix(fresnel, material.iridescenceFresnel, material.iridescence);
#endif
  reflectedLight.directSpecular += directLight.color * specular * fresnel * material.multiScatteringCompensation;
  vec3 through = 1.0 - F_Schlick(material.specularColor, material.specularF90, v_h);
  reflectedLight.directDiffuse += directLight.color * multum_movmf_lambert(multum_lobe, l) *
                                  BRDF_Lambert(material.diffuseContribution) * through;
}
#undef RE_Direct
#define RE_Direct RE_Direct_Multum
`;

// Computes light that three.js supports only for one normal and one roughness. A lobe is therefore reduced to its mean
// direction and to a roughness that is widened by the lobe's slopes, alpha^2 + 2 / kappa. The amount of reflected light
// follows from the surface's roughness.
const INDIRECT = `
float multum_widened_roughness(float roughness) {
  float alpha = pow2(roughness);
  float kappa = max(multum_vmf_kappa(multum_movmf_spread(multum_lobe)), 1e-6);
  return sqrt(sqrt(min(alpha * alpha + 2.0 / kappa, 1.0)));
}

vec2 multum_dfg(float roughness, vec3 v) {
  float n_v = multum_vmf_mean_cosine(multum_movmf_spread(multum_lobe),
                                     dot(multum_movmf_mean_direction(multum_lobe), v));
  return texture2D(dfgLUT, vec2(roughness, n_v)).rg;
}

#if defined(USE_ENVMAP) && defined(ENVMAP_TYPE_PMREM)
vec3 multum_radiance(vec3 v, vec3 normal, float roughness) {
  return getIBLRadiance(v, normal, multum_is_plain ? roughness : multum_widened_roughness(roughness));
}

// The environment's harmonics of order 1 are scaled by the length of the lobe's mean vector.
vec3 multum_irradiance(vec3 normal) {
  vec3 along = getIBLIrradiance(normal);
  float spread = multum_is_plain ? 0.0 : multum_movmf_spread(multum_lobe);
  return spread > 0.0 ? mix(along, getIBLIrradiance(-normal), 0.5 * spread) : along;
}

void RE_IndirectSpecular_Multum(const in vec3 radiance, const in vec3 irradiance, const in vec3 clearcoatRadiance,
                                const in vec3 geometryPosition, const in vec3 geometryNormal,
                                const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal,
                                const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
  PhysicalMaterial part = material;
  if (!multum_is_plain) part.dfg = multum_dfg(material.roughness, geometryViewDir);
  RE_IndirectSpecular_Physical(radiance, irradiance, clearcoatRadiance, geometryPosition, geometryNormal,
                               geometryViewDir, geometryClearcoatNormal, part, reflectedLight);
}
#undef RE_IndirectSpecular
#define RE_IndirectSpecular RE_IndirectSpecular_Multum
#endif

#if NUM_RECT_AREA_LIGHTS > 0
void RE_Direct_RectArea_Multum(const in RectAreaLight rectAreaLight, const in vec3 geometryPosition,
                               const in vec3 geometryNormal, const in vec3 geometryViewDir,
                               const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material,
                               inout ReflectedLight reflectedLight) {
  PhysicalMaterial part = material;
  if (!multum_is_plain) {
    part.roughness = multum_widened_roughness(material.roughness);
    part.dfg = multum_dfg(material.roughness, geometryViewDir);
  }
  RE_Direct_RectArea_Physical(rectAreaLight, geometryPosition, geometryNormal, geometryViewDir,
                              geometryClearcoatNormal, part, reflectedLight);
}
#undef RE_Direct_RectArea
#define RE_Direct_RectArea RE_Direct_RectArea_Multum
#endif
`;

// Only the signs of normalScale are used, for the direction of green, because lobes already contain the scale.
const NORMAL = `
multum_weight = multum_take_lobe(multum_evaluation, normal, faceDirection);
if (dot(multum_lobe.xyz, multum_lobe.xyz) > 1e-12) normal = normalize(multum_lobe.xyz);
#ifdef MULTUM_COLOUR_LAYERS
diffuseColor.rgb *= multum_tint;
#endif
`;

// Lobes that are read at several places already contain the variance of the geometry's normals.
const GEOMETRY = `
if (multum_is_plain || (!multum_lobes_pay && MULTUM_EVALUATIONS >= 4)) ${VARIANCE}
`;

/**
 * Returns the fragment shader of a physical material with lobes. `defines` and three.js's `chunks` are keyed by name.
 */
export function fragmentWithLobes(fragment, defines, chunks, revision) {
  const edit = (name, chunk) => {
    if (name === "normal_fragment_maps") return `${chunk}\n${NORMAL}`;
    // A hemisphere's light is linear in the normal, so the lobe's mean gives the exact result.
    if (name === "lights_fragment_begin")
      return replaced(chunk, "hemisphereLights[ i ], geometryNormal", "hemisphereLights[ i ], multum_lobe.xyz",
        revision);
    if (name === "lights_fragment_maps")
      return [["getIBLIrradiance( geometryNormal )", "multum_irradiance( geometryNormal )"],
        ["getIBLRadiance( geometryViewDir, geometryNormal,", "multum_radiance( geometryViewDir, geometryNormal,"]]
        .reduce((text, [from, to]) => replaced(text, from, to, revision), chunk);
    return chunk;
  };
  const lobes = [lobesGlsl, lobeTextureGlsl, NORMAL_MAP, FETCH, DIRECT, INDIRECT].join("\n");
  return fragmentAtPoints(fragment, chunks, revision, { defines, lobes, geometry: GEOMETRY, edit });
}
