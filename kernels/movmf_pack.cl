// SPDX-License-Identifier: Apache-2.0
// Packs the samples of 16 texels next to each other before an EM launch. The samples come from the map or from binned
// normals. The kernels do not depend on the number of lobes. This file has only a scalar variant.

#include "device/level_window.clh"
#include "device/movmf_em.clh"
#include "device/texel_coverage.clh"
#include "shared/movmf_fit.h"

// The value is 1 if finest texels that are only partly inside a texel get fractional weights. This is the case for maps
// whose sides are not powers of two.
#ifndef MULTUM_WEIGHTED
#define MULTUM_WEIGHTED 0
#endif

// Packs the normals of 16 texels next to each other, so that EM streams them once per iteration.
// One work-item handles one row of samples of one group. The global size is sample_rows * slot_count / MULTUM_GROUP.
//   normal_x, normal_y, normal_z [map_window_rows * map_width]
//   samples [group][sample][3, or 4 with the weight][MULTUM_GROUP]
//   sample_counts [group]
// Samples without a finest texel (in narrower texels and unused slots) repeat another sample with weight 0. Memory
// bound.
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
    const int texel = max(texel_list[group * MULTUM_GROUP + lane], 0);
    const int x = texel_column(texel, &fit), y = texel_row(texel, &fit);
    const int first_column = first_covered(x, fit.map_width, fit.width);
    const int first_row = first_covered(y, fit.map_height, fit.height);
    const int map_row = min(first_row + row, fit.map_height - 1);
    const size_t row_start = map_row_start(map_row, &fit);
#if MULTUM_WEIGHTED
    const float row_weight = coverage(first_row + row, y, fit.map_height, fit.height);
#endif
    for (int i = 0; i < fit.sample_columns; ++i) {
      const size_t source = row_start + min(first_column + i, fit.map_width - 1);
      __global float* sample = out + (size_t)i * planes * MULTUM_GROUP + lane;
      float nx = normal_x[source], ny = normal_y[source], nz = normal_z[source];
      TO_SAMPLE(float, nx, ny, nz, fit.shortened)
      sample[0 * MULTUM_GROUP] = nx;
      sample[1 * MULTUM_GROUP] = ny;
      sample[2 * MULTUM_GROUP] = nz;
#if MULTUM_WEIGHTED
      sample[3 * MULTUM_GROUP] = row_weight * coverage(first_column + i, x, fit.map_width, fit.width);
#endif
    }
  }
}

// Packs binned normals in the same way. One work-item handles one of part_count parts of the samples of one group of
// slots, which is every part_count-th sample. The global size is slot_count / MULTUM_GROUP * part_count.
//   binned [texel of the window][fit.sample_capacity][MULTUM_CONDENSED_SAMPLE]
//   binned_counts [texel of the window]
//   samples [group][sample][4][MULTUM_GROUP]   written
//   sample_counts [group]                      written: the largest count of the texels; missing samples weigh 0
// The kernel is memory bound.
__kernel void movmf_binned_pack(__global const float* binned, __global const int* binned_counts,
                                __global const int* texel_list, __global float* samples, __global int* sample_counts,
                                MultumMovmfFit fit, int part_count) {
  const int group = (int)get_global_id(0) / part_count, part = (int)get_global_id(0) % part_count;
  if (group * MULTUM_GROUP >= fit.slot_count) return;
  __global float* out = samples + (size_t)group * fit.sample_capacity * 4 * MULTUM_GROUP;
  __global const int* texels = texel_list + group * MULTUM_GROUP;
  int most = 1;
  for (int lane = 0; lane < MULTUM_GROUP; ++lane)
    if (texels[lane] >= 0) most = max(most, binned_counts[texels[lane]]);
  for (int lane = 0; lane < MULTUM_GROUP; ++lane) {
    const int count = texels[lane] < 0 ? 0 : binned_counts[texels[lane]];
    __global const float* in = binned + (size_t)max(texels[lane], 0) * fit.sample_capacity * MULTUM_CONDENSED_SAMPLE;
    for (int i = part; i < most; i += part_count) {
      const float4 sample = i < count ? vload4(i, in) : (float4)(0.0f, 0.0f, 1.0f, 0.0f);
      __global float* to = out + (size_t)i * 4 * MULTUM_GROUP + lane;
      to[0] = sample.x;
      to[MULTUM_GROUP] = sample.y;
      to[2 * MULTUM_GROUP] = sample.z;
      to[3 * MULTUM_GROUP] = sample.w;
    }
  }
  if (part == 0) sample_counts[group] = most;
}
