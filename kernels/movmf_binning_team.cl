// SPDX-License-Identifier: Apache-2.0
// Bins normals in the same way as movmf_binning.cl, and writes the same bytes. This file is for devices whose
// work-items can add to one address and work on a texel as a team (host/formats/opencl/launch_shape.h). It is a
// separate file, because drivers always compile all kernels of a file. It has only a scalar variant.

#include "device/binned_cells.clh"

#ifdef cl_khr_int64_base_atomics
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

static void add_to_cell(__global long* cells, int cell, long4 value) {
  __global long* at = cells + (size_t)cell * MULTUM_CELL_SUMS;
  atom_add((volatile __global long*)at, value.x);
  atom_add((volatile __global long*)(at + 1), value.y);
  atom_add((volatile __global long*)(at + 2), value.z);
  atom_add((volatile __global long*)(at + 3), value.w);
}

// Does the work of movmf_bin_cells with one table per texel. Whole numbers are added atomically, so the order of the
// additions does not matter. One work-item handles strip_rows rows of one column of one texel. The global size is width
// * fit.sample_columns * strip_count. Neighbouring columns are in neighbouring items. Consecutive values for one cell
// are summed first and added once, so that work-items of a flat map do not wait for one another.
//   cells [texel][fit.sample_capacity][MULTUM_CELL_SUMS]   added to
__kernel void movmf_bin_add(__global const float* restrict normal_x, __global const float* restrict normal_y,
                            __global const float* restrict normal_z, __global const float* restrict value_x,
                            __global const float* restrict value_y, __global const float* restrict value_z,
                            __global const float* restrict axes, __global long* cells, MultumMovmfFit fit,
                            int texel_row, int strip_rows, int strip_count, int are_normals) {
  const int item = (int)get_global_id(0);
  const int columns = fit.width * fit.sample_columns;
  const int strip = item / columns, x = item % columns / fit.sample_columns;
  if (strip >= strip_count) return;
  const Covered covered = covered_by(x, texel_row, &fit);
  const int column = covered.first_column + item % columns % fit.sample_columns;
  if (column >= covered.last_column) return;
  __global long* out = cells + (size_t)x * fit.sample_capacity * MULTUM_CELL_SUMS;
  const CellGrid grid = grid_of_texel(axes, x);
  const int first_row = max(covered.first_row, fit.map_first_row) + strip * strip_rows;
  const int last_row = min(min(covered.last_row, fit.map_first_row + fit.map_window_rows), first_row + strip_rows);
  long4 sum = (long4)(0);
  int cell_of_sum = -1;
  for (int row = first_row; row < last_row; ++row) {
    const size_t source = (size_t)(row - fit.map_first_row) * fit.map_width + column;
    float weight = FIXED_POINT;
#if MULTUM_WEIGHTED
    const float row_weight = coverage(row, texel_row, fit.map_height, fit.height);
    weight *= row_weight * coverage(column, x, fit.map_width, fit.width);
#endif
    const int cell = cell_of_normal(normal_x[source], normal_y[source], normal_z[source], grid, &fit);
    const long4 value = cell_value(value_x[source], value_y[source], value_z[source], weight, &fit, are_normals);
    if (cell != cell_of_sum) {
      if (cell_of_sum >= 0) add_to_cell(out, cell_of_sum, sum);
      cell_of_sum = cell;
      sum = (long4)(0);
    }
    sum += value;
  }
  if (cell_of_sum >= 0) add_to_cell(out, cell_of_sum, sum);
}
#endif

// Does the work of movmf_bin_means with a team of MULTUM_TEAM work-items per texel, and writes the same bytes. Each
// member packs one cell. The cell's place is the number of earlier cells that are not empty. The local size is
// MULTUM_TEAM, and the global size is MULTUM_TEAM * texel_count.
__attribute__((reqd_work_group_size(MULTUM_TEAM, 1, 1))) __kernel void movmf_bin_team_means(
    __global const long* cells, __global float* samples, __global int* sample_counts, int texel_count, int chunk_count,
    int cell_count, int are_normals) {
  __local int holds[MULTUM_TEAM];
  const int texel = (int)get_group_id(0), member = (int)get_local_id(0);
  if (texel >= texel_count) return;
  __global const long* in = cells + (size_t)texel * chunk_count * cell_count * MULTUM_CELL_SUMS;
  __global float* out = samples + (size_t)texel * cell_count * MULTUM_CONDENSED_SAMPLE;
  int count = 0;
  for (int block = 0; block < cell_count; block += MULTUM_TEAM) {
    const int cell = block + member;
    const float4 mean =
        cell < cell_count ? mean_of_cell(in, cell, cell_count, chunk_count, are_normals) : (float4)(0.0f);
    holds[member] = mean.w > 0.0f ? 1 : 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    int place = count;
    for (int i = 0; i < MULTUM_TEAM; ++i) {
      place += i < member ? holds[i] : 0;
      count += holds[i];
    }
    if (mean.w > 0.0f) vstore4(mean, place, out);
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  if (member == 0) sample_counts[texel] = count;
}
