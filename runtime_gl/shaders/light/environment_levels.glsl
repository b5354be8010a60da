// SPDX-License-Identifier: Apache-2.0
// Computes the highlight of a lobe under an environment from mips of the environment, each convolved with a vMF
// (host/formats/light/prefiltered_levels.h). A term of the facets convolved with the lobe has kappa = A^-1(|r|
// A(lambda)) around mu. The half vectors of a term are split into 3 x 3 narrower lobes. Such narrow parts can represent
// light that is compressed or stretched at grazing angles, and light that is cut off at the horizon. Each lobe reflects
// to its own direction with dl = 4 (v.h) dh. Each lobe reads the two levels next to its spread, mixed so that they give
// its mean cosine. The reflection table gives the total amount of light. Using one lobe instead of nine raises the
// error from 6.6 % to 9.3 % under blender_city (docs/contributing/ALGORITHMS.md, "Environments"). Narrow lobes are not
// split, because the levels cannot resolve the parts.
#define MULTUM_LEVELS_MAX 12
#define MULTUM_PART_SHARE 0.4  // share of the variance that each part keeps; the rest is between the parts
uniform float u_level_spreads[MULTUM_LEVELS_MAX];
uniform int u_level_count;
uniform float u_environment_spreads[MULTUM_ENVIRONMENT_TERMS];  // 1 - A(lambda) of each term

float multum_environment_level(float spread) {
  int k = 0;
  while (k < u_level_count - 2 && spread > u_level_spreads[k + 1]) ++k;
  float low = u_level_spreads[k];
  return float(k) + clamp((spread - low) / (u_level_spreads[k + 1] - low), 0.0, 1.0);
}

// Returns the mean of the light over one term's half vectors. `along` and `across` are the tangents at mu along which
// the parts are shifted.
vec3 multum_term_light(vec3 mu, float d, float q, vec3 v, vec3 along, vec3 across) {
  float variance = 1.0 / max(multum_vmf_kappa(d + (1.0 - d) * q), 0.1);  // a lobe without a direction has the widest
                                                                         // parts
  float share = clamp(0.5 * u_level_spreads[1] / variance, MULTUM_PART_SHARE, 1.0);
  float offset = sqrt(2.0 * (1.0 - share) * variance);  // weights 1/4, 1/2, 1/4 along each axis
  vec3 light = vec3(0.0);
  float total = 0.0;
  for (int k = 0; k < 9; ++k) {
    vec2 p = vec2(float(k % 3 - 1), float(k / 3 - 1));
    if (share == 1.0 && k != 4) continue;
    vec3 h = normalize(mu + offset * (p.x * along + p.y * across));
    float v_h = dot(v, h);
    if (v_h <= 0.0) continue;
    vec3 l = 2.0 * v_h * h - v;
    // The normals that reflect in this direction are between mu and h. They are closer to h if the facets are sharper
    // than the lobe.
    float n_l = max(dot(normalize(d * h + q * mu), l), 0.0);
    float weight = (2.0 - abs(p.x)) * (2.0 - abs(p.y)) * v_h * n_l;
    float level = multum_environment_level(min(4.0 * v_h * share * variance, 1.0));
    light += weight * textureLod(u_environment_map, multum_environment_st(multum_environment_frame * l), level).rgb;
    total += weight;
  }
  return light / max(total, 1e-6);
}

vec3 multum_environment_specular(vec3 mu, float d, vec3 v) {
  vec3 side = cross(v, mu);
  if (dot(side, side) < 1e-6) side = cross(mu, abs(mu.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0));
  vec3 across = normalize(side);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < MULTUM_ENVIRONMENT_TERMS; ++i)
    sum += multum_reflection_entry(i, dot(mu, v), d).rgb *
           multum_term_light(mu, d, u_environment_spreads[i], v, cross(mu, across), across);
  return max(sum, 0.0);
}
