// SPDX-License-Identifier: Apache-2.0
// Shades filtered lobes by the runtime's formula, so that a bake can measure the error of what it wrote: the
// convolution alone, without n . l.

#include "device/vmf_shading.clh"

#if MULTUM_VECTOR_WIDTH != 1
#error "movmf_shade has only a scalar variant"
#endif
#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

// One work-item = one sample point; global size sample_count.
//   lobes      [sample][lobe]                 (a r_x, a r_y, a r_z, a), already filtered
//   half_vectors [half_count], lights [light_count]   unit vectors; w of lights: without_roughness()'s mean cosine
//   exponents  [exponent_count]               Blinn-Phong s
//   values     [sample][exponent_count * half_count + light_count]   written: Blinn-Phong, then Lambert
// Compute bound.
__kernel void movmf_shade(__global const float4* lobes, __global const float4* half_vectors,
                          __global const float4* lights, __global const float* exponents, __global float* values,
                          int sample_count, int half_count, int light_count, int exponent_count) {
  const int sample = (int)get_global_id(0);
  if (sample >= sample_count) return;
  __global float* out = values + (size_t)sample * (exponent_count * half_count + light_count);
  for (int e = 0; e < exponent_count; ++e) {
    BlinnPhongLobe shapes[MULTUM_LOBES];
    for (int j = 0; j < MULTUM_LOBES; ++j)
      shapes[j] = blinn_phong_lobe(lobes[(size_t)sample * MULTUM_LOBES + j], exponents[e]);
    for (int d = 0; d < half_count; ++d) {
      float sum = 0.0f;
      for (int j = 0; j < MULTUM_LOBES; ++j) {
        const float distance = one_minus_cosine(lobes[(size_t)sample * MULTUM_LOBES + j], half_vectors[d].xyz);
        sum += shade_blinn_phong(shapes[j], distance);
      }
      *out++ = sum;
    }
  }
  for (int d = 0; d < light_count; ++d) {
    float sum = 0.0f;
    for (int j = 0; j < MULTUM_LOBES; ++j) {
      sum += shade_lambert(without_roughness(lobes[(size_t)sample * MULTUM_LOBES + j], lights[d].w), lights[d].xyz);
    }
    *out++ = sum;
  }
}
