// SPDX-License-Identifier: Apache-2.0
// Looks up mip-mapped textures over the area that a pixel covers, in the same way on every driver. Across a pixel,
// texture coordinates change by one length along the row and by another along the column. Takes N trilinear lookups
// ("taps") along the longer length, at the level of the shorter length, similar to the example of
// GL_EXT_texture_filter_anisotropic. Textures of lobes, moments and harmonics are linear in the normals, so the mean of
// taps equals the result of a wider filter.
//
//   longer, shorter   of |d(s, t)/dx| and |d(s, t)/dy|, in texels of level 0
//   N                 ceil(longer / shorter), at most MULTUM_TAPS
//   tap i of 0..N-1   at ((i + 1/2) / N - 1/2) times the longer derivative from the middle
//   level             u_level_bias + log2(longer) for one tap, max(log2(shorter), log2(longer / N) - 0.75) for several
//
// With one tap this is the trilinear filter of OpenGL 4.5, section 8.14. The extension's example differs in two ways.
// It uses the level of longer / N. For ratios just above a whole number, this level is up to an octave finer than the
// level of the shorter length, and the picture sparkles in the direction of the shorter length. The other difference is
// that the example's taps are 1 / (N + 1) apart. A trilinear lookup reaches twice the texel width of its level, so
// neighbouring taps overlap, and a finer level is enough along the axis. Offsets of 0, 0.5, 0.75 and 1 octave were
// tried; 0.75 had the lowest error against references of six real maps (2 taps, bias -0.25: 8.5 %, compared with 9.9 %
// for the example). u_level_bias < 0 sharpens: at -0.79, one tap on a square footprint has the variance of the pixel's
// own box (docs/evidence/WILLIAMS.md, "The factor").
//
// With MULTUM_DRIVER_FILTER the driver's sampler does all of this instead.
#ifndef MULTUM_TAPS
#define MULTUM_TAPS 1
#endif

struct MultumFootprint {
  vec2 tap_step;  // distance between neighbouring taps, in st
  int tap_count;
  float level;  // before clamping; negative if the texture is magnified
};

const float MULTUM_TAP_OVERLAP = 0.594603558;  // 2^-0.75

uniform float u_level_bias;

// Returns the place of the first tap. The others follow at distances of tap_step.
vec2 multum_first_tap(vec2 st, MultumFootprint footprint) {
  return st - 0.5 * float(footprint.tap_count - 1) * footprint.tap_step;
}

// `along_x` and `along_y` are the derivatives of st along a row and a column of pixels, in texels of level 0. `size` is
// the size of level 0.
MultumFootprint multum_footprint_of(vec2 along_x, vec2 along_y, vec2 size) {
  float length_x = length(along_x), length_y = length(along_y);
  float longer = max(length_x, length_y), shorter = min(length_x, length_y);
  // A rounding error in a whole-number ratio must not add a tap.
  float ratio = min(longer / max(shorter, 1e-20), float(MULTUM_TAPS));
  int count = max(int(ceil(ratio - 1e-3)), 1);
  float width = count == 1 ? longer : max(shorter, longer / float(count) * MULTUM_TAP_OVERLAP);
  vec2 axis = (length_x > length_y ? along_x : along_y) / size;
  return MultumFootprint(axis / float(count), count, log2(max(width, 1e-15)) + u_level_bias);
}

#ifdef MULTUM_DRIVER_FILTER
// Only the level of the driver's lookup is known. With an anisotropic filter, this is the level of the shorter length.
// The longer length is stored as the step of the single tap.
MultumFootprint multum_footprint(sampler2D map, vec2 st) {
  vec2 size = vec2(textureSize(map, 0)), x = dFdx(st), y = dFdy(st);
  return MultumFootprint(length(x * size) > length(y * size) ? x : y, 1, textureQueryLod(map, st).y);
}

MultumFootprint multum_footprint(sampler2DArray map, vec2 st) {
  vec2 size = vec2(textureSize(map, 0).xy), x = dFdx(st), y = dFdy(st);
  return MultumFootprint(length(x * size) > length(y * size) ? x : y, 1, textureQueryLod(map, st).y);
}

vec4 multum_filtered(sampler2D map, vec2 st, MultumFootprint footprint) { return texture(map, st); }
vec4 multum_filtered(sampler2DArray map, vec2 st, float layer, MultumFootprint footprint) {
  return texture(map, vec3(st, layer));
}
#else
#ifdef MULTUM_EVALUATIONS
vec2 multum_part = vec2(1.0);  // share of the pixel's width and height that one footprint covers
#else
const vec2 multum_part = vec2(1.0);
#endif

// This function takes derivatives, so it must be called only where every fragment calls it.
MultumFootprint multum_footprint(sampler2D map, vec2 st) {
  vec2 size = vec2(textureSize(map, 0));
  return multum_footprint_of(multum_part.x * dFdx(st) * size, multum_part.y * dFdy(st) * size, size);
}

MultumFootprint multum_footprint(sampler2DArray map, vec2 st) {
  vec2 size = vec2(textureSize(map, 0).xy);
  return multum_footprint_of(multum_part.x * dFdx(st) * size, multum_part.y * dFdy(st) * size, size);
}

#if MULTUM_TAPS == 1
vec4 multum_filtered(sampler2D map, vec2 st, MultumFootprint footprint) { return textureLod(map, st, footprint.level); }
vec4 multum_filtered(sampler2DArray map, vec2 st, float layer, MultumFootprint footprint) {
  return textureLod(map, vec3(st, layer), footprint.level);
}
#else
vec4 multum_filtered(sampler2D map, vec2 st, MultumFootprint footprint) {
  vec2 place = multum_first_tap(st, footprint);
  vec4 sum = vec4(0.0);
  for (int i = 0; i < footprint.tap_count; ++i)
    sum += textureLod(map, place + float(i) * footprint.tap_step, footprint.level);
  return sum / float(footprint.tap_count);
}

vec4 multum_filtered(sampler2DArray map, vec2 st, float layer, MultumFootprint footprint) {
  vec2 place = multum_first_tap(st, footprint);
  vec4 sum = vec4(0.0);
  for (int i = 0; i < footprint.tap_count; ++i)
    sum += textureLod(map, vec3(place + float(i) * footprint.tap_step, layer), footprint.level);
  return sum / float(footprint.tap_count);
}
#endif
#endif

// Returns the level of detail of all taps together. This is the level of the longer length, which a trilinear filter
// would use.
float multum_footprint_longer_lod(MultumFootprint footprint, ivec2 size) {
#ifdef MULTUM_DRIVER_FILTER
  return max(footprint.level, log2(max(length(footprint.tap_step * vec2(size)), 1e-15)));
#else
  if (footprint.tap_count == 1) return footprint.level;
  return log2(float(footprint.tap_count) * length(footprint.tap_step * vec2(size))) + u_level_bias;
#endif
}

// Returns the footprint on another texture with the same coordinates. Levels count from that texture's finest level.
MultumFootprint multum_footprint_on(MultumFootprint footprint, ivec2 from_size, ivec2 to_size) {
  float octaves = log2(float(max(to_size.x, to_size.y)) / float(max(from_size.x, from_size.y)));
  return MultumFootprint(footprint.tap_step, footprint.tap_count, footprint.level + octaves);
}

// Returns one lobe of the normal map over its footprint (after movmf_shading.glsl). The normal map has the levels finer
// than the stored ones. Without roughness in the lobes, the lobe is not wider than the normals that a pixel sees.
vec4 multum_normal_map_lobe(sampler2D map, vec2 st, MultumFootprint footprint) {
  vec4 lobe = multum_filtered(map, st, footprint);
#ifndef MULTUM_ROUGHNESS
  lobe = multum_movmf_magnified(lobe, multum_footprint_longer_lod(footprint, textureSize(map, 0)));
#endif
  return lobe;
}
