// SPDX-License-Identifier: Apache-2.0
// Numbers at random for renderers that draw one lobe and one normal of it a pixel: blue noise over the picture, so that
// what neighbouring pixels are off by differs, and evenly spread over the frames of each pixel.

const float MULTUM_BLUE_NOISE_FRAMES = 1024.0;  // that are unlike

// Three of them, 0 to 1: the first for the lobe, the others for multum_movmf_drawn_normal(). `noise`: RGBA8, 64 x 64,
// host/formats/sampling/blue_noise.h; any sampler will do, texels are read at their middles. `pixel`: its place in
// the picture, in pixels; `frame` counts from 0. Frames shift the texel's values (Cranley and Patterson's rotation),
// the first by the golden ratio, the others along Roberts' R2 sequence; products of larger numbers would lose their
// fractions.
vec3 multum_blue_noise(sampler2D noise, vec2 pixel, float frame) {
  float count = frame - MULTUM_BLUE_NOISE_FRAMES * floor(frame / MULTUM_BLUE_NOISE_FRAMES);
  vec3 shift = count * vec3(0.61803399, 0.75487767, 0.56984029);
  vec3 texel = textureLod(noise, fract((floor(pixel) + 0.5) / 64.0), 0.0).xyz;
  return fract(texel * (255.0 / 256.0) + shift);
}
