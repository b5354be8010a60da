// SPDX-License-Identifier: Apache-2.0
// Shades one normal per fragment in one of four ways. Exactly one of these flags is defined:
//   MULTUM_REFERENCE  the finest map's nearest texel    MULTUM_TOKSVIG  |averaged normal| -> gloss (Toksvig 2004)
//   MULTUM_MIP        averaged normal, normalised       MULTUM_LEAN     slope moments (Olano and Baker 2010):
//                                                       density of slopes; MULTUM_JACOBIAN: / cos^3, normalised
// REFERENCE has variants that replace the nearest texel. MULTUM_DRAWN_TEXEL chooses one of the four surrounding texels
// at random. MULTUM_FOOTPRINT chooses one of the texels that the texture filter averages. MULTUM_INTERPOLATED
// interpolates the four normals. With MULTUM_ROUGHNESS, the lengths of normals hold a BRDF's width, and REFERENCE uses
// each normal's own width. With MULTUM_ROUGHNESS_MAP (not REFERENCE), normals have unit length, and the width comes
// from a roughness map, averaged as in an engine. With MULTUM_BASIS k, everything is multiplied by weight k. With
// MULTUM_COLOURS, the map has colours. With MULTUM_NORMAL_MAP, levels finer than the stored ones come from the normal
// map. The normal map has no moments of slopes, so these levels are shaded by Toksvig's rule, before mixing. With
// MULTUM_ALBEDO_MAP, their colours come from the albedo map. MIP, TOKSVIG and LEAN read a baked file of moments, or
// mips of the finest map, which contain the same values.
uniform sampler2D u_normals;  // unit normal for REFERENCE, otherwise averaged normal, with w = E[b_s b_t] for LEAN
#ifdef MULTUM_LEAN
uniform sampler2D u_slopes;  // E[b_s], E[b_t], E[b_s^2], E[b_t^2]
#endif
#ifdef MULTUM_COLOURS
uniform sampler2D u_albedo;
#endif
#ifdef MULTUM_BASIS
uniform sampler2D u_weights;
#endif
#ifdef MULTUM_ROUGHNESS_MAP
uniform sampler2D u_roughness;  // perceptual roughness
#endif
#ifdef MULTUM_NORMAL_MAP
uniform sampler2D u_normal_map;  // averaged normals of the finer levels
#endif
#ifdef MULTUM_ALBEDO_MAP
uniform sampler2D u_albedo_map;
#endif

struct MultumSurface {
  vec4 normal;
  vec3 albedo;
  float weight;
#ifdef MULTUM_LEAN
  vec4 slopes;
#endif
#ifdef MULTUM_ROUGHNESS_MAP
  float roughness;
#endif
#ifdef MULTUM_NORMAL_MAP
  vec4 finest;  // mean normal; w = its share
  vec3 finest_albedo;
#endif
};

ivec2 multum_surface_size() { return textureSize(u_normals, 0); }

#if defined(MULTUM_REFERENCE) && !defined(MULTUM_FOOTPRINT)
// Reads the finest level at one place. The only filter is interpolation between its texels.
MultumFootprint multum_surface_footprint(vec2 st) { return MultumFootprint(vec2(0.0), 1, 0.0); }
#else
MultumFootprint multum_surface_footprint(vec2 st) { return multum_footprint(u_normals, st); }
#endif

#ifdef MULTUM_INTERPOLATED
// Interpolates the direction of four texels, and separately their lengths, which include roughness.
vec4 multum_interpolated_normal(vec2 st) {
  ivec2 size = textureSize(u_normals, 0);
  vec2 place = st * vec2(size) - 0.5;
  vec2 share = fract(place);
  vec3 sum = vec3(0.0);
  float lengths = 0.0;
  for (int k = 0; k < 4; ++k) {
    ivec2 corner = ivec2(k & 1, k >> 1);
    ivec2 texel = ivec2(floor(place)) + corner;
    texel = ivec2(multum_wrapped(texel.x, size.x, u_wrap_s), multum_wrapped(texel.y, size.y, u_wrap_t));
    if (min(texel.x, texel.y) < 0) continue;
    vec2 weights = mix(1.0 - share, share, vec2(corner));
    vec3 n = weights.x * weights.y * texelFetch(u_normals, texel, 0).xyz;
    sum += n;
    lengths += length(n);
  }
  return vec4(sum * (lengths / max(length(sum), 1e-12)), 0.0);
}
#endif

#ifdef MULTUM_DRAWN_TEXEL
MultumSurface multum_fetch_surface(vec2 st, MultumFootprint footprint) {
  MultumSurface surface = MultumSurface(vec4(0.0), vec3(1.0), 1.0);
  ivec2 texel = multum_footprint_texel(u_normals, st, footprint);
  if (texel == MULTUM_NO_TEXEL) return surface;
  surface.normal = texelFetch(u_normals, texel, 0);
#ifdef MULTUM_COLOURS
  surface.albedo = texelFetch(u_albedo, texel, 0).rgb;
#endif
#ifdef MULTUM_BASIS
  surface.weight = texelFetch(u_weights, texel, 0)[MULTUM_BASIS];
#endif
  return surface;
}
#else
MultumSurface multum_fetch_surface(vec2 st, MultumFootprint footprint) {
  MultumSurface surface;
#ifdef MULTUM_INTERPOLATED
  surface.normal = multum_interpolated_normal(st);
#else
  surface.normal = multum_filtered(u_normals, st, footprint);
#endif
  surface.albedo = vec3(1.0);
#ifdef MULTUM_COLOURS
  surface.albedo = multum_filtered(u_albedo, st, footprint).rgb;
#endif
#ifdef MULTUM_LEAN
  surface.slopes = multum_filtered(u_slopes, st, footprint);
#endif
  surface.weight = 1.0;
#ifdef MULTUM_BASIS
  surface.weight = multum_filtered(u_weights, st, footprint)[MULTUM_BASIS];
#endif
#ifdef MULTUM_ROUGHNESS_MAP
  surface.roughness = multum_filtered(u_roughness, st, footprint).r;
#endif
#ifdef MULTUM_NORMAL_MAP
  MultumFootprint on_map = multum_footprint_on(footprint, textureSize(u_normals, 0), textureSize(u_normal_map, 0));
  surface.finest.xyz = multum_normal_map_lobe(u_normal_map, st, on_map).xyz;
  surface.finest.w = multum_normal_map_share(footprint.level);
  surface.finest_albedo = surface.albedo;  // colour of the first stored level, the finest known
#ifdef MULTUM_ALBEDO_MAP
  surface.finest_albedo = multum_filtered(u_albedo_map, st, on_map).rgb;
#endif
#endif
  return surface;
}
#endif

// Where the length of the mean is smaller, there is no material, because the place is beyond a black border of the map.
// Normals above the surface never have a mean of 0.
const float MULTUM_MEAN_MIN = 1e-12;

// Returns the material's Blinn-Phong exponent. For a roughness p, alpha = p^2, the peak equals that of Beckmann's and
// GGX's distributions: s = 2 / alpha^2 - 2. The exponent is limited to u_exponent.
float multum_exponent(MultumSurface surface) {
#ifdef MULTUM_ROUGHNESS_MAP
  float alpha = surface.roughness * surface.roughness;
  return clamp(2.0 / max(alpha * alpha, 1e-12) - 2.0, 0.0, u_exponent);
#else
  return u_exponent;
#endif
}

// Returns the exponent s for which 1 / s is the variance of the material's slopes. For a roughness, this variance is
// Beckmann's alpha^2 / 2.
float multum_slope_exponent(MultumSurface surface) {
#ifdef MULTUM_ROUGHNESS_MAP
  return multum_exponent(surface) + 2.0;
#else
  return u_exponent;
#endif
}

#ifdef MULTUM_TURNED
// Returns a mean normal, shortened by the variance v of the geometry's normals. A vMF with the variance v / 2 along
// each axis has 1 - |r| = v / 2.
vec3 multum_turned_mean(vec3 mean) { return mean / (1.0 + 0.5 * multum_turn_variance); }

// Returns the moments of slopes, with the variance of the geometry added along each axis.
vec4 multum_turned_slopes(vec4 slopes) { return slopes + vec4(0.0, 0.0, vec2(0.5 * multum_turn_variance)); }

// Returns Blinn-Phong's exponent with the variance of the geometry added. 1 / s is the variance along each axis.
float multum_turned_exponent(float s) { return s / (1.0 + 0.5 * multum_turn_variance * s); }
#else
#define multum_turned_exponent(s) (s)
#define multum_turned_mean(mean) (mean)
#define multum_turned_slopes(slopes) (slopes)
#endif

// Returns max(E[n] . l, 0).
float multum_mean_cosine(vec3 mean, vec3 l) {
#ifdef MULTUM_ROUGHNESS
  mean = multum_movmf_without_roughness(vec4(mean, 1.0), u_mean_cosine).xyz;
#endif
  return max(dot(mean, l), 0.0);
}

// The highlight's cosine is the cosine of the averaged normal.
MultumReflection multum_reflect_mean(vec3 mean, vec3 albedo, vec3 facets, float diffuse, vec3 l, vec3 v, vec3 h) {
  vec3 n = normalize(mean);
  float n_l = max(dot(n, l), 0.0);
  vec3 specular = facets * n_l;
#ifdef MULTUM_VISIBILITY
  specular *= multum_visibility(n_l, max(dot(n, v), 0.0), max(dot(n, h), 0.0), dot(v, h));
#endif
  return MultumReflection(albedo * diffuse, specular);
}

MultumReflection multum_reflect_texel(MultumSurface surface, vec3 l, vec3 v, vec3 h) {
  vec3 mean = surface.normal.xyz;
  float size = length(mean);
  if (size <= MULTUM_MEAN_MIN) return MultumReflection(vec3(0.0), vec3(0.0));
#if defined(MULTUM_TOKSVIG) || defined(MULTUM_LEAN)
  float diffuse = multum_mean_cosine(mean, l);
#else
  float diffuse = max(dot(mean / size, l), 0.0);
#endif
  vec3 facets = vec3(0.0);
#if defined(MULTUM_LAMBERT)
#elif defined(MULTUM_TOKSVIG)
  facets = u_facet_total * multum_moments_toksvig(multum_turned_mean(mean), h, multum_exponent(surface));
#elif defined(MULTUM_LEAN)
#ifdef MULTUM_JACOBIAN
  const bool with_jacobian = true;
#else
  const bool with_jacobian = false;
#endif
  facets = u_facet_total * multum_moments_lean(multum_turned_slopes(surface.slopes), surface.normal.w, h,
                                               multum_slope_exponent(surface), with_jacobian);
#elif defined(MULTUM_ROUGHNESS_MAP)
  facets = u_facet_total * multum_blinn_phong(multum_turned_exponent(multum_exponent(surface)),
                                              multum_one_minus_cosine(mean / size, h));
#elif defined(MULTUM_ROUGHNESS)
  facets = multum_lobe_facets(vec4(multum_turned_mean(mean), 1.0), h);
#elif defined(MULTUM_TURNED)
  facets = multum_lobe_facets(vec4(multum_turned_mean(mean / size), 1.0), h);
#else
  facets = multum_facets(mean / size, h);
#endif
  return multum_reflect_mean(mean, surface.albedo, facets, diffuse, l, v, h);
}

MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h) {
  MultumReflection sum = multum_reflect_texel(surface, l, v, h);
#ifdef MULTUM_NORMAL_MAP
  MultumReflection finest = MultumReflection(vec3(0.0), vec3(0.0));
  vec3 mean = surface.finest.xyz;
  vec3 facets = u_facet_total * multum_moments_toksvig(multum_turned_mean(mean), h, u_exponent);
  if (length(mean) > MULTUM_MEAN_MIN)
    finest = multum_reflect_mean(mean, surface.finest_albedo, facets, multum_mean_cosine(mean, l), l, v, h);
  sum.diffuse = mix(sum.diffuse, finest.diffuse, surface.finest.w);
  sum.specular = mix(sum.specular, finest.specular, surface.finest.w);
#endif
  sum.diffuse *= surface.weight;
  sum.specular *= surface.weight;
  return sum;
}

#ifdef MULTUM_ENVIRONMENT
// Treats a mean normal as a lobe whose mean vector has its length. MIP treats it as one normal.
MultumReflection multum_reflect_environment(MultumSurface surface, vec3 v) {
  vec3 mean = surface.normal.xyz;
  if (length(mean) <= MULTUM_MEAN_MIN) return MultumReflection(vec3(0.0), vec3(0.0));
#if defined(MULTUM_REFERENCE)
  MultumReflection sum = multum_environment_normal(normalize(mean), v);
#elif defined(MULTUM_MIP)
  MultumReflection sum = multum_environment_lobe(vec4(multum_turned_mean(normalize(mean)), 1.0), v);
#else
  MultumReflection sum = multum_environment_lobe(vec4(multum_turned_mean(mean), 1.0), v);
#endif
  sum.diffuse *= surface.albedo;
#ifdef MULTUM_NORMAL_MAP
  MultumReflection finest = multum_environment_lobe(vec4(multum_turned_mean(surface.finest.xyz), 1.0), v);
  sum.diffuse = mix(sum.diffuse, surface.finest_albedo * finest.diffuse, surface.finest.w);
  sum.specular = mix(sum.specular, finest.specular, surface.finest.w);
#endif
  sum.diffuse *= surface.weight;
  sum.specular *= surface.weight;
  return sum;
}
#endif
