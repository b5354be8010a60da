// SPDX-License-Identifier: Apache-2.0
// Shades filtered spherical harmonics by the runtime's formula, so that a bake can measure the error of its output. The
// formula is the sum of a_l g_lm Y_lm, clamped at 0 (Han et al. 2007, section 5). Highlights are convolved, and on
// request multiplied by the cosine n . l of the light.

#include "device/spherical_harmonics.clh"
#include "device/vmf_lit.clh"
#include "shared/filtered_sh.h"
#include "shared/highlight.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "sh_shade has only a scalar variant"
#endif

// Returns the weighted sum, clamped at 0. A truncated series can be below 0 because of ringing, but light is never
// negative.
static float weighted_bands(const float* bands, __global const float* zonal) {
  float sum = 0.0f;
  for (int l = 0; l <= MULTUM_SH_ORDER; ++l) sum = fma(zonal[l], bands[l], sum);
  return max(sum, 0.0f);
}

static float shade_map(float4 lobe, __global const MultumHighlight* f, float4 h, __global const float4* lights) {
  const float e = one_minus_cosine(lobe, h.xyz);
  const int is_lit = h.w != 0.0f;
  if (f->term_count > 0) return is_lit ? lit_terms(lobe, f, h.xyz, lights[(int)h.w - 1]) : shade_terms(lobe, f, e);
  const float cosine = is_lit ? lit_cosine(lobe, h.xyz, lights[(int)h.w - 1], blinn_phong_kappa(f->exponent)) : 1.0f;
  return shade_blinn_phong(blinn_phong_lobe(lobe, f->exponent), e) * cosine;
}

#define SH_LINEAR_CONSTANT 0.488602512f  // the constant of Y_1m

// Returns the cosine that multiplies the highlight of half vector h. This is the cosine of the mean normal, which is
// shorter than 1, or 1 if h.w requests no cosine. The coefficients (1, -1), (1, 0), (1, 1) are y, z, x.
static float cosine_of_half(__global const float* g, float share, float4 h, __global const float4* lights) {
  if (h.w == 0.0f) return 1.0f;
  const float4 light = lights[(int)h.w - 1];
  const float sum = g[2] * light.x + g[0] * light.y + g[1] * light.z;
  return max(sum / (SH_LINEAR_CONSTANT * max(share, AMPLITUDE_SHADED_MIN)), 0.0f);
}

// One work-item handles one sample point. The global size is sample_count.
//   coefficients [sample][order (order + 2)]   already filtered
//   points     [sample]
//   steps      the recurrence's constants
//   zonal      [highlight_count + 1][order + 1]   of each highlight, then of Lambert
//   half_vectors [half_count]   unit vectors; w: 1 + the index of the light whose cosine multiplies the
//                               highlights, or 0 for no cosine
//   lights     [light_count]    unit vectors; w: the mean cosine for without_roughness()
//   highlights [highlight_count]
//   values     [sample][highlight_count * half_count + light_count]   written: highlights, then Lambert
// Levels that come from the normal map are shaded in the same way as lobes. The kernel is compute bound.
__kernel void sh_shade(__global const float* coefficients, __global const MultumFilteredSh* points,
                       __global const float2* steps, __global const float* zonal, __global const float4* half_vectors,
                       __global const float4* lights, __global const MultumHighlight* highlights,
                       __global float* values, int sample_count, int half_count, int light_count, int highlight_count) {
  const int sample = (int)get_global_id(0);
  if (sample >= sample_count) return;
  __global const float* g = coefficients + (size_t)sample * MULTUM_SH_COEFFICIENTS;
  const MultumFilteredSh point = points[sample];
  const float4 map_lobe = (float4)(point.map_x, point.map_y, point.map_z, point.map_share);
  __global float* out = values + (size_t)sample * (highlight_count * half_count + light_count);
  float bands[MULTUM_SH_ORDER + 1];
  for (int d = 0; d < half_count; ++d) {
    const float3 h = half_vectors[d].xyz;
    sh_bands(g, point.share, h, steps, bands);
    const float cosine = cosine_of_half(g, point.share, half_vectors[d], lights);
    for (int e = 0; e < highlight_count; ++e)
      out[e * half_count + d] = weighted_bands(bands, zonal + e * (MULTUM_SH_ORDER + 1)) * cosine +
                                shade_map(map_lobe, highlights + e, half_vectors[d], lights);
  }
  out += highlight_count * half_count;
  for (int d = 0; d < light_count; ++d) {
    sh_bands(g, point.share, lights[d].xyz, steps, bands);
    out[d] = weighted_bands(bands, zonal + highlight_count * (MULTUM_SH_ORDER + 1)) +
             shade_lambert(without_roughness(map_lobe, lights[d].w), lights[d].xyz);
  }
}
