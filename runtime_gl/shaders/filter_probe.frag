// SPDX-License-Identifier: Apache-2.0
// Makes one draw of the filter probe (runtime_gl/probe/filter_probe.h): the sampler's results for eight classes of
// texels.
//   u_probes[0..1]  1 in the channel of a texel's class; the filtered value is the weight of that class's texel
//   u_probes[2..3]  low digit of the texel's number; the filtered value is weight * digit
//   u_probes[4..5]  high digit
//   MULTUM_OCCLUDER another object, which hides the first one and writes zeros
in vec2 v_st;
uniform sampler2D u_probes[6];
layout(location = 0) out vec4 o_probes[6];
layout(location = 6) out vec4 o_place;  // s, t, level of detail, 1

void main() {
#ifdef MULTUM_OCCLUDER
  for (int i = 0; i < 6; ++i) o_probes[i] = vec4(0.0);
  o_place = vec4(0.0);
#else
  for (int i = 0; i < 6; ++i) o_probes[i] = texture(u_probes[i], v_st);
  o_place = vec4(v_st, textureQueryLod(u_probes[0], v_st).y, 1.0);
#endif
}
