// SPDX-License-Identifier: Apache-2.0
// Before a launch of EM: where each texel's lobes start, what its neighbours say, and its normals side by side.
// Alignment after Han et al. 2007, section 7.2, in the order of docs/ALGORITHMS.md, "Order".

#include "device/texel_coverage.clh"
#include "device/vmf.clh"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif
// Finest texels that only lie partly in a texel get fractional weights (maps that are no powers of two).
#ifndef MULTUM_WEIGHTED
#define MULTUM_WEIGHTED 0
#endif

// The four colours (x & 1, y & 1) in the order in which they are fitted: diagonal neighbours first.
static int colour_rank(int x, int y) {
  const int colour = (x & 1) | ((y & 1) << 1);
  return colour == 0 ? 0 : colour == 3 ? 1 : colour == 1 ? 2 : 3;
}

static int fitted_before(int other_x, int other_y, int x, int y, int order) {
  if (order == MULTUM_ORDER_AGAIN) return 1;
  if (order == MULTUM_ORDER_SCANLINE) return other_y < y || (other_y == y && other_x < x);
  return colour_rank(other_x, other_y) < colour_rank(x, y);
}

// Where position i of a row or column of `size` texels is, or -1. Two texels across are neighbours once.
static int neighbour(int i, int size, int periodic) {
  if (i >= 0 && i < size) return i;
  return periodic && size > 2 ? (i < 0 ? size - 1 : 0) : -1;
}

// a_k mu_k of one done neighbour. Its r is never zero: a lobe without a direction keeps its last one.
static float3 directed_amplitude(MultumVmfLobe lobe) {
  const float3 r = (float3)(lobe.mean_x, lobe.mean_y, lobe.mean_z);
  const float squared = fma(r.x, r.x, fma(r.y, r.y, r.z * r.z));
  return squared > 1e-24f ? r * (lobe.amplitude / sqrt(squared)) : (float3)(0.0f);
}

// movmf_start: one work-item = one lobe of one slot; global size MULTUM_LOBES * slot_count.
//   parent  [lobe][parent_height * parent_width]   not read when parent_width == 0
//   level   [lobe][height * width]                 done neighbours; the texel's own lobes when there is no parent
//   texel_list [list_offset + slot]                y * width + x, or -1
//   start   [group][lobe][MULTUM_START_PLANES][MULTUM_GROUP]
// Bound by memory latency: ten scattered reads an item.
__kernel void movmf_start(__global const MultumVmfLobe* parent, __global const MultumVmfLobe* level,
                          __global const int* texel_list, __global float* start, MultumMovmfFit fit,
                          float start_kappa_factor, float start_amplitude_min) {
  const int item = (int)get_global_id(0);
  const int slot = item / MULTUM_LOBES;
  const int lobe = item % MULTUM_LOBES;
  if (slot >= fit.slot_count) return;
  const int texel = texel_list[fit.list_offset + slot];
  const int x = max(texel, 0) % fit.width, y = max(texel, 0) / fit.width;
  const size_t level_size = (size_t)fit.width * fit.height;
  const bool has_parent = fit.parent_width > 0;

  MultumVmfLobe from;
  float3 prior = (float3)(0.0f);
  __global const MultumVmfLobe* own = level + lobe * level_size;
  if (has_parent) {
    const int parent_x = min(x >> 1, fit.parent_width - 1), parent_y = min(y >> 1, fit.parent_height - 1);
    from = parent[(size_t)lobe * fit.parent_width * fit.parent_height + (size_t)parent_y * fit.parent_width + parent_x];
    prior = directed_amplitude(from);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int nx = neighbour(x + dx, fit.width, fit.periodic_x), ny = neighbour(y + dy, fit.height, fit.periodic_y);
        if ((dx == 0 && dy == 0) || nx < 0 || ny < 0) continue;
        if (fitted_before(nx, ny, x, y, fit.order)) prior += directed_amplitude(own[(size_t)ny * fit.width + nx]);
      }
    prior *= fit.alignment;
    if (fit.order == MULTUM_ORDER_AGAIN) from = own[(size_t)y * fit.width + x];
  } else {
    from = own[(size_t)y * fit.width + x];
  }

  const float squared = fma(from.mean_x, from.mean_x, fma(from.mean_y, from.mean_y, from.mean_z * from.mean_z));
  const bool directed = squared > 1e-24f;
  const float length = min(sqrt(squared), 1.0f);
  const float inverse = directed ? 1.0f / sqrt(squared) : 0.0f;
  float kappa = kappa_of_mean_length(length, max(1.0f - length, 1e-6f));
  float amplitude = from.amplitude;
  if (has_parent && fit.order != MULTUM_ORDER_AGAIN) {
    kappa *= start_kappa_factor;
    amplitude = max(amplitude, start_amplitude_min);
  }
  kappa = clamp(kappa, 0.05f, 1e6f);
  __global float* out = start +
                        (((size_t)(slot / MULTUM_GROUP) * MULTUM_LOBES + lobe) * MULTUM_START_PLANES) * MULTUM_GROUP +
                        slot % MULTUM_GROUP;
  out[(MULTUM_START_MU + 0) * MULTUM_GROUP] = from.mean_x * inverse;
  out[(MULTUM_START_MU + 1) * MULTUM_GROUP] = from.mean_y * inverse;
  out[(MULTUM_START_MU + 2) * MULTUM_GROUP] = directed ? from.mean_z * inverse : 1.0f;
  out[MULTUM_START_SHARPNESS * MULTUM_GROUP] = kappa * MULTUM_LOG2E;
  out[MULTUM_START_LOG * MULTUM_GROUP] = log_peak(max(amplitude, 1e-6f), kappa);
  out[(MULTUM_START_PRIOR + 0) * MULTUM_GROUP] = prior.x;
  out[(MULTUM_START_PRIOR + 1) * MULTUM_GROUP] = prior.y;
  out[(MULTUM_START_PRIOR + 2) * MULTUM_GROUP] = prior.z;
}

// movmf_pack: the normals of 16 texels side by side, so that EM streams them once an iteration.
// One work-item = one row of samples of one group; global size sample_rows * slot_count / MULTUM_GROUP.
//   normal_x, normal_y, normal_z [map_height * map_width]
//   samples [group][sample][3, or 4 with the weight][MULTUM_GROUP]
//   sample_counts [group]
// Samples that no finest texel stands for (narrower texels, unused slots) repeat one and weigh 0. Memory bound.
__kernel void movmf_pack(__global const float* normal_x, __global const float* normal_y, __global const float* normal_z,
                         __global const int* texel_list, __global float* samples, __global int* sample_counts,
                         MultumMovmfFit fit) {
  const int item = (int)get_global_id(0);
  const int group = item / fit.sample_rows;
  const int row = item % fit.sample_rows;
  if (group * MULTUM_GROUP >= fit.slot_count) return;
  const int planes = 3 + MULTUM_WEIGHTED;
  if (row == 0) sample_counts[group] = fit.sample_columns * fit.sample_rows;
  __global float* out = samples + ((size_t)group * fit.sample_rows + row) * fit.sample_columns * planes * MULTUM_GROUP;
  for (int lane = 0; lane < MULTUM_GROUP; ++lane) {
    const int texel = max(texel_list[fit.list_offset + group * MULTUM_GROUP + lane], 0);
    const int x = texel % fit.width, y = texel / fit.width;
    const int first_column = first_covered(x, fit.map_width, fit.width);
    const int first_row = first_covered(y, fit.map_height, fit.height);
    const int map_row = min(first_row + row, fit.map_height - 1);
    const size_t row_start = (size_t)map_row * fit.map_width;
#if MULTUM_WEIGHTED
    const float row_weight = coverage(first_row + row, y, fit.map_height, fit.height);
#endif
    for (int i = 0; i < fit.sample_columns; ++i) {
      const size_t source = row_start + min(first_column + i, fit.map_width - 1);
      __global float* sample = out + (size_t)i * planes * MULTUM_GROUP + lane;
      sample[0 * MULTUM_GROUP] = normal_x[source];
      sample[1 * MULTUM_GROUP] = normal_y[source];
      sample[2 * MULTUM_GROUP] = normal_z[source];
#if MULTUM_WEIGHTED
      sample[3 * MULTUM_GROUP] = row_weight * coverage(first_column + i, x, fit.map_width, fit.width);
#endif
    }
  }
}
