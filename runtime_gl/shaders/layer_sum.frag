// SPDX-License-Identifier: Apache-2.0
// Makes the texture of a layer from decoded images of a packed field, in the same way as texture_chunk and mip_levels
// of host/fields/codec/decoder, one texel per fragment. Exactly one of these is defined:
//   MULTUM_IMAGE_COUNT n   adds up n images of gamma-coded values; with MULTUM_HAS_SUM also the sum of earlier
//                          passes; with MULTUM_IS_LAST converts the sum to radiance and rounds it to half
//   MULTUM_MIP             makes a level from the next finer one: the mean of the texels that each texel covers
uniform vec3 u_offset;
#ifdef MULTUM_MIP
uniform sampler2D u_finer;
#else
#if MULTUM_IMAGE_COUNT > 0
uniform sampler2D u_images[MULTUM_IMAGE_COUNT];
uniform float u_weights[MULTUM_IMAGE_COUNT];
#endif
#ifdef MULTUM_HAS_SUM
uniform sampler2D u_sum;
#endif
#endif
layout(location = 0) out vec4 o_colour;

// Returns the nearest 16-bit float, with ties to even, of a value of at least 0. Drivers may instead truncate to 16-bit
// floats, as llvmpipe does (Mesa 22.3.6). Mip levels would add up this bias.
float multum_rounded_to_half(float value) {
  if (value < 6.103515625e-05) return roundEven(value * 16777216.0) / 16777216.0;  // multiples of 2^-24
  uint bits = floatBitsToUint(min(value, 65504.0));
  bits += 0x0fffu + ((bits >> 13) & 1u);
  return uintBitsToFloat(bits & 0xffffe000u);
}

vec3 multum_rounded_to_halves(vec3 values) {
  return vec3(multum_rounded_to_half(values.r), multum_rounded_to_half(values.g), multum_rounded_to_half(values.b));
}

// Finds which of n fine texels the coarse texel i covers. The result is the first of them, their number, and up to
// three weights.
vec3 multum_cover(int n, int i, out int first, out int count) {
  first = n == 1 ? 0 : 2 * i;
  count = n == 1 ? 1 : 2 + n % 2;
  if (n == 1) return vec3(1.0, 0.0, 0.0);
  if (n % 2 == 0) return vec3(0.5, 0.5, 0.0);
  float m = float(n / 2);
  return vec3(m - float(i), m, float(i + 1)) / float(n);
}

#ifdef MULTUM_MIP
void main() {
  ivec2 size = textureSize(u_finer, 0), at = ivec2(gl_FragCoord.xy), first, count;
  vec3 columns = multum_cover(size.x, at.x, first.x, count.x), rows = multum_cover(size.y, at.y, first.y, count.y);
  vec3 sum = vec3(0.0);
  for (int y = 0; y < count.y; ++y)
    for (int x = 0; x < count.x; ++x)
      sum += rows[y] * columns[x] * texelFetch(u_finer, first + ivec2(x, y), 0).rgb;
  o_colour = vec4(multum_rounded_to_halves(sum), 1.0);
}
#else
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 sum = u_offset;
#ifdef MULTUM_HAS_SUM
  sum += texelFetch(u_sum, at, 0).rgb;
#endif
#if MULTUM_IMAGE_COUNT > 0
  for (int i = 0; i < MULTUM_IMAGE_COUNT; ++i) sum += u_weights[i] * texelFetch(u_images[i], at, 0).rgb;
#endif
#ifdef MULTUM_IS_LAST
  sum = multum_rounded_to_halves(pow(max(sum, vec3(0.0)) / 255.0, vec3(2.2)));
#endif
  o_colour = vec4(sum, 1.0);
}
#endif
