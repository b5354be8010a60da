// SPDX-License-Identifier: Apache-2.0
// Directional lights on a normal-mapped surface, in one of five ways of reading the map (exactly one is defined):
//   MULTUM_MOVMF    lobes of the baked file, trilinear      MULTUM_TRUTH    the finest map's nearest texel
//   MULTUM_MIP      averaged normal, normalised             MULTUM_TOKSVIG  |averaged normal| -> gloss (Toksvig 2004)
//   MULTUM_LEAN     slope moments (Olano and Baker 2010): density of slopes; MULTUM_JACOBIAN: / cos^3, normalised
// and MULTUM_LOBE_COUNT, MULTUM_COLOURS (lobes or texels carry colour), MULTUM_PAPER (Han's eq. 20),
// MULTUM_TORRANCE_SPARROW, MULTUM_NORMAL_MAP (levels finer than those of the lobes come from the normal map),
// MULTUM_ALBEDO_MAP (their colours from the albedo map). MIP, TOKSVIG and LEAN read a baked file of moments, or mips of
// the finest map, which are the same. All vectors are taken to tangent space, where the map's normals live.
//
// Outgoing radiance: sum over lights E ( albedo k_d / pi max(n.l, 0) + k_s f(n.h) max(n.l, 0) ), averaged over n. TRUTH
// averages it over samples; the others put the average into their model: cosines per lobe, or of the averaged normal.
in vec3 v_position;
in vec3 v_normal;
in vec4 v_tangent;
in vec2 v_st;

#define MULTUM_LIGHT_COUNT_MAX 8
uniform vec3 u_eye;
uniform int u_light_count;
uniform vec3 u_light_directions[MULTUM_LIGHT_COUNT_MAX];  // unit, towards the light
uniform vec3 u_light_irradiances[MULTUM_LIGHT_COUNT_MAX];
uniform vec3 u_diffuse;    // k_d
uniform vec3 u_specular;   // k_s
uniform float u_exponent;  // s; 1 / (2 sigma^2) for Torrance-Sparrow
uniform float u_sigma;

#ifdef MULTUM_MOVMF
uniform sampler2D u_lobes[MULTUM_LOBE_COUNT];
#ifdef MULTUM_COLOURS
uniform sampler2D u_colours[MULTUM_LOBE_COUNT];
#endif
#ifdef MULTUM_NORMAL_MAP
uniform sampler2D u_normal_map;  // mean normals of the levels finer than those of the lobes; w = 1
#endif
#ifdef MULTUM_ALBEDO_MAP
uniform sampler2D u_albedo_map;
#endif
#else
uniform sampler2D u_normals;  // TRUTH: unit; others: averaged normal, w = E[b_s b_t] for LEAN
#ifdef MULTUM_NORMAL_MAP
uniform sampler2D u_normal_map;  // averaged normals of the levels finer than those
#ifdef MULTUM_ALBEDO_MAP
uniform sampler2D u_albedo_map;
#endif
#endif
#ifdef MULTUM_COLOURS
uniform sampler2D u_albedo;
#endif
#ifdef MULTUM_LEAN
uniform sampler2D u_slopes;  // E[b_s], E[b_t], E[b_s^2], E[b_t^2]
#endif
#endif

layout(location = 0) out vec4 o_colour;

// f(n . h) of one normal.
float facet_distribution(vec3 n, vec3 h) {
  float e = multum_one_minus_cosine(n, h);
#ifdef MULTUM_TORRANCE_SPARROW
  return multum_vmf_density(u_exponent, e);
#else
  return multum_blinn_phong(u_exponent, e);
#endif
}

#ifdef MULTUM_MOVMF

vec3 shade_lobe(vec4 lobe, vec3 albedo, vec3 l, vec3 h) {
#if defined(MULTUM_TORRANCE_SPARROW)
  float facets = multum_movmf_torrance_sparrow(lobe, h, u_sigma);
#elif defined(MULTUM_PAPER)
  float facets = multum_movmf_blinn_phong_paper(lobe, h, u_exponent);
#else
  float facets = multum_movmf_blinn_phong(lobe, h, u_exponent);
#endif
#ifdef MULTUM_PAPER
  // Algorithm 2 of the paper: max(mu . l, 0) for diffuse and specular alike.
  float cosine = max(dot(multum_movmf_mean_direction(lobe), l), 0.0);
  float diffuse = lobe.w * cosine;
#else
  float diffuse = multum_movmf_lambert(lobe, l);
  float cosine = diffuse / max(lobe.w, MULTUM_AMPLITUDE_MIN);
#endif
  return u_diffuse / MULTUM_PI * albedo * diffuse + u_specular * (facets * cosine);
}

vec3 shade(vec3 l, vec3 h) {
  vec3 radiance = vec3(0.0);
  float share = 1.0;  // of the stored lobes
  vec3 mean_colour = vec3(0.0);
#ifdef MULTUM_NORMAL_MAP
  vec4 normal = texture(u_normal_map, v_st);
  vec4 finest = multum_movmf_normal_map(normal.xyz, textureQueryLod(u_lobes[0], v_st).y);
  share -= finest.w;
  finest.w *= normal.w;  // beyond a black border there is no material
#endif
  for (int j = 0; j < MULTUM_LOBE_COUNT; ++j) {
    vec4 lobe = texture(u_lobes[j], v_st);
    vec3 albedo = vec3(1.0);
#ifdef MULTUM_COLOURS
    // Colours are premultiplied: T(a c) / T(a) is the lobe's colour.
    vec3 colour = texture(u_colours[j], v_st).rgb;
    albedo = colour / max(lobe.w, MULTUM_AMPLITUDE_MIN);
    mean_colour += colour;
#endif
    radiance += shade_lobe(share * lobe, albedo, l, h);
  }
#ifdef MULTUM_NORMAL_MAP
  vec3 albedo = vec3(1.0);
#if defined(MULTUM_ALBEDO_MAP)
  albedo = texture(u_albedo_map, v_st).rgb;
#elif defined(MULTUM_COLOURS)
  albedo = mean_colour;  // of the first stored level, the finest that is known
#endif
  radiance += shade_lobe(finest, albedo, l, h);
#endif
  return radiance;
}

#else

vec3 shade_normal(vec3 mean, vec3 albedo, float facets, float diffuse, vec3 l) {
  return u_diffuse / MULTUM_PI * albedo * diffuse + u_specular * (facets * max(dot(normalize(mean), l), 0.0));
}

vec3 shade_texel(vec3 l, vec3 h) {
  vec4 texel = texture(u_normals, v_st);
  float size = length(texel.xyz);
  // Beyond the border of a map that wraps black there is no material: 0, which no mean of normals above the surface is.
  if (size <= 1e-12) return vec3(0.0);
  vec3 albedo = vec3(1.0);
#ifdef MULTUM_COLOURS
  albedo = texture(u_albedo, v_st).rgb;
#endif
#if defined(MULTUM_TOKSVIG)
  float facets = multum_moments_toksvig(texel.xyz, h, u_exponent);
  float diffuse = max(dot(texel.xyz, l), 0.0);
#elif defined(MULTUM_LEAN)
#ifdef MULTUM_JACOBIAN
  bool with_jacobian = true;
#else
  bool with_jacobian = false;
#endif
  float facets = multum_moments_lean(texture(u_slopes, v_st), texel.w, h, u_exponent, with_jacobian);
  float diffuse = max(dot(texel.xyz, l), 0.0);
#else
  vec3 n = texel.xyz / size;
  float facets = facet_distribution(n, h);
  float diffuse = max(dot(n, l), 0.0);
#endif
  return shade_normal(texel.xyz, albedo, facets, diffuse, l);
}

vec3 shade(vec3 l, vec3 h) {
#ifdef MULTUM_NORMAL_MAP
  // Levels that the file leaves to the normal map have no moments of slopes: Toksvig's rule, shaded before it is mixed.
  vec3 mean = texture(u_normal_map, v_st).xyz;
  float share = multum_movmf_normal_map(mean, textureQueryLod(u_normals, v_st).y).w;
  vec3 albedo = vec3(1.0);
#if defined(MULTUM_ALBEDO_MAP)
  albedo = texture(u_albedo_map, v_st).rgb;
#elif defined(MULTUM_COLOURS)
  albedo = texture(u_albedo, v_st).rgb;  // of the first stored level, the finest that is known
#endif
  vec3 finest = vec3(0.0);
  if (length(mean) > 1e-12)
    finest = shade_normal(mean, albedo, multum_moments_toksvig(mean, h, u_exponent), max(dot(mean, l), 0.0), l);
  return mix(shade_texel(l, h), finest, share);
#else
  return shade_texel(l, h);
#endif
}

#endif

void main() {
  vec3 n = normalize(v_normal);
  vec3 t = normalize(v_tangent.xyz - n * dot(n, v_tangent.xyz));
  vec3 b = cross(n, t) * v_tangent.w;
  vec3 to_eye = normalize(u_eye - v_position);
  vec3 v = vec3(dot(to_eye, t), dot(to_eye, b), dot(to_eye, n));
  vec3 radiance = vec3(0.0);
  for (int i = 0; i < u_light_count; ++i) {
    vec3 direction = u_light_directions[i];
    vec3 l = vec3(dot(direction, t), dot(direction, b), dot(direction, n));
    radiance += u_light_irradiances[i] * shade(l, normalize(l + v));
  }
  o_colour = vec4(radiance, 1.0);
}
