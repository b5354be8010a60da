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
static inline real_v lit_cosine(lobe_v lobe, float3 h, float4 light, float facet_kappa) {
  return gmm_lambert(lobe, light.xyz) / max(lobe.w, GMM_AMPLITUDE_MIN);
}
#else
#define FACET_KAPPA(exponent) blinn_phong_kappa(exponent)
#endif

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

#if MULTUM_VECTOR_WIDTH == 1
static inline lobe_v load_lobe(__global const float4* lobes, int sample, int sample_count, int j) {
  return lobes[(size_t)sample * MULTUM_LOBES + j];
}
static inline void store_value(real_v value, __global float* values, int sample, int sample_count) {
  values[sample] = value;
}
#else
// Loads lobe j of sample `first` and the samples after it. Lanes without a sample repeat the last sample.
static inline lobe_v load_lobe(__global const float4* lobes, int first, int sample_count, int j) {
  float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH], w[MULTUM_VECTOR_WIDTH];
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    const float4 one = lobes[(size_t)min(first + lane, sample_count - 1) * MULTUM_LOBES + j];
    x[lane] = one.x;
    y[lane] = one.y;
    z[lane] = one.z;
    w[lane] = one.w;
  }
  return LOBE_V(LOAD_V(x), LOAD_V(y), LOAD_V(z), LOAD_V(w));
}
// Writes the lanes that have a sample.
static inline void store_value(real_v value, __global float* values, int first, int sample_count) {
  if (first + MULTUM_VECTOR_WIDTH <= sample_count) {
    STORE_V(value, values + first);
    return;
  }
  float lanes[MULTUM_VECTOR_WIDTH];
  STORE_V(value, lanes);
  for (int lane = 0; first + lane < sample_count; ++lane) values[first + lane] = lanes[lane];
}
#endif

// One work-item handles MULTUM_VECTOR_WIDTH sample points. The global size is sample_count divided by
// MULTUM_VECTOR_WIDTH, rounded up.
//   lobes      [sample][lobe]   (a r_x, a r_y, a r_z, a), already filtered; with MULTUM_PLANAR as in gmm_shading.clh
//   half_vectors [half_count]   unit vectors; w: 1 + the index of the light whose cosine multiplies the
//                               highlights, or 0 for no cosine
//   lights     [light_count]    unit vectors; w: the mean cosine for without_roughness(), unused with MULTUM_PLANAR
//   highlights [highlight_count]              with MULTUM_PLANAR only the exponent and the total are used
//   values     [highlight_count * half_count + light_count][sample]   written: highlights, then Lambert
// The kernel is compute bound.
__kernel void movmf_shade(__global const float4* lobes, __global const float4* half_vectors,
                          __global const float4* lights, __global const MultumHighlight* highlights,
                          __global float* values, int sample_count, int half_count, int light_count,
                          int highlight_count) {
  const int first = (int)get_global_id(0) * MULTUM_VECTOR_WIDTH;
  if (first >= sample_count) return;
  lobe_v own[MULTUM_LOBES];
  for (int j = 0; j < MULTUM_LOBES; ++j) own[j] = load_lobe(lobes, first, sample_count, j);
  for (int e = 0; e < highlight_count; ++e) {
    SHAPE shapes[MULTUM_LOBES];
    for (int j = 0; j < MULTUM_LOBES; ++j) shapes[j] = SHAPE_OF(own[j], highlights[e].exponent);
    for (int d = 0; d < half_count; ++d) {
      const float4 h = half_vectors[d];
      const int is_lit = h.w != 0.0f;
      real_v sum = 0.0f;
#if HAS_TERMS
      if (highlights[e].term_count > 0) {
        for (int j = 0; j < MULTUM_LOBES; ++j)
          sum += is_lit ? lit_terms(own[j], highlights + e, h.xyz, lights[(int)h.w - 1])
                        : shade_terms(own[j], highlights + e, one_minus_cosine(own[j], h.xyz));
        store_value(sum, values, first, sample_count);
        values += sample_count;
        continue;
      }
#endif
      for (int j = 0; j < MULTUM_LOBES; ++j) {
        const real_v value = SHADE_HIGHLIGHT(shapes[j], own[j], h.xyz);
        sum += is_lit ? value * lit_cosine(own[j], h.xyz, lights[(int)h.w - 1], FACET_KAPPA(highlights[e].exponent))
                      : value;
      }
      store_value(sum * highlights[e].total, values, first, sample_count);
      values += sample_count;
    }
  }
  for (int d = 0; d < light_count; ++d) {
    real_v sum = 0.0f;
    for (int j = 0; j < MULTUM_LOBES; ++j) sum += SHADE_LAMBERT(own[j], lights[d]);
    store_value(sum, values, first, sample_count);
    values += sample_count;
  }
}
