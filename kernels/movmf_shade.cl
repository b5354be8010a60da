// SPDX-License-Identifier: Apache-2.0
// Shades filtered lobes by the runtime's formula, so that a bake can measure the error of its output. Highlights are
// convolved, and on request multiplied by the cosine n . l of the light.

#include "device/numerics.clh"
#include "shared/highlight.h"

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
#include "device/vmf_lit.clh"
#define SHAPE BlinnPhongLobe
#define SHAPE_OF(lobe, exponent) blinn_phong_lobe(lobe, exponent)
#define SHADE_HIGHLIGHT(shape, lobe, h) shade_blinn_phong(shape, one_minus_cosine(lobe, h))
#define SHADE_LAMBERT(lobe, light) shade_lambert(without_roughness(lobe, (light).w), (light).xyz)
#endif

#define HAS_TERMS (!MULTUM_PLANAR)

#if MULTUM_PLANAR
#define FACET_KAPPA(exponent) 0.0f
// Returns the cosine of a lobe's highlight as the runtime computes it. Gaussians use the cosine of their mean.
static inline float lit_cosine(float4 lobe, float3 h, float4 light, float facet_kappa) {
  return gmm_lambert(lobe, light.xyz) / max(lobe.w, GMM_AMPLITUDE_MIN);
}
#else
#define FACET_KAPPA(exponent) blinn_phong_kappa(exponent)
#endif

#if MULTUM_VECTOR_WIDTH != 1
#error "movmf_shade has only a scalar variant"
#endif
#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

// One work-item handles one sample point. The global size is sample_count.
//   lobes      [sample][lobe]   (a r_x, a r_y, a r_z, a), already filtered; with MULTUM_PLANAR as in gmm_shading.clh
//   half_vectors [half_count]   unit vectors; w: 1 + the index of the light whose cosine multiplies the
//                               highlights, or 0 for no cosine
//   lights     [light_count]    unit vectors; w: the mean cosine for without_roughness(), unused with MULTUM_PLANAR
//   highlights [highlight_count]              with MULTUM_PLANAR only the exponent and the total are used
//   values     [sample][highlight_count * half_count + light_count]   written: highlights, then Lambert
// The kernel is compute bound.
__kernel void movmf_shade(__global const float4* lobes, __global const float4* half_vectors,
                          __global const float4* lights, __global const MultumHighlight* highlights,
                          __global float* values, int sample_count, int half_count, int light_count,
                          int highlight_count) {
  const int sample = (int)get_global_id(0);
  if (sample >= sample_count) return;
  __global float* out = values + (size_t)sample * (highlight_count * half_count + light_count);
  for (int e = 0; e < highlight_count; ++e) {
#if HAS_TERMS
    if (highlights[e].term_count > 0) {
      for (int d = 0; d < half_count; ++d) out[d] = 0.0f;
      for (int j = 0; j < MULTUM_LOBES; ++j) {
        const float4 lobe = lobes[(size_t)sample * MULTUM_LOBES + j];
        for (int d = 0; d < half_count; ++d) {
          const float4 h = half_vectors[d];
          out[d] += h.w == 0.0f ? shade_terms(lobe, highlights + e, one_minus_cosine(lobe, h.xyz))
                                : lit_terms(lobe, highlights + e, h.xyz, lights[(int)h.w - 1]);
        }
      }
      out += half_count;
      continue;
    }
#endif
    SHAPE shapes[MULTUM_LOBES];
    for (int j = 0; j < MULTUM_LOBES; ++j)
      shapes[j] = SHAPE_OF(lobes[(size_t)sample * MULTUM_LOBES + j], highlights[e].exponent);
    for (int d = 0; d < half_count; ++d) {
      float sum = 0.0f;
      for (int j = 0; j < MULTUM_LOBES; ++j) {
        const float4 lobe = lobes[(size_t)sample * MULTUM_LOBES + j];
        const float4 h = half_vectors[d];
        const float cosine =
            h.w == 0.0f ? 1.0f : lit_cosine(lobe, h.xyz, lights[(int)h.w - 1], FACET_KAPPA(highlights[e].exponent));
        sum += SHADE_HIGHLIGHT(shapes[j], lobe, h.xyz) * cosine;
      }
      *out++ = sum * highlights[e].total;
    }
  }
  for (int d = 0; d < light_count; ++d) {
    float sum = 0.0f;
    for (int j = 0; j < MULTUM_LOBES; ++j) sum += SHADE_LAMBERT(lobes[(size_t)sample * MULTUM_LOBES + j], lights[d]);
    *out++ = sum;
  }
}
