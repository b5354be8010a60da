// SPDX-License-Identifier: Apache-2.0
// The lights of a scene. MULTUM_DIRECTIONAL_LIGHTS N: the number of distant lights.
uniform vec3 u_diffuse;   // k_d
uniform vec3 u_specular;  // k_s
#ifdef MULTUM_DIRECTIONAL_LIGHTS
uniform vec3 u_light_directions[MULTUM_DIRECTIONAL_LIGHTS];  // unit, towards the light
uniform vec3 u_light_irradiances[MULTUM_DIRECTIONAL_LIGHTS];
#endif

// For irradiance 1 of a surface that faces l.
vec3 multum_radiance(MultumSurface surface, vec3 l, vec3 v) {
  vec3 h = normalize(l + v);
  MultumReflection reflection = multum_reflect(surface, l, v, h);
#ifdef MULTUM_FRESNEL
  vec3 fresnel = multum_fresnel(max(dot(v, h), 0.0));
  reflection.diffuse *= vec3(1.0) - fresnel;
  reflection.specular *= fresnel;
#endif
  return u_diffuse / MULTUM_PI * reflection.diffuse + u_specular * reflection.specular;
}

// `to_world`: tangent, bitangent, normal; l of the tangent space is l_world * to_world.
vec3 multum_lights(MultumSurface surface, mat3 to_world, vec3 v) {
  vec3 radiance = vec3(0.0);
#ifdef MULTUM_DIRECTIONAL_LIGHTS
  for (int i = 0; i < MULTUM_DIRECTIONAL_LIGHTS; ++i)
    radiance += u_light_irradiances[i] * multum_radiance(surface, u_light_directions[i] * to_world, v);
#endif
  return radiance;
}
