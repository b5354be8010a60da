// SPDX-License-Identifier: Apache-2.0
// A mixture of MULTUM_LOBE_COUNT vMF lobes, trilinear. MULTUM_COLOURS: lobes have colours; MULTUM_NORMAL_MAP: levels
// finer than those of the lobes come from the normal map, as one more lobe; MULTUM_ALBEDO_MAP: with its own colours;
// MULTUM_ROUGHNESS: the BRDF's width is in the lobes; MULTUM_BASIS k: all is times weight k of the lobes;
// MULTUM_PAPER: max(mu . l, 0) of Han's Algorithm 2 for diffuse and specular alike.
uniform sampler2D u_lobes[MULTUM_LOBE_COUNT];
#ifdef MULTUM_COLOURS
uniform sampler2D u_colours[MULTUM_LOBE_COUNT];
#endif
#ifdef MULTUM_NORMAL_MAP
#define MULTUM_PART_COUNT (MULTUM_LOBE_COUNT + 1)
uniform sampler2D u_normal_map;  // mean normals of the levels finer than those of the lobes; w = 1
#else
#define MULTUM_PART_COUNT MULTUM_LOBE_COUNT
#endif
#ifdef MULTUM_ALBEDO_MAP
uniform sampler2D u_albedo_map;
#endif
#ifdef MULTUM_ROUGHNESS
uniform float u_mean_cosine;
#endif
#ifdef MULTUM_BASIS
uniform sampler2D u_weights[MULTUM_LOBE_COUNT];
#endif

struct MultumSurface {
  vec4 lobes[MULTUM_PART_COUNT];  // the normal map's last
  vec3 albedos[MULTUM_PART_COUNT];
};

MultumSurface multum_fetch_surface(vec2 st) {
  MultumSurface surface;
  float share = 1.0;  // of the stored lobes
#ifdef MULTUM_NORMAL_MAP
  vec4 normal = texture(u_normal_map, st);
  vec4 finest = multum_movmf_normal_map(normal.xyz, textureQueryLod(u_lobes[0], st).y);
  share -= finest.w;
  finest.w *= normal.w;  // beyond a black border there is no material
#endif
  vec3 mean_colour = vec3(0.0);
  float mean_weight = 0.0;
  for (int j = 0; j < MULTUM_LOBE_COUNT; ++j) {
    vec4 lobe = texture(u_lobes[j], st);
    surface.albedos[j] = vec3(1.0);
#ifdef MULTUM_COLOURS
    // Colours are premultiplied: T(a c) / T(a) is the lobe's colour.
    vec3 colour = texture(u_colours[j], st).rgb;
    surface.albedos[j] = colour / max(lobe.w, MULTUM_AMPLITUDE_MIN);
    mean_colour += colour;
#endif
#ifdef MULTUM_BASIS
    // Shading is linear in (a r, a): weights are amplitudes.
    float weight = texture(u_weights[j], st)[MULTUM_BASIS];
    mean_weight += weight;
    lobe *= weight / max(lobe.w, MULTUM_AMPLITUDE_MIN);
#endif
    surface.lobes[j] = share * lobe;
  }
#ifdef MULTUM_NORMAL_MAP
#ifdef MULTUM_BASIS
  finest *= mean_weight;  // of the first stored level
#endif
  surface.lobes[MULTUM_LOBE_COUNT] = finest;
#if defined(MULTUM_ALBEDO_MAP)
  surface.albedos[MULTUM_LOBE_COUNT] = texture(u_albedo_map, st).rgb;
#elif defined(MULTUM_COLOURS)
  surface.albedos[MULTUM_LOBE_COUNT] = mean_colour;  // of the first stored level, the finest that is known
#else
  surface.albedos[MULTUM_LOBE_COUNT] = vec3(1.0);
#endif
#endif
  return surface;
}

#ifdef MULTUM_VISIBILITY
// The normals that reflect towards v are those of the lobe that are near h: their mean lies between the two, nearer to
// what is sharper, and is where n.h is taken.
float multum_lobe_visibility(vec4 lobe, float n_l, vec3 v, vec3 h) {
  float n_v = multum_movmf_lambert(lobe, v) / max(lobe.w, MULTUM_AMPLITUDE_MIN);
  vec3 n = multum_movmf_spread(lobe) * h + multum_movmf_mean_direction(lobe) / u_exponent;
  return multum_visibility(n_l, n_v, max(dot(normalize(n), h), 0.0), dot(v, h));
}
#endif

MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h) {
  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));
  for (int j = 0; j < MULTUM_PART_COUNT; ++j) {
    vec4 lobe = surface.lobes[j];
#ifdef MULTUM_PAPER
    float cosine = max(dot(multum_movmf_mean_direction(lobe), l), 0.0);
    float diffuse = lobe.w * cosine;
#else
#ifdef MULTUM_ROUGHNESS
    float diffuse = multum_movmf_lambert(multum_movmf_without_roughness(lobe, u_mean_cosine), l);
#else
    float diffuse = multum_movmf_lambert(lobe, l);
#endif
    float cosine = diffuse / max(lobe.w, MULTUM_AMPLITUDE_MIN);
#endif
    sum.diffuse += surface.albedos[j] * diffuse;
#ifndef MULTUM_LAMBERT
    vec3 specular = multum_lobe_facets(lobe, h) * cosine;
#ifdef MULTUM_VISIBILITY
    specular *= multum_lobe_visibility(lobe, cosine, v, h);
#endif
    sum.specular += specular;
#endif
  }
  return sum;
}

#ifdef MULTUM_ENVIRONMENT
MultumReflection multum_reflect_environment(MultumSurface surface, vec3 v) {
  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));
  for (int j = 0; j < MULTUM_PART_COUNT; ++j) {
    MultumReflection part = multum_environment_lobe(surface.lobes[j], v);
    sum.diffuse += surface.albedos[j] * part.diffuse;
    sum.specular += part.specular;
  }
  return sum;
}
#endif
