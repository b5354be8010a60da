// SPDX-License-Identifier: Apache-2.0
// Chooses at random one of the finest texels that the texture filter averages at a place. A texel's probability is its
// weight in the filter. First the function chooses uniformly one of the footprint's taps, and a level by the fraction
// of the level of detail. Then it chooses a texel of that level by the bilinear weights, and uniformly one of the
// finest texels that this texel covers. The mean of many draws is the result of filtering exact distributions. A baked
// map differs from this reference only by the errors of its texels.
uniform int u_wrap_s, u_wrap_t;  // 0 black, 1 clamp, 2 periodic, 3 mirror
const ivec2 MULTUM_NO_TEXEL = ivec2(-1);

uint multum_hash(uint v) {  // Jarzynski and Olano 2020, "pcg"
  uint state = v * 747796405u + 2891336453u;
  uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

// Returns the n-th of six coordinates of Roberts' sequence, g^7 = g + 1, shifted by the pixel's own hash. The products
// are computed modulo 2^32 with integers, because floats would lose their fractions.
float multum_random(int n) {
  // 2^32 / g^(n+1)
  const uint steps[6] = uint[6](3859688306u, 3468523225u, 3117001274u, 2801104767u, 2517223198u, 2262111973u);
  uint pixel = multum_hash(uint(gl_FragCoord.x) + multum_hash(uint(gl_FragCoord.y) + multum_hash(uint(n))));
  return float((pixel + uint(u_sample) * steps[n]) >> 8u) / 16777216.0;
}

int multum_wrapped(int i, int size, int mode) {
  if (mode == 1) return clamp(i, 0, size - 1);
  if (mode == 0) return i >= 0 && i < size ? i : -1;
  int period = mode == 2 ? size : 2 * size;
  // Uses only integers, because 37.0 / 37.0 is less than 1 on a GPU that divides by multiplying (seen on NVIDIA 580).
  i -= period * (i >= 0 ? i / period : -1 - (-1 - i) / period);
  return i < size ? i : period - 1 - i;
}

// Returns a texel of the finest level, or MULTUM_NO_TEXEL beyond a black border.
ivec2 multum_footprint_texel(sampler2D map, vec2 st, MultumFootprint footprint) {
  ivec2 size = textureSize(map, 0);
  float level_max = floor(log2(float(max(size.x, size.y))) + 1e-4);
  float lod = clamp(footprint.level, 0.0, level_max);
  int level = int(lod) + (multum_random(0) < fract(lod) ? 1 : 0);
  ivec2 level_size = max(size >> level, ivec2(1));
  float tap = floor(multum_random(5) * float(footprint.tap_count));
  vec2 place = (multum_first_tap(st, footprint) + tap * footprint.tap_step) * vec2(level_size) - 0.5;
  ivec2 texel = ivec2(floor(place)) + ivec2(lessThan(vec2(multum_random(1), multum_random(2)), fract(place)));
  texel = ivec2(multum_wrapped(texel.x, level_size.x, u_wrap_s), multum_wrapped(texel.y, level_size.y, u_wrap_t));
  if (min(texel.x, texel.y) < 0) return MULTUM_NO_TEXEL;
  vec2 within = vec2(multum_random(3), multum_random(4));
  return min(ivec2((vec2(texel) + within) * vec2(size) / vec2(level_size)), size - 1);
}
