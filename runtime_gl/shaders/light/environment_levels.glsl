// SPDX-License-Identifier: Apache-2.0
// The highlight of a lobe under an environment by mips of the environment, each convolved with a vMF
// (host/formats/light/prefiltered_levels.h). A term of the facets convolved with the lobe has kappa =
// A^-1(|r| A(lambda)) around mu; its half vectors are taken as 3 x 3 narrower lobes, so that light that is compressed
// or stretched where it is seen at an angle, and what falls under the horizon, is followed. Each reflects to a
// direction of its own with dl = 4 (v.h) dh, and reads the two levels that are next to its spread, in the shares that
// give its mean cosine. How much light there is in all is the reflection table's. One lobe instead of nine: 9.3 %
// instead of 6.6 % off under blender_city (docs/contributing/ALGORITHMS.md, "Environments"); narrow ones stay one,
// where the levels
// have no room for parts.
#define MULTUM_LEVELS_MAX 12
#define MULTUM_PART_SHARE 0.4  // of the variance, that the parts keep; the rest lies between them
uniform float u_level_spreads[MULTUM_LEVELS_MAX];
uniform int u_level_count;
uniform float u_environment_spreads[MULTUM_ENVIRONMENT_TERMS];  // 1 - A(lambda) of each term

float multum_environment_level(float spread) {
  int k = 0;
  while (k < u_level_count - 2 && spread > u_level_spreads[k + 1]) ++k;
  float low = u_level_spreads[k];
  return float(k) + clamp((spread - low) / (u_level_spreads[k + 1] - low), 0.0, 1.0);
}

// The mean of the light over one term's half vectors; `along` and `across` the plane of v and mu.
vec3 multum_term_light(vec3 mu, float d, float q, vec3 v, vec3 along, vec3 across) {
  float variance = 1.0 / max(multum_vmf_kappa(d + (1.0 - d) * q), 0.1);  // of no direction: as wide as parts can be
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
    // The normals that reflect there lie between mu and h, nearer to what is sharper.
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
