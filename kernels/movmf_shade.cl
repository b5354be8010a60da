// SPDX-License-Identifier: Apache-2.0
// Shades filtered lobes by the runtime's formula, so that a bake can measure the error of what it wrote: the
// convolution alone, without n . l.

#include "device/numerics.clh"

#ifndef MULTUM_PLANAR
#define MULTUM_PLANAR 0
#endif
#if MULTUM_PLANAR
#include "device/gmm_shading.clh"
#define SHAPE GmmLobe
#define SHAPE_OF(lobe, exponent) gmm_lobe(lobe, blinn_phong_variance(exponent))
#define SHADE_HIGHLIGHT(shape, lobe, h) gmm_density(shape, h)
#define SHADE_LAMBERT(lobe, light) gmm_lambert(lobe, (light).xyz)
#else
#include "device/vmf_shading.clh"
#define SHAPE BlinnPhongLobe
#define SHAPE_OF(lobe, exponent) blinn_phong_lobe(lobe, exponent)
#define SHADE_HIGHLIGHT(shape, lobe, h) shade_blinn_phong(shape, one_minus_cosine(lobe, h))
#define SHADE_LAMBERT(lobe, light) shade_lambert(without_roughness(lobe, (light).w), (light).xyz)
#endif

#if MULTUM_VECTOR_WIDTH != 1
#error "movmf_shade has only a scalar variant"
#endif
#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

// One work-item = one sample point; global size sample_count.
//   lobes      [sample][lobe]                 (a r_x, a r_y, a r_z, a), already filtered; of MULTUM_PLANAR as
//                                             gmm_shading.clh has them
//   half_vectors [half_count], lights [light_count]   unit vectors; w of lights: without_roughness()'s mean cosine, of
//                                             MULTUM_PLANAR unused
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
    SHAPE shapes[MULTUM_LOBES];
    for (int j = 0; j < MULTUM_LOBES; ++j) shapes[j] = SHAPE_OF(lobes[(size_t)sample * MULTUM_LOBES + j], exponents[e]);
    for (int d = 0; d < half_count; ++d) {
      float sum = 0.0f;
      for (int j = 0; j < MULTUM_LOBES; ++j)
        sum += SHADE_HIGHLIGHT(shapes[j], lobes[(size_t)sample * MULTUM_LOBES + j], half_vectors[d].xyz);
      *out++ = sum;
    }
  }
  for (int d = 0; d < light_count; ++d) {
    float sum = 0.0f;
    for (int j = 0; j < MULTUM_LOBES; ++j) sum += SHADE_LAMBERT(lobes[(size_t)sample * MULTUM_LOBES + j], lights[d]);
    *out++ = sum;
  }
}
