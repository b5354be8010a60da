// SPDX-License-Identifier: Apache-2.0
// What the add-on puts into the fragment shader of MeshStandardMaterial and MeshPhysicalMaterial, around the shading of
// lobes that multum draws with itself (multum_lobes.js). three.js asks a material for four functions, RE_Direct and the
// like, behind its shadows, attenuations and maps; those that depend on normals are replaced here, by ones that add up
// over lobes. Lobes are taken to the space of the view, where three.js shades.
import { lobesGlsl, lobeTextureGlsl } from "./multum_lobes.js";

// The normal map's share: level 0 of 8 bits holds unit vectors but for their rounding, so its four texels are fetched
// and made unit; coarser levels are averages whose length counts.
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

const FETCH = `
#define MULTUM_NORMALS (MULTUM_LOBE_COUNT + 1)
uniform sampler2D u_ggx_lobe_table;
vec4 multum_lobes[MULTUM_NORMALS];  // (a r, a), the normal map's last
vec3 multum_mean_normal;  // the sum of a r

void multum_fetch_lobes(vec2 st, mat3 frame) {
  MultumFootprint footprint = multum_surface_footprint(st);
  MultumSurface surface = multum_fetch_surface(st, footprint);
  vec4 finest = vec4(0.0);
  if (footprint.level < 0.0) {
    MultumFootprint on_map =
        multum_footprint_on(footprint, multum_lobe_map_size(), textureSize(normalMap, 0));
    float level = clamp(on_map.level, 0.0, float(MULTUM_FIRST_LEVEL - 1));
    vec2 place = multum_first_tap(st, on_map);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < on_map.tap_count; ++i)
      sum += multum_finest_normal(place + float(i) * on_map.tap_step, level);
    finest = multum_normal_map_share(footprint.level) *
        multum_movmf_magnified(vec4(sum / float(on_map.tap_count), 1.0),
                               multum_footprint_longer_lod(on_map, textureSize(normalMap, 0)));
  }
  multum_mean_normal = vec3(0.0);
  for (int j = 0; j < MULTUM_NORMALS; ++j) {
    vec4 lobe = j < MULTUM_LOBE_COUNT ? (1.0 - finest.w) * surface.lobes[min(j, MULTUM_LOBE_COUNT - 1)] : finest;
    // Tangents that are not at right angles turn a lobe, and leave it its width.
    vec3 turned = frame * lobe.xyz;
    turned *= length(lobe.xyz) / max(length(turned), 1e-12);
    multum_lobes[j] = vec4(turned, lobe.w);
    multum_mean_normal += turned;
  }
}
`;

const DIRECT = `
void RE_Direct_Multum(const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal,
                      const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal,
                      const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
  vec3 l = directLight.direction, v = geometryViewDir;
  if (directLight.color == vec3(0.0)) return;
#ifdef USE_CLEARCOAT
  clearcoatSpecularDirect += saturate(dot(geometryClearcoatNormal, l)) * directLight.color *
                             BRDF_GGX_Clearcoat(l, v, geometryClearcoatNormal, material);
#endif
  vec3 h = normalize(l + v);
  float v_h = saturate(dot(v, h));
  float alpha = pow2(max(material.roughness, 0.045));
  float specular = 0.0, lambert = 0.0;
  for (int j = 0; j < MULTUM_NORMALS; ++j) {
    specular += multum_movmf_ggx_specular(u_ggx_lobe_table, multum_lobes[j], l, v, h, alpha);
    lambert += multum_movmf_lambert(multum_lobes[j], l);
  }
  vec3 fresnel = F_Schlick(material.specularColorBlended, material.specularF90, v_h);
#ifdef USE_IRIDESCENCE
  fresnel = mix(fresnel, material.iridescenceFresnel, material.iridescence);
#endif
  reflectedLight.directSpecular += directLight.color * specular * fresnel * material.multiScatteringCompensation;
  vec3 through = 1.0 - F_Schlick(material.specularColor, material.specularF90, v_h);
  reflectedLight.directDiffuse += directLight.color * lambert * BRDF_Lambert(material.diffuseContribution) * through;
}
#undef RE_Direct
#define RE_Direct RE_Direct_Multum
`;

// Light that three.js knows for one normal and roughness alone: a lobe is its mean direction, and a roughness that is
// wider by the lobe's slopes, alpha^2 + 2 / kappa.
const INDIRECT = `
PhysicalMaterial multum_widened(const in PhysicalMaterial material, vec4 lobe, vec3 mu, vec3 v) {
  PhysicalMaterial part = material;
  float alpha = pow2(material.roughness);
  part.roughness = sqrt(sqrt(min(alpha * alpha + 2.0 / max(multum_vmf_kappa(multum_movmf_spread(lobe)), 1e-6), 1.0)));
  part.dfg = texture2D(dfgLUT, vec2(part.roughness, saturate(dot(mu, v)))).rg;
  return part;
}

#if defined(USE_ENVMAP) && defined(ENVMAP_TYPE_PMREM)
// Of a lobe: the environment's harmonics of order 1 shrink by the length of its mean vector.
vec3 multum_environment_irradiance(vec3 mu, float spread) {
  vec3 along = getIBLIrradiance(mu);
  return spread > 0.0 ? mix(along, getIBLIrradiance(-mu), 0.5 * spread) : along;
}
#endif

void RE_IndirectSpecular_Multum(const in vec3 radiance, const in vec3 irradiance, const in vec3 clearcoatRadiance,
                                const in vec3 geometryPosition, const in vec3 geometryNormal,
                                const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal,
                                const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
#if defined(USE_ENVMAP) && defined(ENVMAP_TYPE_PMREM)
  for (int j = 0; j < MULTUM_NORMALS; ++j) {
    vec4 lobe = multum_lobes[j];
    if (lobe.w <= MULTUM_AMPLITUDE_MIN) continue;
    vec3 mu = multum_movmf_mean_direction(lobe);
    PhysicalMaterial part = multum_widened(material, lobe, mu, geometryViewDir);
    ReflectedLight of_part = ReflectedLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    RE_IndirectSpecular_Physical(getIBLRadiance(geometryViewDir, mu, part.roughness),
                                 multum_environment_irradiance(mu, multum_movmf_spread(lobe)), vec3(0.0),
                                 geometryPosition, mu, geometryViewDir, geometryClearcoatNormal, part, of_part);
    reflectedLight.indirectSpecular += lobe.w * of_part.indirectSpecular;
    reflectedLight.indirectDiffuse += lobe.w * of_part.indirectDiffuse;
  }
#ifdef USE_CLEARCOAT
  clearcoatSpecularIndirect += clearcoatRadiance *
      EnvironmentBRDF(geometryClearcoatNormal, geometryViewDir, material.clearcoatF0, material.clearcoatF90,
                      material.clearcoatRoughness);
#endif
#else
  RE_IndirectSpecular_Physical(radiance, irradiance, clearcoatRadiance, geometryPosition, geometryNormal,
                               geometryViewDir, geometryClearcoatNormal, material, reflectedLight);
#endif
}
#undef RE_IndirectSpecular
#define RE_IndirectSpecular RE_IndirectSpecular_Multum

#if NUM_RECT_AREA_LIGHTS > 0
void RE_Direct_RectArea_Multum(const in RectAreaLight rectAreaLight, const in vec3 geometryPosition,
                               const in vec3 geometryNormal, const in vec3 geometryViewDir,
                               const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material,
                               inout ReflectedLight reflectedLight) {
  vec3 clearcoat = clearcoatSpecularDirect;
  for (int j = 0; j < MULTUM_NORMALS; ++j) {
    vec4 lobe = multum_lobes[j];
    if (lobe.w <= MULTUM_AMPLITUDE_MIN) continue;
    clearcoatSpecularDirect = clearcoat;  // each part adds the same
    vec3 mu = multum_movmf_mean_direction(lobe);
    PhysicalMaterial part = multum_widened(material, lobe, mu, geometryViewDir);
    ReflectedLight of_part = ReflectedLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    RE_Direct_RectArea_Physical(rectAreaLight, geometryPosition, mu, geometryViewDir, geometryClearcoatNormal, part,
                                of_part);
    reflectedLight.directSpecular += lobe.w * of_part.directSpecular;
    reflectedLight.directDiffuse += lobe.w * of_part.directDiffuse;
  }
}
#undef RE_Direct_RectArea
#define RE_Direct_RectArea RE_Direct_RectArea_Multum
#endif
`;

// Green points the way that normalScale says; how far is in the lobes.
const NORMAL = `
multum_fetch_lobes(vNormalMapUv, mat3(sign(normalScale.x) * tbn[0], sign(normalScale.y) * tbn[1], tbn[2]));
if (dot(multum_mean_normal, multum_mean_normal) > 1e-12) normal = normalize(multum_mean_normal);
`;

/** `text` with `to` in place of `from`; an Error where it is not there. */
function replaced(text, from, to, revision) {
  if (!text.includes(from))
    throw new Error(`@multum/three: found no ${from.trim()} in the shaders of three.js r${revision}, expected one as ` +
      "r187 has it: a newer version of the package may know this release");
  return text.replace(from, () => to);
}

/** The fragment shader of a physical material with lobes; `defines` by name, `chunks` of three.js. */
export function fragmentWithLobes(fragment, defines, chunks, revision) {
  const head = Object.entries(defines).map(([name, value]) => `#define ${name} ${value}\n`).join("");
  const shading = [head, lobesGlsl, lobeTextureGlsl, NORMAL_MAP, FETCH, DIRECT, INDIRECT].join("\n");
  const after = (text, include, more) => replaced(text, include, `${include}\n${more}`, revision);
  let text = after(fragment, "#include <normalmap_pars_fragment>", shading);
  text = after(text, "#include <normal_fragment_maps>", NORMAL);
  // A hemisphere's light is linear in the normal: the mean of the lobes' is exact.
  const lights = replaced(chunks.lights_fragment_begin, "hemisphereLights[ i ], geometryNormal",
    "hemisphereLights[ i ], multum_mean_normal", revision);
  return replaced(text, "#include <lights_fragment_begin>", lights, revision);
}
