// SPDX-License-Identifier: Apache-2.0
// Computes Torrance-Sparrow for one normal and convolved with a vMF lobe, as in Han et al. 2007, section 4 (after
// common/movmf_shading.glsl).

// Returns Torrance-Sparrow's facet distribution of roughness sigma (radians), convolved with the lobe. The distribution
// is replaced by a vMF with kappa_f = 1 / (2 sigma^2). Then 1 - A = d + (1 - d) q_f, q_f = 1 - A(kappa_f) = 1/kappa_f -
// 2/(exp(2 kappa_f) - 1). sigma must be at most 1 (kappa_f >= 1/2). The result is exact at |r| = 1. The relative L1
// error is at most 3.5 %, and is largest where lobe and BRDF are equally broad. The caller multiplies by Fresnel and
// shadowing.
float multum_movmf_torrance_sparrow(vec4 lobe, vec3 h, float sigma) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  float kappa_f = 0.5 / (sigma * sigma);
  float d = multum_movmf_spread(lobe);
  float q_f = multum_vmf_spread(kappa_f);
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  return lobe.w * multum_vmf_density(multum_vmf_kappa(d + (1.0 - d) * q_f), e);
}

#ifdef MULTUM_TORRANCE_SPARROW
uniform float u_sigma;

vec3 multum_facets(vec3 n, vec3 h) {
  return vec3(multum_vmf_density(0.5 / (u_sigma * u_sigma), multum_one_minus_cosine(n, h)));
}

vec3 multum_lobe_facets(vec4 lobe, vec3 h) { return vec3(multum_movmf_torrance_sparrow(lobe, h, u_sigma)); }

vec3 multum_lobe_highlight(vec4 lobe, vec3 h, vec3 l) {
  return multum_lobe_facets(lobe, h) * multum_movmf_highlight_cosine(lobe, h, l, 0.5 / (u_sigma * u_sigma));
}
#endif
