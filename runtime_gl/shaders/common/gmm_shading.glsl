// SPDX-License-Identifier: Apache-2.0
// Shades one filtered planar Gaussian (Tan et al. 2005, section 3). Follows movmf_shading.glsl, whose constants it
// uses. For each lobe, a texel holds (a mu_x, a mu_y, a (2 sigma^2 + |mu|^2), a), with amplitude a, mean mu of (n_x,
// n_y), and variance sigma^2 of one coordinate. All four values are linear in the normals, so let the hardware filter
// them.
//
// In this model, facets also scatter as a Gaussian over (n_x, n_y), so the variances are added.
// kernels/device/gmm_shading.clh has the same formulas. tests/agreement compares both with double precision.

const float MULTUM_GMM_VARIANCE_MIN = 1e-7;  // rounding error of sigma^2, which comes from floats near 1

vec2 multum_gmm_mean(vec4 lobe) { return lobe.xy / max(lobe.w, MULTUM_AMPLITUDE_MIN); }

// Returns the point of the sphere above a point of the plane.
vec3 multum_gmm_lifted(vec2 p) { return vec3(p, sqrt(max(1.0 - dot(p, p), 0.0))); }

// Returns sigma^2 of the filtered lobe, which is never negative. The value of 2 sigma^2 is T(a (2 sigma^2 + |mu|^2)) /
// T(a) - |T(a mu) / T(a)|^2, where T is the texture filter.
float multum_gmm_variance(vec4 lobe) {
  vec2 mean = multum_gmm_mean(lobe);
  return max(0.5 * (lobe.z - dot(mean, lobe.xy)) / max(lobe.w, MULTUM_AMPLITUDE_MIN), 0.0);
}

// Returns sigma^2, about the lobe's mean, of facets with the distribution of normalised Blinn-Phong with exponent s.
// The value is 1/(s + 3) about an upright normal. About a tilted normal, facets are foreshortened in one of two
// directions.
float multum_gmm_facet_variance(vec4 lobe, float s) {
  vec2 mean = multum_gmm_mean(lobe);
  return (1.0 - 0.5 * min(dot(mean, mean), 1.0)) / (s + 3.0);
}

// Returns the facets' density D(h) = G(h_x, h_y) h_z per solid angle at the unit vector h, convolved with the lobe,
// times the amplitude.
float multum_gmm_density(vec4 lobe, vec3 h, float s) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  vec2 d = h.xy - multum_gmm_mean(lobe);
  float variance = max(multum_gmm_variance(lobe) + multum_gmm_facet_variance(lobe, s), MULTUM_GMM_VARIANCE_MIN);
  return lobe.w / (2.0 * MULTUM_PI * variance) * exp(-0.5 * dot(d, d) / variance) * max(h.z, 0.0);
}

// Returns Tan's Lambert term max(mu . l, 0), times the amplitude. mu is the point of the sphere above the mean.
float multum_gmm_lambert(vec4 lobe, vec3 l) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  return lobe.w * max(dot(multum_gmm_lifted(multum_gmm_mean(lobe)), l), 0.0);
}

// Returns the Gaussian of a mean normal (a n, a), for levels that a file leaves to the normal map.
// E[x^2 + y^2] = 1 - E[z^2] is approximated by 1 minus the square of the mean.
vec4 multum_gmm_normal_map(vec4 mean) {
  return vec4(mean.xy, mean.w - mean.z * mean.z / max(mean.w, MULTUM_AMPLITUDE_MIN), mean.w);
}
