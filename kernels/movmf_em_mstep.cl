// SPDX-License-Identifier: Apache-2.0
// Does the second half of an EM iteration on coarse levels (Han et al. 2007, section 7, equation 16). It adds the
// partial sums of movmf_em_partial and does the M-step. Both variants are scalar, because there is little work.

#include "device/level_window.clh"
#include "device/movmf_em.clh"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "movmf_em_mstep has only a scalar variant"
#endif
#define PARTIAL_SUMS 5

// Sums one lobe over the chunks of a texel.
static void sum_chunks(__global const float* chunks, int lobe, int chunk_count, float* sum) {
  float carry[PARTIAL_SUMS] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  for (int k = 0; k < PARTIAL_SUMS; ++k) sum[k] = 0.0f;
  for (int chunk = 0; chunk < chunk_count; ++chunk) {
    __global const float* in = chunks + ((size_t)chunk * MULTUM_LOBES + lobe) * PARTIAL_SUMS;
    for (int k = 0; k < PARTIAL_SUMS; ++k) add_compensated(&sum[k], &carry[k], in[k]);
  }
  for (int k = 0; k < PARTIAL_SUMS; ++k) sum[k] += carry[k];
}

#if MULTUM_PLANAR
// movmf_em_cap computes the caps of texels' kappas after the first E-step. It runs before any M-step, because the caps
// need the means of all lobes. One work-item handles one slot. The global size is slot_count. The kernel is memory
// bound.
__kernel void movmf_em_cap(__global const float* restrict partial, __global float* restrict start,
                           __global const int* restrict texel_list, MultumMovmfFit fit) {
  const int slot = (int)get_global_id(0);
  if (slot >= fit.slot_count || texel_list[slot] < 0) return;
  __global float* p =
      start + (size_t)(slot / MULTUM_GROUP) * MULTUM_LOBES * MULTUM_START_PLANES * MULTUM_GROUP + slot % MULTUM_GROUP;
#define LOBE_PLANE(j, plane) p[((j)*MULTUM_START_PLANES + (plane)) * MULTUM_GROUP]
  float sum_s[MULTUM_LOBES], sum_x[MULTUM_LOBES], sum_y[MULTUM_LOBES], sum_d[MULTUM_LOBES];
  float mu_x[MULTUM_LOBES], mu_y[MULTUM_LOBES], cap;
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    float sum[PARTIAL_SUMS];
    sum_chunks(partial + (size_t)slot * fit.chunk_count * MULTUM_LOBES * PARTIAL_SUMS, j, fit.chunk_count, sum);
    sum_s[j] = sum[0];
    sum_x[j] = sum[1];
    sum_y[j] = sum[2];
    sum_d[j] = sum[4];
    mu_x[j] = LOBE_PLANE(j, MULTUM_START_MU);
    mu_y[j] = LOBE_PLANE(j, MULTUM_START_MU + 1);
  }
  KAPPA_CAP_OF_TEXEL(cap, fit.total_weight_inverse, fit.kappa_cap, fit.kappa_cap_slope)
  for (int j = 0; j < MULTUM_LOBES; ++j) LOBE_PLANE(j, MULTUM_START_CAP) = cap;
}
#else
// Returns the cap of one texel's kappas, from all lobes of all chunks together.
static float cap_of_chunks(__global const float* chunks, const MultumMovmfFit* fit) {
  float sum[3] = {0.0f, 0.0f, 0.0f}, carry[3] = {0.0f, 0.0f, 0.0f};
  for (int i = 0; i < fit->chunk_count * MULTUM_LOBES; ++i)
    for (int k = 0; k < 3; ++k) add_compensated(&sum[k], &carry[k], chunks[i * PARTIAL_SUMS + 1 + k]);
  return kappa_cap_of_texel(sum[0] + carry[0], sum[1] + carry[1], sum[2] + carry[2], fit->total_weight_inverse,
                            fit->kappa_cap, fit->kappa_cap_slope);
}
#endif

// One work-item handles one lobe of one slot. The global size is MULTUM_LOBES * slot_count.
//   partial [slot][chunk][lobe][PARTIAL_SUMS]
//   start   [group][lobe][MULTUM_START_PLANES][MULTUM_GROUP]  in: parameters of this E-step; out: of the next E-step
//   level   [lobe][window_rows * width]                       written in the last iteration, which keeps `start`
//   alignment_vectors [lobe][window_rows * width][4]          written in the last iteration, for the neighbours' priors
// Sums of up to 2^16 chunks are compensated, so their rounding error is as small as for one addition. Memory bound.
__kernel void movmf_em_mstep(__global const float* restrict partial, __global float* restrict start,
                             __global const int* restrict texel_list, __global MultumVmfLobe* restrict level,
                             __global float* restrict alignment_vectors, MultumMovmfFit fit, int iteration) {
  const int item = (int)get_global_id(0);
  const int slot = item / MULTUM_LOBES, lobe = item % MULTUM_LOBES;
  if (slot >= fit.slot_count) return;
  const int texel = texel_list[slot];
  if (texel < 0) return;

  __global float* p = start +
                      ((size_t)(slot / MULTUM_GROUP) * MULTUM_LOBES + lobe) * MULTUM_START_PLANES * MULTUM_GROUP +
                      slot % MULTUM_GROUP;
#define PLANE(plane) p[(plane)*MULTUM_GROUP]
  __global const float* chunks = partial + (size_t)slot * fit.chunk_count * MULTUM_LOBES * PARTIAL_SUMS;
#if !MULTUM_PLANAR
  if (iteration == 0) PLANE(MULTUM_START_CAP) = cap_of_chunks(chunks, &fit);
#endif
  float sum[PARTIAL_SUMS];
  sum_chunks(chunks, lobe, fit.chunk_count, sum);

  const LobeMoments m = lobe_moments(sum[0], sum[1], sum[2], sum[3], sum[4], PLANE(MULTUM_START_MU),
                                     PLANE(MULTUM_START_MU + 1), PLANE(MULTUM_START_MU + 2), fit.total_weight_inverse);
  if (iteration + 1 == fit.iteration_count) {
    const LobeLanes stored = stored_lobe(m), told = told_to_neighbours(stored);
    const size_t place = lobe * level_window_size(&fit) + texel;
    vstore4((float4)(stored.x, stored.y, stored.z, stored.amplitude), place, (__global float*)level);
    vstore4((float4)(told.x, told.y, told.z, 0.0f), place, alignment_vectors);
    return;
  }
  float mu_x, mu_y, mu_z, log_weight;
  float sharpness = PLANE(MULTUM_START_SHARPNESS);
  M_STEP(m, PLANE(MULTUM_START_PRIOR), PLANE(MULTUM_START_PRIOR + 1), PLANE(MULTUM_START_PRIOR + 2),
         PLANE(MULTUM_START_CAP), fit.extra_copies, mu_x, mu_y, mu_z, sharpness, log_weight)
  PLANE(MULTUM_START_MU) = mu_x;
  PLANE(MULTUM_START_MU + 1) = mu_y;
  PLANE(MULTUM_START_MU + 2) = mu_z;
  PLANE(MULTUM_START_SHARPNESS) = sharpness;
  PLANE(MULTUM_START_LOG) = log_weight;
}
