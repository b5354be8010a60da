// SPDX-License-Identifier: Apache-2.0
// Shades filtered moments by the runtime's formulas, so that a bake can measure the error of its output. Highlights are
// convolved, and on request multiplied by the cosine n . l of the light.

#include "device/moment_shading.clh"
#include "shared/moments.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "moment_shade has only a scalar variant"
#endif

// Returns the cosine that multiplies the highlight of half vector h. This is the cosine of the averaged normal, or 1 if
// h.w requests no cosine.
static inline float cosine_of_half(float4 mean, float4 h, __global const float4* lights) {
  if (h.w == 0.0f) return 1.0f;
  return max(1.0f - one_minus_cosine(mean, lights[(int)h.w - 1].xyz), 0.0f);
}

// One work-item handles one sample point. The global size is sample_count.
//   moments    [sample]                       already filtered
//   half_vectors [half_count]   unit vectors; w: 1 + the index of the light whose cosine multiplies the
//                               highlights, or 0 for no cosine
//   lights     [light_count]    unit vectors; w: the mean cosine for without_roughness()
//   exponents  [exponent_count]               Blinn-Phong s
//   values     [sample][exponent_count * half_count + light_count]   written: Blinn-Phong, then Lambert
// `shading` is MULTUM_SHADE_...; levels that come from the normal map always use Toksvig's rule.
// The kernel is compute bound.
__kernel void moment_shade(__global const MultumFilteredMoments* moments, __global const float4* half_vectors,
                           __global const float4* lights, __global const float* exponents, __global float* values,
                           int sample_count, int half_count, int light_count, int exponent_count, int shading) {
  const int sample = (int)get_global_id(0);
  if (sample >= sample_count) return;
  const MultumFilteredMoments m = moments[sample];
  const float4 mean = (float4)(m.normal_x, m.normal_y, m.normal_z, m.share);
  const float4 map_mean = (float4)(m.map_x, m.map_y, m.map_z, m.map_share);
  const float inverse = m.share > AMPLITUDE_SHADED_MIN ? 1.0f / m.share : 0.0f;
  __global float* out = values + (size_t)sample * (exponent_count * half_count + light_count);
  for (int e = 0; e < exponent_count; ++e)
    for (int d = 0; d < half_count; ++d) {
      const float3 h = half_vectors[d].xyz;
      const float stored =
          shading == MULTUM_SHADE_TOKSVIG
              ? shade_toksvig(mean, h, exponents[e])
              : m.share * shade_lean(m.s * inverse, m.t * inverse, m.ss * inverse, m.tt * inverse, m.st * inverse, h,
                                     exponents[e], shading == MULTUM_SHADE_LEAN_JACOBIAN);
      *out++ = stored * cosine_of_half(mean, half_vectors[d], lights) +
               shade_toksvig(map_mean, h, exponents[e]) * cosine_of_half(map_mean, half_vectors[d], lights);
    }
  for (int d = 0; d < light_count; ++d)
    *out++ = shade_mean_cosine(without_roughness(mean, lights[d].w), lights[d].xyz) +
             shade_mean_cosine(without_roughness(map_mean, lights[d].w), lights[d].xyz);
}
