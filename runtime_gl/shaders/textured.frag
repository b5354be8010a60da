// SPDX-License-Identifier: Apache-2.0
// Sums the radiance of the textures. Alpha is 1 where the object is.
//   MULTUM_LAYER_COUNT   number of textures; with 0 the object is black
in vec2 v_st;
#if MULTUM_LAYER_COUNT > 0
uniform sampler2D u_layers[MULTUM_LAYER_COUNT];
#endif
layout(location = 0) out vec4 o_radiance;

void main() {
  vec3 sum = vec3(0.0);
#if MULTUM_LAYER_COUNT > 0
  for (int i = 0; i < MULTUM_LAYER_COUNT; ++i) sum += texture(u_layers[i], v_st).rgb;
#endif
  o_radiance = vec4(sum, 1.0);
}
