// SPDX-License-Identifier: Apache-2.0
// Shades a mixture of MULTUM_LOBE_COUNT vMF lobes, which lobes.glsl fetches. With MULTUM_ROUGHNESS, the lobes include
// the BRDF's width. With MULTUM_PAPER, max(mu . l, 0) is used for diffuse and specular light, as in Han's Algorithm 2.

#ifdef MULTUM_EVALUATIONS
#define MULTUM_LOBES_ADD_UP

// Adds up all parts and stores the sum as the first part.
void multum_add_up(inout MultumSurface surface) {
  vec4 sum = vec4(0.0);
#ifdef MULTUM_COLOURS
  vec3 colours = vec3(0.0);
#endif
  for (int j = 0; j < MULTUM_PART_COUNT; ++j) {
    sum += surface.lobes[j];
#ifdef MULTUM_COLOURS
    colours += surface.lobes[j].w * surface.albedos[j];
#endif
  }
  surface.lobes[0] = sum;
#ifdef MULTUM_COLOURS
  surface.albedos[0] = colours / max(sum.w, MULTUM_AMPLITUDE_MIN);
#endif
}

// Adds up the most similar parts until multum_part_count remain.
void multum_add_up_alike(inout MultumSurface surface) {
#if MULTUM_PART_COUNT > 1
  for (int count = MULTUM_PART_COUNT; count > multum_part_count; --count) {
    ivec2 alike = multum_alike_parts(surface.lobes, count);
    vec4 one = surface.lobes[alike.x], other = surface.lobes[alike.y];
    surface.lobes[alike.x] = one + other;
    surface.lobes[alike.y] = surface.lobes[count - 1];
#ifdef MULTUM_COLOURS
    vec3 colours = one.w * surface.albedos[alike.x] + other.w * surface.albedos[alike.y];
    surface.albedos[alike.x] = colours / max(one.w + other.w, MULTUM_AMPLITUDE_MIN);
    surface.albedos[alike.y] = surface.albedos[count - 1];
#endif
  }
#endif
}

float multum_spread_of_all(MultumSurface surface) {
  multum_add_up(surface);
  return multum_movmf_spread(surface.lobes[0]);
}
#endif

#ifdef MULTUM_VISIBILITY
// Returns V, computed from the mean cosines over the lobe's normals that reflect from l to v. These normals are near h.
// The mean of the normals, which gives n.h, is between h and the lobe's mean. It is closer to h if the facets are
// sharper than the lobe.
float multum_lobe_visibility(vec4 lobe, vec3 l, vec3 v, vec3 h) {
  vec3 facets = multum_lobe_facets(lobe, h);
  float total = max(facets.x + facets.y + facets.z, 1e-20);
  float n_l = clamp(dot(multum_lobe_highlight(lobe, h, l), vec3(1.0)) / total, 0.0, 1.0);
  float n_v = clamp(dot(multum_lobe_highlight(lobe, h, v), vec3(1.0)) / total, 0.0, 1.0);
  vec3 n = multum_movmf_spread(lobe) * h + multum_movmf_mean_direction(lobe) / u_exponent;
  float size = length(n);
  float n_h = size > 1e-6 ? max(dot(n, h), 0.0) / size : 0.0;  // 0 where both are opposite and cancel each other
  return multum_visibility(n_l, n_v, n_h, dot(v, h));
}
#endif

MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h) {
  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));
  MULTUM_EACH_PART(j) {
    vec4 lobe = surface.lobes[j];
#ifdef MULTUM_PAPER
    float cosine = max(dot(multum_movmf_mean_direction(lobe), l), 0.0);
    sum.diffuse += MULTUM_TINTED(surface, j, vec3(lobe.w * cosine));
#elif defined(MULTUM_ROUGHNESS)
    vec4 of_normals = multum_movmf_without_roughness(lobe, u_mean_cosine);
    sum.diffuse += MULTUM_TINTED(surface, j, vec3(multum_movmf_lambert(of_normals, l)));
#else
    sum.diffuse += MULTUM_TINTED(surface, j, vec3(multum_movmf_lambert(lobe, l)));
#endif
#ifndef MULTUM_LAMBERT
#if defined(MULTUM_PAPER)
    vec3 specular = multum_lobe_facets(lobe, h) * cosine;
#elif defined(MULTUM_ROUGHNESS)
    float facet_kappa = multum_vmf_kappa(1.0 - u_mean_cosine);
    vec3 specular = multum_lobe_facets(lobe, h) * multum_movmf_highlight_cosine(of_normals, h, l, facet_kappa);
#else
    vec3 specular = multum_lobe_highlight(lobe, h, l);
#endif
#ifdef MULTUM_VISIBILITY
    specular *= multum_lobe_visibility(lobe, l, v, h);
#endif
    sum.specular += specular;
#endif
  }
  return sum;
}

#ifdef MULTUM_ENVIRONMENT
MultumReflection multum_reflect_environment(MultumSurface surface, vec3 v) {
  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));
  MULTUM_EACH_PART(j) {
    MultumReflection part = multum_environment_lobe(surface.lobes[j], v);
    sum.diffuse += MULTUM_TINTED(surface, j, part.diffuse);
    sum.specular += part.specular;
  }
  return sum;
}
#endif
