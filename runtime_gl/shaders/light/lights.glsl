// SPDX-License-Identifier: Apache-2.0
// Defines the lights of a scene. Their numbers are MULTUM_DIRECTIONAL_LIGHTS and MULTUM_POINT_LIGHTS.
#ifdef MULTUM_COLOURED_PLACES
vec3 multum_diffuse;  // k_d at the shaded place; main() sets it before shading
#else
uniform vec3 u_diffuse;  // k_d
#define multum_diffuse u_diffuse
#endif
uniform vec3 u_specular;  // k_s
#ifdef MULTUM_DIRECTIONAL_LIGHTS
uniform vec3 u_light_directions[MULTUM_DIRECTIONAL_LIGHTS];  // unit, towards the light
uniform vec3 u_light_irradiances[MULTUM_DIRECTIONAL_LIGHTS];
#endif
#ifdef MULTUM_POINT_LIGHTS
uniform vec3 u_point_positions[MULTUM_POINT_LIGHTS];
uniform vec3 u_point_intensities[MULTUM_POINT_LIGHTS];  // irradiance at distance 1
#endif

vec3 multum_outgoing(MultumReflection reflection) {
  vec3 radiance = multum_diffuse / MULTUM_PI * reflection.diffuse;
#ifndef MULTUM_LAMBERT
  radiance += u_specular * reflection.specular;
#endif
  return radiance;
}

// Returns the radiance for irradiance 1 on a surface that faces l.
vec3 multum_radiance(MultumSurface surface, vec3 l, vec3 v) {
  vec3 h = multum_half_vector(l, v);
  MultumReflection reflection = multum_reflect(surface, l, v, h);
#ifdef MULTUM_FRESNEL
  vec3 fresnel = multum_fresnel(max(dot(v, h), 0.0));
  reflection.specular *= fresnel;
#ifdef MULTUM_FRESNEL_DIFFUSE
  reflection.diffuse *= vec3(1.0) - fresnel;
#endif
#endif
  return multum_outgoing(reflection);
}

// `to_world` has the columns tangent, bitangent and normal. l in tangent space is l_world * to_world.
vec3 multum_lights(MultumSurface surface, mat3 to_world, vec3 position, vec3 v) {
  vec3 radiance = vec3(0.0);
#ifdef MULTUM_DIRECTIONAL_LIGHTS
  for (int i = 0; i < MULTUM_DIRECTIONAL_LIGHTS; ++i)
    radiance += u_light_irradiances[i] * multum_radiance(surface, u_light_directions[i] * to_world, v);
#endif
#ifdef MULTUM_POINT_LIGHTS
  for (int i = 0; i < MULTUM_POINT_LIGHTS; ++i) {
    vec3 to_light = u_point_positions[i] - position;
    float square = max(dot(to_light, to_light), 1e-12);
    radiance += u_point_intensities[i] / square *
                multum_radiance(surface, (to_light * inversesqrt(square)) * to_world, v);
  }
#endif
#ifdef MULTUM_ENVIRONMENT
  multum_set_environment_frame(to_world);
  radiance += multum_outgoing(multum_reflect_environment(surface, v));
#endif
  return radiance;
}
