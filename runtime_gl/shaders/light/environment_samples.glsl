// SPDX-License-Identifier: Apache-2.0
// Computes the light of an environment on one normal by brute force. Takes u_light_sample_count directions where the
// environment is bright (host/formats/light/light_samples.h) and as many cosine-weighted ones for the diffuse part.
// For the highlight it takes as many half vectors of a GGX that is as wide as the facets, because GGX has the longest
// tail of all facet distributions here. If two of these densities could have produced a direction, its weight uses the
// sum of both densities (Veach and Guibas 1995, the balance heuristic). Uses a low-discrepancy sequence, shifted by a
// hash of the pixel. `u_sample` counts pictures. The map is constant over a texel.
uniform vec3 u_light_samples[MULTUM_ENVIRONMENT_SAMPLES];  // directions in the environment's frame
uniform int u_light_sample_count;                          // at most MULTUM_ENVIRONMENT_SAMPLES
uniform float u_light_total;                               // the integral of the luminance

vec3 multum_environment_radiance(vec3 l) {
  vec2 st = multum_environment_st(multum_environment_frame * l);
  ivec2 size = textureSize(u_environment_map, 0);
  return texelFetch(u_environment_map, clamp(ivec2(st * vec2(size)), ivec2(0), size - 1), 0).rgb;
}

float multum_light_density(vec3 radiance) { return dot(radiance, vec3(1.0 / 3.0)) / u_light_total; }

uint multum_light_hash(uint x) {  // Wellons' lowbias32
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

vec3 multum_direction(mat3 frame, float cosine, float phi) {
  float sine = sqrt(max(1.0 - cosine * cosine, 0.0));
  return frame * vec3(sine * cos(phi), sine * sin(phi), cosine);
}

// These functions return the densities of a cosine-weighted direction and of a direction found by a half vector of GGX.
// `alpha` is the roughness squared.
float multum_cosine_density(float n_l) { return n_l / MULTUM_PI; }

float multum_half_density(float alpha, float n_h, float v_h) {
  if (n_h <= 0.0) return 0.0;
  float y = 1.0 + (alpha - 1.0) * n_h * n_h;
  return alpha * n_h / (MULTUM_PI * y * y) / (4.0 * max(v_h, 1e-6));
}

// These functions return the integrands of the irradiance (without the diffuse factor) and of the highlight.
vec3 multum_diffuse_integrand(vec3 radiance, float n_l, float v_h) {
  vec3 value = radiance * n_l;
#ifdef MULTUM_FRESNEL_DIFFUSE
  value *= vec3(1.0) - multum_fresnel(v_h);
#endif
  return value;
}

#ifndef MULTUM_LAMBERT
vec3 multum_specular_integrand(vec3 radiance, vec3 n, float n_l, vec3 v, vec3 h) {
  vec3 value = multum_facets(n, h) * radiance * n_l;
#ifdef MULTUM_VISIBILITY
  value *= multum_visibility(n_l, max(dot(n, v), 0.0), max(dot(n, h), 0.0), dot(v, h));
#endif
#ifdef MULTUM_FRESNEL
  value *= multum_fresnel(dot(v, h));
#endif
  return value;
}
#endif

// With `kind` 0, adds to both parts. With 1, adds to the diffuse part, and with 2, to the highlight.
void multum_add_direction(int kind, vec3 l, vec3 n, vec3 v, float alpha, inout MultumReflection sum) {
  float n_l = dot(n, l);
  if (n_l <= 0.0) return;
  vec3 h = multum_half_vector(l, v);
  vec3 radiance = multum_environment_radiance(l);
  float light = multum_light_density(radiance);
  if (kind != 2)
    sum.diffuse += multum_diffuse_integrand(radiance, n_l, dot(v, h)) / (light + multum_cosine_density(n_l));
#ifndef MULTUM_LAMBERT
  if (kind != 1)
    sum.specular += multum_specular_integrand(radiance, n, n_l, v, h) /
                    max(light + multum_half_density(alpha, dot(n, h), dot(v, h)), 1e-20);
#endif
}

MultumReflection multum_environment_normal(vec3 n, vec3 v) {
  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));
  uvec2 pixel = uvec2(gl_FragCoord.xy);
  uint seed = multum_light_hash(pixel.x + multum_light_hash(pixel.y));
  uvec2 shift = uvec2(seed, multum_light_hash(seed + 1u));
  vec3 side = normalize(abs(n.z) < 0.9 ? cross(n, vec3(0.0, 0.0, 1.0)) : cross(n, vec3(1.0, 0.0, 0.0)));
  mat3 frame = mat3(side, cross(n, side), n);
  float alpha = 2.0 / (u_exponent + 2.0);
  for (int i = 0; i < u_light_sample_count; ++i) {
    // The multiples of 1/g and 1/g^2, g^3 = g + 1, modulo 1, are computed with integers, so that no precision is lost
    // for large sample counts.
    uint index = uint(u_sample * u_light_sample_count + i);
    vec2 u = vec2(shift + index * uvec2(3242174889u, 2447445414u)) * (1.0 / 4294967296.0);
    float phi = 2.0 * MULTUM_PI * u.y;
    multum_add_direction(0, u_light_samples[i] * multum_environment_frame, n, v, alpha, sum);
    multum_add_direction(1, multum_direction(frame, sqrt(max(1.0 - u.x, 0.0)), phi), n, v, alpha, sum);
#ifndef MULTUM_LAMBERT
    vec3 h = multum_direction(frame, sqrt((1.0 - u.x) / (1.0 + (alpha - 1.0) * u.x)), phi);
    if (dot(v, h) > 0.0) multum_add_direction(2, 2.0 * dot(v, h) * h - v, n, v, alpha, sum);
#endif
  }
  sum.diffuse /= float(u_light_sample_count);
  sum.specular /= float(u_light_sample_count);
  return sum;
}
