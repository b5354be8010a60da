// SPDX-License-Identifier: Apache-2.0
// Computes the light of an environment on a lobe of normals (a r, a). Diffuse light uses the environment's harmonics up
// to l = 2 (Ramamoorthi and Hanrahan 2001; Han et al. 2007, eq. 25). The highlight is in environment_sh.glsl or
// environment_levels.glsl. One texture holds all reflection tables (host/formats/light/reflection_table.h). It has one
// plane per term, with (weight, plain) of each entry, and then one plane for the Fresnel part.
#define MULTUM_TABLE_COSINES 32.0
#define MULTUM_TABLE_SPREADS 24.0
uniform vec3 u_smooth_mean;               // L(n) = mean + linear . n + n . quadratic n
uniform vec3 u_smooth_linear[3];          // one vector per channel
uniform vec3 u_smooth_quadratic[9];       // three rows per channel
uniform sampler2D u_reflection_table;

// Returns the integral of L(l) E[max(n.l, 0)] over normals whose harmonics of order 1 and 2 are those of mu times a1
// and a2.
vec3 multum_irradiance(vec3 mu, float a1, float a2) {
  vec3 m = multum_environment_frame * mu;
  vec3 linear = vec3(dot(u_smooth_linear[0], m), dot(u_smooth_linear[1], m), dot(u_smooth_linear[2], m));
  vec3 quadratic;
  for (int c = 0; c < 3; ++c)
    quadratic[c] = dot(m, vec3(dot(u_smooth_quadratic[3 * c], m), dot(u_smooth_quadratic[3 * c + 1], m),
                               dot(u_smooth_quadratic[3 * c + 2], m)));
  return max(MULTUM_PI * (u_smooth_mean + 2.0 / 3.0 * a1 * linear + 0.25 * a2 * quadratic), vec3(0.0));
}

// Interpolates between texel centres, within the entry's plane.
vec4 multum_reflection_entry(int plane, float cosine, float spread) {
  float x = 0.5 + (0.5 + 0.5 * cosine) * (MULTUM_TABLE_COSINES - 1.0);
  float y = 0.5 + pow(spread, 1.0 / 3.0) * (MULTUM_TABLE_SPREADS - 1.0) + float(plane) * MULTUM_TABLE_SPREADS;
  return textureLod(u_reflection_table, vec2(x, y) / vec2(textureSize(u_reflection_table, 0)), 0.0);
}

vec3 multum_environment_specular(vec3 mu, float d, vec3 v);

MultumReflection multum_environment_lobe(vec4 lobe, vec3 v) {
  MultumReflection reflection = MultumReflection(vec3(0.0), vec3(0.0));
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return reflection;
  float d = multum_movmf_spread(lobe);
  vec3 mu = multum_movmf_mean_direction(lobe);
  float smooth_d = d;
#ifdef MULTUM_ROUGHNESS
  smooth_d = multum_movmf_spread(multum_movmf_without_roughness(lobe, u_mean_cosine));
#endif
  reflection.diffuse =
      lobe.w *
      multum_irradiance(mu, 1.0 - smooth_d, multum_vmf_second_zonal(1.0 - smooth_d, multum_vmf_kappa(smooth_d)));
#ifdef MULTUM_FRESNEL_DIFFUSE
  float fresnel = multum_reflection_entry(MULTUM_ENVIRONMENT_TERMS, dot(mu, v), d).x;
  reflection.diffuse *= (vec3(1.0) - u_f0) * (1.0 - fresnel);
#endif
#ifndef MULTUM_LAMBERT
  reflection.specular = lobe.w * multum_environment_specular(mu, d, v);
#endif
  return reflection;
}
