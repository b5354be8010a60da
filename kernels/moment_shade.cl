// SPDX-License-Identifier: Apache-2.0
// Shades filtered moments by the runtime's formulas, so that a bake can measure the error of what it wrote: the
// convolution alone, without n . l.

#include "device/moment_shading.clh"
#include "shared/moments.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "moment_shade has only a scalar variant"
#endif

// One work-item = one sample point; global size sample_count.
//   moments    [sample]                       already filtered
//   half_vectors [half_count], lights [light_count]   unit vectors; w of lights: without_roughness()'s mean cosine
//   exponents  [exponent_count]               Blinn-Phong s
//   values     [sample][exponent_count * half_count + light_count]   written: Blinn-Phong, then Lambert
// `shading` is MULTUM_SHADE_...; levels that are left to the normal map are shaded by Toksvig's rule in each.
// Compute bound.
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
      *out++ = stored + shade_toksvig(map_mean, h, exponents[e]);
    }
  for (int d = 0; d < light_count; ++d)
    *out++ = shade_mean_cosine(without_roughness(mean, lights[d].w), lights[d].xyz) +
             shade_mean_cosine(without_roughness(map_mean, lights[d].w), lights[d].xyz);
}
