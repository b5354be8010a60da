// SPDX-License-Identifier: Apache-2.0
// Runs EM on fine levels: one work-item runs all iterations of a texel. Han et al. 2007, section 7, Algorithm 1; with
// MULTUM_PLANAR, Tan et al. 2005, section 4.1.
//
// One work-item handles MULTUM_VECTOR_WIDTH texels (16 lanes of one group, or one of them). The local size is 1 or 2 on
// a CPU.
//   samples [group][sample][3, or 4 with the weight][MULTUM_GROUP]     from movmf_pack or movmf_binned_pack
//   sample_counts [group]                                              at most fit.sample_capacity
//   start   [group][lobe][MULTUM_START_PLANES][MULTUM_GROUP]           from movmf_start; on return the parameters of
//                                                                      the last E-step, for movmf_features
//   alignment_vectors [lobe][window_rows * width][4]                   written, for the neighbours' priors
//   level   [lobe][window_rows * width]                                written: r and amplitude of each texel's lobes
// Sums run over the samples in their order, and a texel that has converged keeps its lobes while other texels of its
// group continue. Therefore both variants, and a team (below), write the same bytes. Compute bound: about 26 operations
// per lobe and sample. A texel reads 12 or 16 bytes per sample, from cache after the first iteration.

#include "device/level_window.clh"
#include "device/movmf_em.clh"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_WEIGHTED
#define MULTUM_WEIGHTED 0
#endif
// Lobes below this amplitude are invisible, so they do not delay convergence.
#define UNSEEN_SHARE 1e-3f
#define SAMPLE_STRIDE ((3 + MULTUM_WEIGHTED) * MULTUM_GROUP)
#define START(j, plane) (lobe_start + ((j)*MULTUM_START_PLANES + (plane)) * MULTUM_GROUP)

static void store_texels(__global MultumVmfLobe* level, __global float* alignment_vectors, __global const int* texels,
                         size_t level_size, int lobe, const LobeMoments* m) {
  const LobeLanes stored = stored_lobe(*m), told = told_to_neighbours(stored);
  float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH], a[MULTUM_VECTOR_WIDTH];
  float told_x[MULTUM_VECTOR_WIDTH], told_y[MULTUM_VECTOR_WIDTH], told_z[MULTUM_VECTOR_WIDTH];
  STORE_V(stored.x, x);
  STORE_V(stored.y, y);
  STORE_V(stored.z, z);
  STORE_V(stored.amplitude, a);
  STORE_V(told.x, told_x);
  STORE_V(told.y, told_y);
  STORE_V(told.z, told_z);
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    if (texels[lane] < 0) continue;
    const size_t place = lobe * level_size + texels[lane];
    vstore4((float4)(x[lane], y[lane], z[lane], a[lane]), place, (__global float*)level);
    vstore4((float4)(told_x[lane], told_y[lane], told_z[lane], 0.0f), place, alignment_vectors);
  }
}

__kernel void movmf_em_texels(__global const float* restrict samples, __global const int* restrict sample_counts,
                              __global float* restrict start, __global const int* restrict texel_list,
                              __global MultumVmfLobe* restrict level, __global float* restrict alignment_vectors,
                              MultumMovmfFit fit) {
  const int slot = (int)get_global_id(0) * MULTUM_VECTOR_WIDTH;
  if (slot >= fit.slot_count) return;
  const int group = slot / MULTUM_GROUP, lane = slot % MULTUM_GROUP;
  const int sample_count = sample_counts[group];
  __global const float* first_sample = samples + (size_t)group * fit.sample_capacity * SAMPLE_STRIDE + lane;
  __global float* lobe_start = start + (size_t)group * MULTUM_LOBES * MULTUM_START_PLANES * MULTUM_GROUP + lane;

  real_v mu_x[MULTUM_LOBES], mu_y[MULTUM_LOBES], mu_z[MULTUM_LOBES], sharpness[MULTUM_LOBES], log_weight[MULTUM_LOBES];
  real_v sum_s[MULTUM_LOBES], sum_x[MULTUM_LOBES], sum_y[MULTUM_LOBES], sum_z[MULTUM_LOBES], sum_d[MULTUM_LOBES];
  _Pragma("unroll") for (int j = 0; j < MULTUM_LOBES; ++j) {
    mu_x[j] = LOAD_V(START(j, MULTUM_START_MU));
    mu_y[j] = LOAD_V(START(j, MULTUM_START_MU + 1));
    mu_z[j] = LOAD_V(START(j, MULTUM_START_MU + 2));
    sharpness[j] = LOAD_V(START(j, MULTUM_START_SHARPNESS));
    log_weight[j] = LOAD_V(START(j, MULTUM_START_LOG));
  }
  real_v cap = (real_v)(fit.kappa_cap);
  int_v moving = (real_v)(0.0f) == (real_v)(0.0f);
  for (int iteration = 0; iteration < fit.iteration_count; ++iteration) {
    _Pragma("unroll") for (int j = 0; j < MULTUM_LOBES; ++j) sum_s[j] = sum_x[j] = sum_y[j] = sum_z[j] = sum_d[j] =
        (real_v)(0.0f);
    for (int block = 0; block < sample_count; block += SAMPLE_BLOCK) {
      __global const float* block_samples = first_sample + (size_t)block * SAMPLE_STRIDE;
      const int count = min(SAMPLE_BLOCK, sample_count - block);
      real_v responsibility[SAMPLE_BLOCK][MULTUM_LOBES], u[SAMPLE_BLOCK][MULTUM_LOBES];
      for (int i = 0; i < count; ++i) {
        __global const float* sample = block_samples + i * SAMPLE_STRIDE;
        const real_v x = LOAD_V(sample), y = LOAD_V(sample + MULTUM_GROUP), z = LOAD_V(sample + 2 * MULTUM_GROUP);
#if MULTUM_WEIGHTED
        const real_v weight = LOAD_V(sample + 3 * MULTUM_GROUP);
        RESPONSIBILITIES(x, y, z, weight, responsibility[i], u[i])
#else
        RESPONSIBILITIES(x, y, z, WHOLE, responsibility[i], u[i])
#endif
      }
      for (int i = 0; i < count; ++i) {
        __global const float* sample = block_samples + i * SAMPLE_STRIDE;
        const real_v x = LOAD_V(sample), y = LOAD_V(sample + MULTUM_GROUP), z = LOAD_V(sample + 2 * MULTUM_GROUP);
        ADD_MOMENTS(x, y, z, responsibility[i], u[i])
      }
    }
    if (iteration == 0) KAPPA_CAP_OF_TEXEL(cap, (real_v)(fit.total_weight_inverse), fit.kappa_cap, fit.kappa_cap_slope)
    if (iteration + 1 == fit.iteration_count || !ANY_V(moving)) break;
    real_v change = (real_v)(0.0f);
    _Pragma("unroll") for (int j = 0; j < MULTUM_LOBES; ++j) {
      const LobeMoments m = lobe_moments(sum_s[j], sum_x[j], sum_y[j], sum_z[j], sum_d[j], mu_x[j], mu_y[j], mu_z[j],
                                         (real_v)(fit.total_weight_inverse));
      const real_v prior_x = LOAD_V(START(j, MULTUM_START_PRIOR));
      const real_v prior_y = LOAD_V(START(j, MULTUM_START_PRIOR + 1));
      const real_v prior_z = LOAD_V(START(j, MULTUM_START_PRIOR + 2));
      real_v next_x, next_y, next_z, next_sharpness = sharpness[j], next_log;
      M_STEP(m, prior_x, prior_y, prior_z, cap, fit.extra_copies, next_x, next_y, next_z, next_sharpness, next_log)
      // Computes the squares of three changes. These are the change of the mean in units of the lobe's width, and the
      // relative changes of kappa and of the weight.
      const real_v dx = next_x - mu_x[j], dy = next_y - mu_y[j], dz = next_z - mu_z[j];
      const real_v turn = fma(dx, dx, fma(dy, dy, dz * dz)) * next_sharpness;
      const real_v dl = next_log - log_weight[j], dk = 1.0f - sharpness[j] / next_sharpness;
      const real_v most = MAX_V(turn, MAX_V(dl * dl, dk * dk));
      change = m.amplitude > UNSEEN_SHARE ? MAX_V(change, most) : change;
      mu_x[j] = moving ? next_x : mu_x[j];
      mu_y[j] = moving ? next_y : mu_y[j];
      mu_z[j] = moving ? next_z : mu_z[j];
      sharpness[j] = moving ? next_sharpness : sharpness[j];
      log_weight[j] = moving ? next_log : log_weight[j];
    }
    if (fit.convergence_tolerance_squared > 0.0f) moving = moving & (change > fit.convergence_tolerance_squared);
  }
  // The moments of the last E-step are stored without the prior. The prior thus determines which lobe is which, but
  // adds no bias.
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    const LobeMoments m = lobe_moments(sum_s[j], sum_x[j], sum_y[j], sum_z[j], sum_d[j], mu_x[j], mu_y[j], mu_z[j],
                                       (real_v)(fit.total_weight_inverse));
    store_texels(level, alignment_vectors, texel_list + slot, level_window_size(&fit), j, &m);
    STORE_V(mu_x[j], START(j, MULTUM_START_MU));
    STORE_V(mu_y[j], START(j, MULTUM_START_MU + 1));
    STORE_V(mu_z[j], START(j, MULTUM_START_MU + 2));
    STORE_V(sharpness[j], START(j, MULTUM_START_SHARPNESS));
    STORE_V(log_weight[j], START(j, MULTUM_START_LOG));
  }
}

#if MULTUM_VECTOR_WIDTH == 1
// Runs EM of one texel with a team of MULTUM_TEAM work-items, for devices with more work-items than a step has texels.
// Each member does one sample's E-step. Then each of the first 5 MULTUM_LOBES members adds the samples, in order, to
// one sum of one lobe. Then each of the first MULTUM_LOBES members does one lobe's M-step. The kernel writes the same
// bytes as movmf_em_texels.
//
//   samples   0 1 2 ... 63 | 64 65 ...          one block per turn of the team
//   member    0 1 2 ... 63                      E-step: responsibilities and gaps of its sample, to local memory
//   member    S0 X0 Y0 Z0 D0 S1 X1 ...          sums: member 5 j + k adds sum k of lobe j
//
// Buffers as above; local size MULTUM_TEAM, global size MULTUM_TEAM * slot_count. Bound by the chain of additions in
// each sum, which takes four clocks per sample. A single work-item would need about a hundred clocks per sample.
#define TEAM_ROW (MULTUM_TEAM + 1)  // puts lobes into different memory banks

// For member 5 j + k, returns the factors by which responsibilities are multiplied in sum k of lobe j. The factor is 1,
// x, y, z or the gap u.
static __local const float* factors_of_sum(__local const float* one, __local const float* directions,
                                           __local const float* gaps, int lobe, int sum) {
  return sum == 0 ? one : sum < 4 ? directions + (sum - 1) * TEAM_ROW : gaps + lobe * TEAM_ROW;
}

__attribute__((reqd_work_group_size(MULTUM_TEAM, 1, 1))) __kernel void movmf_em_team(
    __global const float* restrict samples, __global const int* restrict sample_counts, __global float* restrict start,
    __global const int* restrict texel_list, __global MultumVmfLobe* restrict level,
    __global float* restrict alignment_vectors, MultumMovmfFit fit) {
  __local float shares[MULTUM_LOBES * TEAM_ROW], gaps[MULTUM_LOBES * TEAM_ROW], directions[3 * TEAM_ROW], one[1];
  __local float lobe_state[MULTUM_LOBES * 5], sums[MULTUM_LOBES * 5], moved[MULTUM_LOBES];
  const int slot = (int)get_group_id(0), member = (int)get_local_id(0);
  // Every member of a team takes the same path to the barriers below.
  if (slot >= fit.slot_count) return;
  const int group = slot / MULTUM_GROUP, lane = slot % MULTUM_GROUP;
  const int sample_count = sample_counts[group];
  __global const float* first_sample = samples + (size_t)group * fit.sample_capacity * SAMPLE_STRIDE + lane;
  __global float* lobe_start = start + (size_t)group * MULTUM_LOBES * MULTUM_START_PLANES * MULTUM_GROUP + lane;

  if (member == 0) one[0] = 1.0f;
  if (member < MULTUM_LOBES) {
    for (int k = 0; k < 3; ++k) lobe_state[member * 5 + k] = *START(member, MULTUM_START_MU + k);
    lobe_state[member * 5 + 3] = *START(member, MULTUM_START_SHARPNESS);
    lobe_state[member * 5 + 4] = *START(member, MULTUM_START_LOG);
  }
  const int sums_lobe = min(member / 5, MULTUM_LOBES - 1), sums_kind = member % 5;
  const bool adds = member < 5 * MULTUM_LOBES;
  __local const float* share = shares + sums_lobe * TEAM_ROW;
  __local const float* factor = factors_of_sum(one, directions, gaps, sums_lobe, sums_kind);
  const int factor_step = sums_kind == 0 ? 0 : 1;

  float mu_x[MULTUM_LOBES], mu_y[MULTUM_LOBES], mu_z[MULTUM_LOBES], sharpness[MULTUM_LOBES], log_weight[MULTUM_LOBES];
  float cap = fit.kappa_cap;
  int last = fit.iteration_count - 1;  // the iteration that ends after its E-step
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int iteration = 0; iteration <= last; ++iteration) {
    _Pragma("unroll") for (int j = 0; j < MULTUM_LOBES; ++j) {
      mu_x[j] = lobe_state[j * 5];
      mu_y[j] = lobe_state[j * 5 + 1];
      mu_z[j] = lobe_state[j * 5 + 2];
      sharpness[j] = lobe_state[j * 5 + 3];
      log_weight[j] = lobe_state[j * 5 + 4];
    }
    float sum = 0.0f;
    for (int block = 0; block < sample_count; block += MULTUM_TEAM) {
      const int count = min(MULTUM_TEAM, sample_count - block);
      if (member < count) {
        __global const float* sample = first_sample + (size_t)(block + member) * SAMPLE_STRIDE;
        const float x = sample[0], y = sample[MULTUM_GROUP], z = sample[2 * MULTUM_GROUP];
        float responsibility[MULTUM_LOBES], u[MULTUM_LOBES];
#if MULTUM_WEIGHTED
        const float weight = sample[3 * MULTUM_GROUP];
        RESPONSIBILITIES(x, y, z, weight, responsibility, u)
#else
        RESPONSIBILITIES(x, y, z, WHOLE, responsibility, u)
#endif
        directions[member] = x;
        directions[TEAM_ROW + member] = y;
        directions[2 * TEAM_ROW + member] = z;
        _Pragma("unroll") for (int j = 0; j < MULTUM_LOBES; ++j) {
          shares[j * TEAM_ROW + member] = responsibility[j];
          gaps[j * TEAM_ROW + member] = u[j];
        }
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      if (adds)
        for (int i = 0; i < count; ++i) sum = fma(share[i], factor[i * factor_step], sum);
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    if (adds) sums[member] = sum;
    barrier(CLK_LOCAL_MEM_FENCE);
    float sum_s[MULTUM_LOBES], sum_x[MULTUM_LOBES], sum_y[MULTUM_LOBES], sum_z[MULTUM_LOBES], sum_d[MULTUM_LOBES];
    _Pragma("unroll") for (int j = 0; j < MULTUM_LOBES; ++j) {
      sum_s[j] = sums[j * 5];
      sum_x[j] = sums[j * 5 + 1];
      sum_y[j] = sums[j * 5 + 2];
      sum_z[j] = sums[j * 5 + 3];
      sum_d[j] = sums[j * 5 + 4];
    }
    if (iteration == 0) KAPPA_CAP_OF_TEXEL(cap, fit.total_weight_inverse, fit.kappa_cap, fit.kappa_cap_slope)
    if (iteration < last && member < MULTUM_LOBES) {
      // Each of the first members of the team handles one lobe. The lobe is read from local memory, because registers
      // cannot be indexed.
      __local float* own = lobe_state + member * 5;
      __local const float* added = sums + member * 5;
      const float old_x = own[0], old_y = own[1], old_z = own[2], old_sharpness = own[3], old_log = own[4];
      const LobeMoments m =
          lobe_moments(added[0], added[1], added[2], added[3], added[4], old_x, old_y, old_z, fit.total_weight_inverse);
      float next_x, next_y, next_z, next_sharpness = old_sharpness, next_log;
      M_STEP(m, *START(member, MULTUM_START_PRIOR), *START(member, MULTUM_START_PRIOR + 1),
             *START(member, MULTUM_START_PRIOR + 2), cap, fit.extra_copies, next_x, next_y, next_z, next_sharpness,
             next_log)
      const float dx = next_x - old_x, dy = next_y - old_y, dz = next_z - old_z;
      const float turn = fma(dx, dx, fma(dy, dy, dz * dz)) * next_sharpness;
      const float dl = next_log - old_log, dk = 1.0f - old_sharpness / next_sharpness;
      moved[member] = m.amplitude > UNSEEN_SHARE ? MAX_V(turn, MAX_V(dl * dl, dk * dk)) : -1.0f;
      own[0] = next_x;
      own[1] = next_y;
      own[2] = next_z;
      own[3] = next_sharpness;
      own[4] = next_log;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (iteration < last && fit.convergence_tolerance_squared > 0.0f) {
      float change = 0.0f;
      for (int j = 0; j < MULTUM_LOBES; ++j) change = moved[j] < 0.0f ? change : MAX_V(change, moved[j]);
      // After convergence, does the E-step once more, as movmf_em_texels does.
      if (!(change > fit.convergence_tolerance_squared)) last = iteration + 1;
    }
  }
  if (member >= MULTUM_LOBES) return;
  __local const float* own = lobe_state + member * 5;
  __local const float* added = sums + member * 5;
  const LobeMoments m =
      lobe_moments(added[0], added[1], added[2], added[3], added[4], own[0], own[1], own[2], fit.total_weight_inverse);
  store_texels(level, alignment_vectors, texel_list + slot, level_window_size(&fit), member, &m);
  for (int k = 0; k < 3; ++k) *START(member, MULTUM_START_MU + k) = own[k];
  *START(member, MULTUM_START_SHARPNESS) = own[3];
  *START(member, MULTUM_START_LOG) = own[4];
}
#endif
