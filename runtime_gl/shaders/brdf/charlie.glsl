// SPDX-License-Identifier: Apache-2.0
// Computes Charlie, the sheen of cloth, for one normal and convolved with a vMF lobe (after movmf_shading.glsl).
// Charlie is from Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF". alpha is roughness^2, as in
// KHR_materials_sheen. D is largest for h at right angles to n, and 0 for h = n. A sharp D cannot be approximated by a
// sum of vMFs around h, but no such sum is needed.
//
// V is 1 / (4 (n.l + n.v - n.l n.v)) of Ashikhmin and Premoze 2007. KHR_materials_sheen allows this V instead of the V
// of Estevez and Kulla. Filament and three.js use it, so artists see the same result here as in their engine.

// Returns (1 + p) / pi (1 - t^2)^p = (2 + 1 / alpha) sin^(1 / alpha) / (2 pi), with p = 1 / (2 alpha), t = n.h,
// e = 1 - t.
float multum_charlie(float p, float e) {
  return e < 1.0 ? (1.0 + p) / MULTUM_PI * pow(max(e * (2.0 - e), 0.0), p) : 0.0;
}

// Returns V, which is bounded even if both cosines are 0.
float multum_sheen_visibility(float n_l, float n_v) { return 0.25 / max(n_l + n_v - n_l * n_v, 1e-6); }

// Returns the mean and variance of n.h over the lobe's normals, from t = mu.h and the lobe's kappa and spread d.
vec2 multum_lobe_projection(float d, float kappa, float t) {
  float r = 1.0 - d;
  float across = r > 1e-3 ? r / kappa : 1.0 / 3.0;
  float along = max(1.0 - r * r - 2.0 * across, 0.0);
  return vec2(r * t, mix(across, along, t * t));
}

// Returns Charlie convolved with the lobe at the unit half vector h, times the amplitude. Extended to both sides of the
// horizon, D is an even function of n.h, (1 - t^2)^p, whose second zonal coefficient is -p / (2 p + 3) times its
// integral. The convolution multiplies this coefficient by the coefficient of the lobe, which is 1 - w with w = 3 r /
// kappa. p' is the exponent for which the second coefficient equals this product. Only normals that face h count. n.h
// is approximately normally distributed over the lobe and D is about exp(-p (n.h)^2), so the share of these normals is
// Phi(x). The result is exact for a single normal and for uniform directions. In between, the relative L1 error over
// the hemisphere of h is largest at kappa 3, where it is at most 9 %. From kappa 40 on, it is at most 2 % (roughness
// 0.05 to 1, kappa 0.5 to 2000; tests/gl/charlie_test).
float multum_movmf_charlie(vec4 lobe, vec3 h, float p) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  float d = multum_movmf_spread(lobe), r = 1.0 - d;
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  float kappa = multum_vmf_kappa(d);
  float w = r > 0.1 ? min(3.0 * r / kappa, 1.0) : 1.0 - 0.6 * r * r;
  float wide = 3.0 * (1.0 - w) * p / (3.0 + 2.0 * p * w);
  vec2 n_h = multum_lobe_projection(d, kappa, 1.0 - e);
  float x = clamp(n_h.x * inversesqrt(max(n_h.y * (1.0 + 2.0 * p * n_h.y), 1e-12)), -8.0, 8.0);
  float share = 1.0 / (1.0 + exp(-x * (1.5976 + 0.07056 * x * x)));  // Phi, error at most 2e-4 (Page 1977)
  // The integral of (1 - t^2)^p is proportional to 1 / sqrt(p + pi / 4), to 0.6 %.
  float scale = (1.0 + p) / MULTUM_PI * sqrt((wide + 0.7854) / (p + 0.7854));
  return lobe.w * scale * pow(clamp(e * (2.0 - e), 1e-30, 1.0), wide) * share;
}

// Returns a value that replaces the facets' kappa in the highlight's cosine. The reflecting normals are far from h,
// because D is low near h. Near their mean n.h, a vMF of this negative kappa has the same effect as D.
float multum_movmf_charlie_facet_kappa(vec4 lobe, vec3 h, float p) {
  float d = multum_movmf_spread(lobe);
  float t = 1.0 - multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  vec2 n_h = multum_lobe_projection(d, multum_vmf_kappa(d), t);
  return -2.0 * p * n_h.x / (1.0 + 2.0 * p * n_h.y);
}

#ifdef MULTUM_CHARLIE
uniform float u_alpha;

vec3 multum_facets(vec3 n, vec3 h) { return vec3(multum_charlie(0.5 / u_alpha, multum_one_minus_cosine(n, h))); }

vec3 multum_lobe_facets(vec4 lobe, vec3 h) { return vec3(multum_movmf_charlie(lobe, h, 0.5 / u_alpha)); }

vec3 multum_lobe_highlight(vec4 lobe, vec3 h, vec3 l) {
  float facet_kappa = multum_movmf_charlie_facet_kappa(lobe, h, 0.5 / u_alpha);
  return multum_lobe_facets(lobe, h) * multum_movmf_highlight_cosine(lobe, h, l, facet_kappa);
}

float multum_visibility(float n_l, float n_v, float n_h, float v_h) { return multum_sheen_visibility(n_l, n_v); }
#endif
