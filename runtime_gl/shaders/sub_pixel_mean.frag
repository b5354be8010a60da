// SPDX-License-Identifier: Apache-2.0
// Computes a pixel as the mean of its MULTUM_SIDE^2 sub-pixels.
uniform sampler2D u_sub_pixels;  // rows of pixels from u_first_row on
uniform int u_first_row;
layout(location = 0) out vec4 o_radiance;

void main() {
  ivec2 first = (ivec2(gl_FragCoord.xy) - ivec2(0, u_first_row)) * MULTUM_SIDE;
  vec4 sum = vec4(0.0);
  for (int y = 0; y < MULTUM_SIDE; ++y)
    for (int x = 0; x < MULTUM_SIDE; ++x) sum += texelFetch(u_sub_pixels, first + ivec2(x, y), 0);
  o_radiance = sum / float(MULTUM_SIDE * MULTUM_SIDE);
}
