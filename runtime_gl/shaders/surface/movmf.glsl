// SPDX-License-Identifier: Apache-2.0
// A mixture of MULTUM_LOBE_COUNT vMF lobes, fetched by lobes.glsl. MULTUM_ROUGHNESS: the BRDF's width is in the lobes;
// MULTUM_PAPER: max(mu . l, 0) of Han's Algorithm 2 for diffuse and specular alike.

#ifdef MULTUM_VISIBILITY
// The normals that reflect towards v are those of the lobe that are near h: their mean lies between the two, nearer to
// what is sharper, and is where n.h is taken.
float multum_lobe_visibility(vec4 lobe, float n_l, vec3 v, vec3 h) {
  float n_v = multum_movmf_lambert(lobe, v) / max(lobe.w, MULTUM_AMPLITUDE_MIN);
  vec3 n = multum_movmf_spread(lobe) * h + multum_movmf_mean_direction(lobe) / u_exponent;
  float size = length(n);
  float n_h = size > 1e-6 ? max(dot(n, h), 0.0) / size : 0.0;  // where the two point apart and cancel, none
  return multum_visibility(n_l, n_v, n_h, dot(v, h));
}
#endif

MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h) {
  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));
  MULTUM_EACH_PART(j) {
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
    sum.diffuse += MULTUM_TINTED(surface, j, vec3(diffuse));
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
  MULTUM_EACH_PART(j) {
    MultumReflection part = multum_environment_lobe(surface.lobes[j], v);
    sum.diffuse += MULTUM_TINTED(surface, j, part.diffuse);
    sum.specular += part.specular;
  }
  return sum;
}
#endif
