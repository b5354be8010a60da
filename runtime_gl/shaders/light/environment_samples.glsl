// SPDX-License-Identifier: Apache-2.0
// Light from everywhere on one normal by brute force: MULTUM_ENVIRONMENT_SAMPLES directions of the environment's
// texels, cosine-weighted for the diffuse part, and half vectors of a GGX as wide as the facets, whose tail no density
// here exceeds, for the highlight. A low-discrepancy sequence, shifted by a hash of the pixel; `u_sample` counts
// pictures.
uniform vec3 u_environment_axes[3];
uniform sampler2D u_environment_map;
uniform int u_sample;

mat3 multum_environment_frame;

void multum_set_environment_frame(mat3 to_world) {
  multum_environment_frame =
      transpose(mat3(u_environment_axes[0], u_environment_axes[1], u_environment_axes[2])) * to_world;
}

vec3 multum_environment_radiance(vec3 l) {
  vec3 d = multum_environment_frame * l;
  vec2 st = vec2(0.5 + atan(d.x, -d.z) / (2.0 * MULTUM_PI), acos(clamp(d.y, -1.0, 1.0)) / MULTUM_PI);
  return textureLod(u_environment_map, st, 0.0).rgb;
}

uint multum_hash(uint x) {  // Wellons' lowbias32
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

vec3 multum_direction(mat3 frame, float cosine, float phi) {
  float sine = sqrt(max(1.0 - cosine * cosine, 0.0));
  return frame * vec3(sine * cos(phi), sine * sin(phi), cosine);
}

MultumReflection multum_environment_normal(vec3 n, vec3 v) {
  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));
  uvec2 pixel = uvec2(gl_FragCoord.xy);
  uint seed = multum_hash(pixel.x + multum_hash(pixel.y));
  uvec2 shift = uvec2(seed, multum_hash(seed + 1u));
  vec3 side = normalize(abs(n.z) < 0.9 ? cross(n, vec3(0.0, 0.0, 1.0)) : cross(n, vec3(1.0, 0.0, 0.0)));
  mat3 frame = mat3(side, cross(n, side), n);
  float alpha = 2.0 / (u_exponent + 2.0);  // squared
  for (int i = 0; i < MULTUM_ENVIRONMENT_SAMPLES; ++i) {
    // Multiples of 1/g and 1/g^2, g^3 = g + 1, modulo 1 in whole numbers: nothing is lost however many there are.
    uint index = uint(u_sample * MULTUM_ENVIRONMENT_SAMPLES + i);
    vec2 u = vec2(shift + index * uvec2(3242174889u, 2447445414u)) * (1.0 / 4294967296.0);
    float phi = 2.0 * MULTUM_PI * u.y;
    vec3 l = multum_direction(frame, sqrt(max(1.0 - u.x, 0.0)), phi);
    vec3 diffuse = MULTUM_PI * multum_environment_radiance(l);
#ifdef MULTUM_FRESNEL_DIFFUSE
    diffuse *= vec3(1.0) - multum_fresnel(max(dot(v, normalize(l + v)), 0.0));
#endif
    sum.diffuse += diffuse;
#ifndef MULTUM_LAMBERT
    float square = (1.0 - u.x) / (1.0 + (alpha - 1.0) * u.x);  // cosine^2 of n and h
    vec3 h = multum_direction(frame, sqrt(square), phi);
    float v_h = dot(v, h);
    l = 2.0 * v_h * h - v;
    float n_l = dot(n, l);
    if (v_h <= 0.0 || n_l <= 0.0) continue;
    float y = 1.0 + (alpha - 1.0) * square;
    float density = alpha * sqrt(square) / (MULTUM_PI * y * y);
    vec3 specular = multum_facets(n, h) * (4.0 * v_h * n_l / max(density, 1e-20));
#ifdef MULTUM_VISIBILITY
    specular *= multum_visibility(n_l, max(dot(n, v), 0.0), max(dot(n, h), 0.0), v_h);
#endif
#ifdef MULTUM_FRESNEL
    specular *= multum_fresnel(v_h);
#endif
    sum.specular += specular * multum_environment_radiance(l);
#endif
  }
  sum.diffuse /= float(MULTUM_ENVIRONMENT_SAMPLES);
  sum.specular /= float(MULTUM_ENVIRONMENT_SAMPLES);
  return sum;
}
