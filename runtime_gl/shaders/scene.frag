// SPDX-License-Identifier: Apache-2.0
// The light that a normal-mapped surface sends to the eye: its normals by one of surface/, its BRDF by one of brdf/,
// its lights by light/ (common/reflection.glsl says how they meet). All vectors are taken to tangent space, where the
// map's normals live.
//
// Outgoing radiance: the sum over lights of that BRDF times max(n.l, 0), averaged over n. MULTUM_REFERENCE averages it
// over samples; the others put the average into their model: cosines per lobe, or of the averaged normal.
// MULTUM_SHADE_TAPS: each tap of the texture's filter is shaded by itself, and what comes of them averaged.
in vec3 v_position;
in vec3 v_normal;
in vec4 v_tangent;
in vec2 v_st;

uniform vec3 u_eye;

layout(location = 0) out vec4 o_colour;

void main() {
  mat3 to_world = multum_tangent_frame(v_normal, v_tangent);
  vec3 v = normalize(u_eye - v_position) * to_world;
  MultumFootprint footprint = multum_surface_footprint(v_st);
#ifdef MULTUM_ROUGHNESS_TEXTURE
  MultumFootprint of_roughness = multum_roughness_footprint(v_st);
  multum_take_roughness(v_st, of_roughness);
#endif
#ifdef MULTUM_SHADE_TAPS
  MultumFootprint one = MultumFootprint(vec2(0.0), 1, footprint.level);
  vec2 place = multum_first_tap(v_st, footprint);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < footprint.tap_count; ++i) {
    vec2 tap = place + float(i) * footprint.tap_step;
#ifdef MULTUM_ROUGHNESS_TEXTURE
    multum_take_roughness(tap, MultumFootprint(vec2(0.0), 1, of_roughness.level));
#endif
    sum += multum_lights(multum_fetch_surface(tap, one), to_world, v_position, v);
  }
  o_colour = vec4(sum / float(footprint.tap_count), 1.0);
#else
  o_colour = vec4(multum_lights(multum_fetch_surface(v_st, footprint), to_world, v_position, v), 1.0);
#endif
}
