// SPDX-License-Identifier: Apache-2.0
// The highlight of a lobe under an environment by mips of the environment, each convolved with a vMF
// (host/light/prefiltered_levels.h): a term of the facets on the lobe sees light from a lobe whose mean and spread the
// reflection table has, and reads the two levels that are next in spread, in the shares that give its mean cosine.
#define MULTUM_LEVELS_MAX 12
uniform sampler2D u_environment_map;
uniform float u_level_spreads[MULTUM_LEVELS_MAX];
uniform int u_level_count;

float multum_environment_level(float spread) {
  int k = 0;
  while (k < u_level_count - 2 && spread > u_level_spreads[k + 1]) ++k;
  float low = u_level_spreads[k];
  return float(k) + clamp((spread - low) / (u_level_spreads[k + 1] - low), 0.0, 1.0);
}

vec3 multum_environment_specular(vec3 mu, float d, vec3 v) {
  vec3 sum = vec3(0.0);
  for (int i = 0; i < MULTUM_ENVIRONMENT_TERMS; ++i) {
    vec4 weight = multum_reflection_entry(2 * i, dot(mu, v), d);
    vec4 lobe = multum_reflection_entry(2 * i + 1, dot(mu, v), d);
    vec3 l = normalize(multum_environment_frame * (lobe.x * mu + lobe.y * v));
    sum += weight.rgb * textureLod(u_environment_map, multum_environment_st(l), multum_environment_level(lobe.z)).rgb;
  }
  return sum;
}
