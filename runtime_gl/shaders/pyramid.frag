// SPDX-License-Identifier: Apache-2.0
// Draws a surface that is coloured only from a pyramid.
//   MULTUM_BY_NORMAL   uses the coordinates of the normal in a reflectance map; otherwise those of the surface
//   MULTUM_LEVEL       uses the level of common/pyramid.glsl; MULTUM_FINEST: level 0; otherwise the driver's level
//   MULTUM_SHOW_LEVEL  shows the level itself, before clamping: red as chosen here, green as chosen by the driver
//   MULTUM_PHONG       no map: Blinn-Phong under distant lights for a distant viewer, the reference of reflectance maps
in vec3 v_position;
in vec3 v_normal;
in vec4 v_tangent;
in vec2 v_st;

uniform sampler2D u_map;
uniform vec3 u_frame[3];  // right, up, towards the viewer
uniform float u_level_bias;

#ifdef MULTUM_PHONG
#define MULTUM_PI 3.14159265358979
uniform int u_light_count;
uniform vec3 u_light_directions[8];  // unit
uniform vec3 u_light_irradiances[8];
uniform vec3 u_diffuse;
uniform vec3 u_specular;
uniform float u_exponent;
#endif

layout(location = 0) out vec4 o_colour;

void main() {
  vec3 n = normalize(v_normal);
#ifdef MULTUM_PHONG
  vec3 radiance = vec3(0.0);
  for (int i = 0; i < u_light_count; ++i) {
    vec3 l = u_light_directions[i];
    vec3 h = l + u_frame[2];
    h /= max(length(h), 1e-6);
    float facets = (u_exponent + 1.0) / (2.0 * MULTUM_PI) * pow(max(dot(n, h), 0.0), u_exponent);
    radiance += u_light_irradiances[i] * max(dot(n, l), 0.0) * (u_diffuse / MULTUM_PI + u_specular * facets);
  }
  o_colour = vec4(radiance, 1.0);
#else
#ifdef MULTUM_BY_NORMAL
  vec2 place = multum_reflectance_place(vec3(dot(n, u_frame[0]), dot(n, u_frame[1]), dot(n, u_frame[2])));
#else
  vec2 place = v_st;
#endif
  vec2 size = vec2(textureSize(u_map, 0));
  float level = multum_mip_level(dFdx(place) * size, dFdy(place) * size);
#if defined(MULTUM_SHOW_LEVEL)
  o_colour = vec4(level, textureQueryLod(u_map, place).y, 0.0, 1.0);
#elif defined(MULTUM_LEVEL)
  o_colour = vec4(textureLod(u_map, place, level + u_level_bias).rgb, 1.0);
#elif defined(MULTUM_FINEST)
  o_colour = vec4(textureLod(u_map, place, 0.0).rgb, 1.0);
#else
  o_colour = vec4(texture(u_map, place, u_level_bias).rgb, 1.0);
#endif
#endif
}
