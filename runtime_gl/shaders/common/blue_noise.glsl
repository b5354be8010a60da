// SPDX-License-Identifier: Apache-2.0
// Makes random numbers for renderers that choose one lobe, and one of its normals, at random per pixel. The numbers are
// blue noise over the picture, so neighbouring pixels have different errors. Over the frames of one pixel, the numbers
// are evenly spread.

const float MULTUM_BLUE_NOISE_FRAMES = 1024.0;  // number of frames before the numbers repeat

// Returns three numbers from 0 to 1. The first selects the lobe, and the others are for multum_movmf_drawn_normal().
// `noise` is the RGBA8 texture of 64 x 64 texels from host/formats/sampling/blue_noise.h. Any sampler works, because
// texels are read at their centres. `pixel` is the place in the picture, in pixels, and `frame` counts from 0. Each
// frame shifts the texel's values (Cranley and Patterson's rotation). The first value is shifted by the golden ratio,
// and the others along Roberts' R2 sequence. Frame numbers repeat, because products of larger numbers would lose their
// fractions.
vec3 multum_blue_noise(sampler2D noise, vec2 pixel, float frame) {
  float count = frame - MULTUM_BLUE_NOISE_FRAMES * floor(frame / MULTUM_BLUE_NOISE_FRAMES);
  vec3 shift = count * vec3(0.61803399, 0.75487767, 0.56984029);
  vec3 texel = textureLod(noise, fract((floor(pixel) + 0.5) / 64.0), 0.0).xyz;
  return fract(texel * (255.0 / 256.0) + shift);
}
