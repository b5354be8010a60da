// SPDX-License-Identifier: Apache-2.0
// Computes a facet distribution as a sum of vMFs, f = sum w_i vMF(lambda_i), fitted by host/formats/brdf/vmf_terms.
// Each vMF is convolved with a lobe by multiplying the mean cosines. The product is A = |r| A(lambda_i), so 1 - A = d +
// (1 - d) q_i, d = 1 - |r|, q_i = 1 - A(lambda_i).

// Returns one term of f convolved with a lobe of amplitude 1 and spread d, where e = 1 - mu.h.
float multum_term(float d, float term_spread, float e) {
  return multum_vmf_density(multum_vmf_kappa(d + (1.0 - d) * term_spread), e);
}

#ifdef MULTUM_TERM_COUNT
uniform vec3 u_term_weights[MULTUM_TERM_COUNT];
uniform float u_term_spreads[MULTUM_TERM_COUNT];  // q_i

vec3 multum_lobe_facets(vec4 lobe, vec3 h) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return vec3(0.0);
  float d = multum_movmf_spread(lobe);
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < MULTUM_TERM_COUNT; ++i) sum += u_term_weights[i] * multum_term(d, u_term_spreads[i], e);
  return lobe.w * max(sum, 0.0);
}

// Each term has its own cosine.
vec3 multum_lobe_highlight(vec4 lobe, vec3 h, vec3 l) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return vec3(0.0);
  float d = multum_movmf_spread(lobe);
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < MULTUM_TERM_COUNT; ++i)
    sum += u_term_weights[i] * multum_term(d, u_term_spreads[i], e) *
           multum_movmf_highlight_cosine(lobe, h, l, multum_vmf_kappa(u_term_spreads[i]));
  return lobe.w * max(sum, 0.0);
}
#endif
