// SPDX-License-Identifier: Apache-2.0
// Computes Blinn-Phong for one normal and convolved with a vMF lobe (after common/movmf_shading.glsl).
//
// Departures from the paper. The paper's rule s' = kappa s / (kappa + s) (eq. 20) is kept as
// multum_movmf_blinn_phong_paper(). The relative L1 error of this rule over the hemisphere is 3 % at kappa 50, 22 % at
// 5, and 54-70 % at kappa <= 1. The rule here uses an exact property of spherical convolution. The convolved lobe has
// the mean cosine A = |r| c_f, where c_f is the mean cosine of f. Two shapes that have this mean cosine are blended
// with one weight. A vMF is accurate for broad lobes. A cosine power is accurate for lobes sharper than f, and exact at
// |r| = 1. The errors were measured by quadrature (tools/lab/fit_shading.py; tests/agreement, ShadingBounds). They are
// at most 7 % for s >= 1, 4 % for s >= 2, 2.8 % for s >= 3, 1.8 % for s >= 5, 0.85 % for s >= 20 and 0.27 % for s >=
// 100, for every kappa. The error is largest for kappa from 2 to 5.

// The constant in the fitted weight of the cosine-power shape, which is w = r^2 / (r^2 + MULTUM_SHAPE_BLEND (1 - |r|) /
// (1 - c_f)).
const float MULTUM_SHAPE_BLEND = 1.4;

// Returns log(1 - e) to full relative precision. If t is close to 1, its rounding gives log(t) an error of 6e-8, which
// an exponent s of 1e5 would multiply. The formula is log(1 - e) = -2 atanh(y), y = e / (2 - e) = -2 (y + y^3/3 + y^5/5
// + ...). At e = 0.1 the omitted terms are 3e-9.
float multum_log_one_minus(float e) {
  if (e > 0.1) return log(max(1.0 - e, 1e-30));
  float y = e / (2.0 - e);
  float y2 = y * y;
  return -2.0 * y * (1.0 + y2 * (1.0 / 3.0 + y2 * 0.2));
}

// Returns normalised Blinn-Phong (s + 1) / (2 pi) max(t, 0)^s, e = 1 - t, which is the facet distribution about one
// direction.
float multum_blinn_phong(float s, float e) {
  return e < 1.0 ? (s + 1.0) / (2.0 * MULTUM_PI) * exp(s * multum_log_one_minus(e)) : 0.0;
}

// Returns Blinn-Phong with exponent s, convolved with the lobe, at the unit half vector h.
//   c_f = (s + 1) / (s + 2);   1 - A = d + (1 - d) / (s + 2), d = 1 - |r|: a sum of small numbers without cancellation
//   vMF shape:           kappa = A^-1(A)
//   cosine-power shape:  s' = (2 A - 1) / (1 - A), for which (s' + 1) / (s' + 2) = A; for A < 1/2 there is none, and s'
//   = 0
float multum_movmf_blinn_phong(vec4 lobe, vec3 h, float s) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  float d = multum_movmf_spread(lobe);
  float r = 1.0 - d;
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  float q = d + r / (s + 2.0);
  float power = max((1.0 - 2.0 * q) / q, 0.0);
  float weight = r * r / (r * r + MULTUM_SHAPE_BLEND * d * (s + 2.0));
  return lobe.w * mix(multum_vmf_density(multum_vmf_kappa(q), e), multum_blinn_phong(power, e), weight);
}

// Returns the result of the paper's rule s' = kappa s / (kappa + s), kappa = A^-1(|r|) (Han et al. 2007, eq. 20).
float multum_movmf_blinn_phong_paper(vec4 lobe, vec3 h, float s) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  float kappa = multum_vmf_kappa(multum_movmf_spread(lobe));
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  return lobe.w * multum_blinn_phong(kappa * s / (kappa + s), e);
}

#ifdef MULTUM_BLINN_PHONG
vec3 multum_facets(vec3 n, vec3 h) { return vec3(multum_blinn_phong(u_exponent, multum_one_minus_cosine(n, h))); }

vec3 multum_lobe_facets(vec4 lobe, vec3 h) {
#ifdef MULTUM_PAPER
  return vec3(multum_movmf_blinn_phong_paper(lobe, h, u_exponent));
#else
  return vec3(multum_movmf_blinn_phong(lobe, h, u_exponent));
#endif
}

vec3 multum_lobe_highlight(vec4 lobe, vec3 h, vec3 l) {
  float facet_kappa = multum_vmf_kappa(1.0 / (u_exponent + 2.0));
  return multum_lobe_facets(lobe, h) * multum_movmf_highlight_cosine(lobe, h, l, facet_kappa);
}
#endif
