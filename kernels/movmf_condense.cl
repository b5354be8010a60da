// SPDX-License-Identifier: Apache-2.0
// The normals of a coarse texel, condensed: sorted into the cells of a grid over directions, each cell a sample of EM
// with the number of its normals as weight and their mean vector as normal. Cells are so much smaller than lobes that
// EM does the same with some thousand of them as with all normals, and first moments stay exact. docs/ALGORITHMS.md,
// "Condensed normals".
//
// Directions lie at p = (x, y) / sqrt(1 + z), Lambert's equal-area disc. Each axis of p has its own map to cells, by
// three quarters from how many normals lie where and by a quarter from their extent: a few steep edges do not coarsen
// the cells of a flat texel. What lies outside the axes belongs to the outermost cells.
//
// Normals that a BRDF's width has shortened (MovmfFit::shortened) lie by their directions, in a grid of their own for
// each class of lengths: sharp and wide BRDFs under one texel are what lobes are to tell apart. Classes end at kappa
// 1250, 133 and 22, that is at a perceptual roughness of 0.2, 0.35 and 0.55, so that the kappas of a class differ by 9
// at most but for the sharpest, whose widths hardly show.
//
// The map streams by in bands of rows. Sums are whole numbers of 2^-30, so that no order of bands, chunks or threads
// can be seen in them, and nothing is rounded away that thousands of nearly equal normals differ by: 2^28 of them add
// up to 2^58 at most. A launch is for the texels of one row of a level. This file has only a scalar variant.

#include "device/level_window.clh"
#include "device/planar_sample.clh"
#include "device/texel_coverage.clh"
#include "shared/movmf_fit.h"

#ifndef MULTUM_WEIGHTED
#define MULTUM_WEIGHTED 0
#endif

#ifndef MULTUM_PLANAR
#define MULTUM_PLANAR 0
#endif

#define FIXED_POINT 1073741824.0f  // 2^30
#define FIXED_POINT_INVERSE (1.0f / FIXED_POINT)
#define CELL_BLOCK 64

static float2 equal_area(float x, float y, float z) {
  const float inverse = 1.0f / sqrt(MAX_V(1.0f + z, 1e-6f));
  return (float2)(x * inverse, y * inverse);
}

static float2 place_of_normal(float x, float y, float z, const MultumMovmfFit* fit) {
  const float inverse = fit->shortened ? 1.0f / MAX_V(length_of(x, y, z), 1e-6f) : 1.0f;
  return equal_area(x * inverse, y * inverse, z * inverse);
}

static int length_class(float x, float y, float z) {
  const float spread = 1.0f - length_of(x, y, z);
  return (spread > 1.0f / 1250.0f) + (spread > 1.0f / 133.0f) + (spread > 1.0f / 22.0f);
}

typedef struct Covered {
  int first_column, last_column, first_row, last_row;  // last: one past
} Covered;

static Covered covered_by(int x, int y, const MultumMovmfFit* fit) {
  Covered c;
  c.first_column = first_covered(x, fit->map_width, fit->width);
  c.first_row = first_covered(y, fit->map_height, fit->height);
  c.last_column = covered_end(x, fit->map_width, fit->width);
  c.last_row = covered_end(y, fit->map_height, fit->height);
  return c;
}

// Part `index` of `count` parts of a range of `size`: one place in it, by chance, so that a pattern cannot fall in
// step.
static int place_in_part(int index, int count, int size, uint seed) {
  const int first = (int)((long)index * size / count), last = (int)((long)(index + 1) * size / count);
  uint state = seed * 1664525u + 1013904223u;
  state = (state ^ (state >> 15)) * 0x2c1b3c6du;
  state = (state ^ (state >> 12)) * 0x297a2d39u;
  return first + (int)((state >> 8) % (uint)(last - first));
}

// One normal of each of MULTUM_PROBE_SIDE blocks across and down (fewer where there are fewer normals), of those rows
// that are there. One work-item = one row of blocks of one texel; global size width * MULTUM_PROBE_SIDE.
//   normal_x, normal_y, normal_z [map_window_rows * map_width]
//   probes [texel][MULTUM_PROBE_COUNT][2]   written: p
// Bound by memory latency: 32 scattered reads an item.
__kernel void movmf_condense_probe(__global const float* normal_x, __global const float* normal_y,
                                   __global const float* normal_z, __global float* probes, MultumMovmfFit fit,
                                   int texel_row) {
  const int item = (int)get_global_id(0);
  const int texel = item / MULTUM_PROBE_SIDE, j = item % MULTUM_PROBE_SIDE;
  if (texel >= fit.width) return;
  const Covered covered = covered_by(texel, texel_row, &fit);
  const int columns = covered.last_column - covered.first_column, rows = covered.last_row - covered.first_row;
  const int across = min(columns, MULTUM_PROBE_SIDE), down = min(rows, MULTUM_PROBE_SIDE);
  if (j >= down) return;
  for (int i = 0; i < across; ++i) {
    const uint block = (uint)(j * MULTUM_PROBE_SIDE + i);
    const int row = covered.first_row + place_in_part(j, down, rows, 2u * block);
    if (!in_map_window(row, &fit)) continue;
    const int column = covered.first_column + place_in_part(i, across, columns, 2u * block + 1u);
    const size_t source = map_row_start(row, &fit) + column;
    vstore2(place_of_normal(normal_x[source], normal_y[source], normal_z[source], &fit),
            (size_t)texel * MULTUM_PROBE_COUNT + j * across + i, probes);
  }
}

// The axes of one texel's grid, from its probes. One work-item = one axis of one texel; global size 2 * width.
//   axes [texel][2][MULTUM_AXIS_FLOATS]  written: the low end, bins a unit of p, and the cell at each bin's edge
__kernel void movmf_condense_axes(__global const float* probes, __global float* axes, MultumMovmfFit fit,
                                  int texel_row) {
  const int item = (int)get_global_id(0);
  const int texel = item / 2, k = item % 2;
  if (texel >= fit.width) return;
  const Covered covered = covered_by(texel, texel_row, &fit);
  const int across = min(covered.last_column - covered.first_column, MULTUM_PROBE_SIDE);
  const int count = across * min(covered.last_row - covered.first_row, MULTUM_PROBE_SIDE);
  __global const float* at = probes + (size_t)texel * MULTUM_PROBE_COUNT * 2 + k;
  float low = 1e30f, high = -1e30f;
  for (int i = 0; i < count; ++i) {
    low = MIN_V(low, at[2 * i]);
    high = MAX_V(high, at[2 * i]);
  }
  const float bins_per_unit = (float)MULTUM_AXIS_BINS / MAX_V(high - low, 1e-6f);
  int numbers[MULTUM_AXIS_BINS];
  for (int b = 0; b < MULTUM_AXIS_BINS; ++b) numbers[b] = 0;
  for (int i = 0; i < count; ++i)
    numbers[clamp((int)((at[2 * i] - low) * bins_per_unit), 0, MULTUM_AXIS_BINS - 1)] += 1;
  __global float* axis = axes + (size_t)item * MULTUM_AXIS_FLOATS;
  axis[0] = low;
  axis[1] = bins_per_unit;
  const float count_inverse = 1.0f / (float)count;
  int below = 0;
  for (int b = 0; b <= MULTUM_AXIS_BINS; ++b) {
    const float by_number = (float)below * count_inverse, by_extent = (float)b * (1.0f / (float)MULTUM_AXIS_BINS);
    axis[2 + b] = (float)fit.cell_side * fma(0.75f, by_number, 0.25f * by_extent);
    if (b < MULTUM_AXIS_BINS) below += numbers[b];
  }
}

static int cell_along(float p, __global const float* axis, int cell_side) {
  const float at = MIN_V(MAX_V((p - axis[0]) * axis[1], 0.0f), (float)MULTUM_AXIS_BINS);
  const int bin = min((int)at, MULTUM_AXIS_BINS - 1);
  const float low = axis[2 + bin];
  return clamp((int)fma(at - (float)bin, axis[3 + bin] - low, low), 0, cell_side - 1);
}

typedef struct CellGrid {
  __global const float* axis_x;
  __global const float* axis_y;
} CellGrid;

static CellGrid grid_of_texel(__global const float* axes, int texel) {
  CellGrid grid;
  grid.axis_x = axes + (size_t)texel * 2 * MULTUM_AXIS_FLOATS;
  grid.axis_y = grid.axis_x + MULTUM_AXIS_FLOATS;
  return grid;
}

static int cell_of_normal(float x, float y, float z, CellGrid grid, const MultumMovmfFit* fit) {
  const float2 p = place_of_normal(x, y, z, fit);
  const int cell =
      cell_along(p.y, grid.axis_y, fit->cell_side) * fit->cell_side + cell_along(p.x, grid.axis_x, fit->cell_side);
  return fit->shortened ? cell + fit->cell_side * fit->cell_side * length_class(x, y, z) : cell;
}

// What a normal adds to its cell: the values times the weight, and the weight, in units of 2^-30. Rounded towards zero:
// that is one instruction, where convert_long4_rte is a function.
static long4 cell_value(float x, float y, float z, float weight, const MultumMovmfFit* fit, int are_normals) {
  if (MULTUM_PLANAR && are_normals) {
    TO_PLANAR_SAMPLE(float, x, y, z, fit->shortened)
    z = fma(x, x, fma(y, y, z));
  }
  return (long4)((long)(x * weight), (long)(y * weight), (long)(z * weight), (long)weight);
}

// Adds the values of normals to their cells. One work-item = one of chunk_count chunks of columns of one texel; global
// size width * chunk_count.
//   normal_x, normal_y, normal_z [map_window_rows * map_width]  choose the cell
//   value_x, value_y, value_z                                   what is summed: the normals again, or colours
//   cells [texel][chunk][fit.sample_capacity][MULTUM_CELL_SUMS]   added to
// `are_normals`: of Gaussians over (x, y) the third value is E[x^2 + y^2] then, which x and y alone do not tell of a
// cell.
// Bound by the latency of scattered adds.
__kernel void movmf_condense_cells(__global const float* restrict normal_x, __global const float* restrict normal_y,
                                   __global const float* restrict normal_z, __global const float* restrict value_x,
                                   __global const float* restrict value_y, __global const float* restrict value_z,
                                   __global const float* restrict axes, __global long* restrict cells,
                                   MultumMovmfFit fit, int texel_row, int chunk_count, int are_normals) {
  const int item = (int)get_global_id(0);
  const int x = item / chunk_count, chunk = item % chunk_count;
  if (x >= fit.width) return;
  const Covered covered = covered_by(x, texel_row, &fit);
  const int chunk_columns = (fit.sample_columns + chunk_count - 1) / chunk_count;
  const int first_column = covered.first_column + chunk * chunk_columns;
  const int last_column = min(first_column + chunk_columns, covered.last_column);
  __global long* out = cells + (size_t)item * fit.sample_capacity * MULTUM_CELL_SUMS;
  const CellGrid grid = grid_of_texel(axes, x);
  const int first_row = max(covered.first_row, fit.map_first_row);
  const int last_row = min(covered.last_row, fit.map_first_row + fit.map_window_rows);
  for (int row = first_row; row < last_row; ++row) {
    const size_t row_start = (size_t)(row - fit.map_first_row) * fit.map_width;
#if MULTUM_WEIGHTED
    const float row_weight = coverage(row, texel_row, fit.map_height, fit.height);
#endif
    for (int block = first_column; block < last_column; block += CELL_BLOCK) {
      const int count = min(CELL_BLOCK, last_column - block);
      // Cells first, side by side, then the sums, one after another.
      int cells_of[CELL_BLOCK];
      for (int i = 0; i < count; ++i) {
        const size_t source = row_start + block + i;
        cells_of[i] = cell_of_normal(normal_x[source], normal_y[source], normal_z[source], grid, &fit);
      }
      for (int i = 0; i < count; ++i) {
        const size_t source = row_start + block + i;
        float weight = FIXED_POINT;
#if MULTUM_WEIGHTED
        weight *= row_weight * coverage(block + i, x, fit.map_width, fit.width);
#endif
        const long4 value = cell_value(value_x[source], value_y[source], value_z[source], weight, &fit, are_normals);
        vstore4(vload4(cells_of[i], out) + value, cells_of[i], out);
      }
    }
  }
}

#ifdef cl_khr_int64_base_atomics
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

static void add_to_cell(__global long* cells, int cell, long4 value) {
  __global long* at = cells + (size_t)cell * MULTUM_CELL_SUMS;
  atom_add((volatile __global long*)at, value.x);
  atom_add((volatile __global long*)(at + 1), value.y);
  atom_add((volatile __global long*)(at + 2), value.z);
  atom_add((volatile __global long*)(at + 3), value.w);
}

// The same into one table a texel, by atomic additions of whole numbers, whose order cannot be seen. One work-item =
// strip_rows rows of one column of one texel; global size width * fit.sample_columns * strip_count, columns side by
// side. What goes to one cell in a row of turns is added there once, so that a flat map is no queue.
//   cells [texel][fit.sample_capacity][MULTUM_CELL_SUMS]   added to
__kernel void movmf_condense_add(__global const float* restrict normal_x, __global const float* restrict normal_y,
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

// Adds the chunks of a cell. A weight of 0 or less: the cell holds nothing.
static float4 mean_of_cell(__global const long* chunks, int cell, int cell_count, int chunk_count, int are_normals) {
  long4 sum = vload4(cell, chunks);
  for (int chunk = 1; chunk < chunk_count; ++chunk) sum += vload4(chunk * cell_count + cell, chunks);
  if (sum.w <= 0) return (float4)(0.0f);
  const float weight = (float)sum.w;
  float4 mean =
      (float4)((float)sum.x / weight, (float)sum.y / weight, (float)sum.z / weight, weight * FIXED_POINT_INVERSE);
  if (MULTUM_PLANAR && are_normals) mean.z = MAX_V(mean.z - fma(mean.x, mean.x, mean.y * mean.y), 0.0f);
  return mean;
}

// Adds the chunks and lines up the cells that hold anything. One work-item = one texel; global size texel_count.
//   cells [texel][chunk][cell_count][MULTUM_CELL_SUMS]
//   samples [texel][cell_count][MULTUM_CONDENSED_SAMPLE]  written: mean values and weight
//   sample_counts [texel]                                        written
// `are_normals`: as above; what is written is what planar_family.clh takes for a sample. Memory bound.
__kernel void movmf_condense_means(__global const long* cells, __global float* samples, __global int* sample_counts,
                                   int texel_count, int chunk_count, int cell_count, int are_normals) {
  const int texel = (int)get_global_id(0);
  if (texel >= texel_count) return;
  __global const long* in = cells + (size_t)texel * chunk_count * cell_count * MULTUM_CELL_SUMS;
  __global float* out = samples + (size_t)texel * cell_count * MULTUM_CONDENSED_SAMPLE;
  int count = 0;
  for (int cell = 0; cell < cell_count; ++cell) {
    const float4 mean = mean_of_cell(in, cell, cell_count, chunk_count, are_normals);
    if (mean.w > 0.0f) vstore4(mean, count++, out);
  }
  sample_counts[texel] = count;
}

// The same by a team of MULTUM_TEAM work-items a texel, the same bytes: a member takes a cell, and its place is the
// number of those before it that hold anything. Local size MULTUM_TEAM, global size MULTUM_TEAM * texel_count.
__attribute__((reqd_work_group_size(MULTUM_TEAM, 1, 1))) __kernel void movmf_condense_team_means(
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

// The samples of 16 texels side by side, as EM streams them. One work-item = one of part_count parts of the samples of
// one group of slots, every part_count-th; global size slot_count / MULTUM_GROUP * part_count.
//   condensed [texel of the window][fit.sample_capacity][MULTUM_CONDENSED_SAMPLE]
//   condensed_counts [texel of the window]
//   samples [group][sample][4][MULTUM_GROUP]   written
//   sample_counts [group]                      written: that of the texel that has most; what others lack weighs 0
// Memory bound.
__kernel void movmf_condensed_pack(__global const float* condensed, __global const int* condensed_counts,
                                   __global const int* texel_list, __global float* samples, __global int* sample_counts,
                                   MultumMovmfFit fit, int part_count) {
  const int group = (int)get_global_id(0) / part_count, part = (int)get_global_id(0) % part_count;
  if (group * MULTUM_GROUP >= fit.slot_count) return;
  __global float* out = samples + (size_t)group * fit.sample_capacity * 4 * MULTUM_GROUP;
  __global const int* texels = texel_list + group * MULTUM_GROUP;
  int most = 1;
  for (int lane = 0; lane < MULTUM_GROUP; ++lane)
    if (texels[lane] >= 0) most = max(most, condensed_counts[texels[lane]]);
  for (int lane = 0; lane < MULTUM_GROUP; ++lane) {
    const int count = texels[lane] < 0 ? 0 : condensed_counts[texels[lane]];
    __global const float* in = condensed + (size_t)max(texels[lane], 0) * fit.sample_capacity * MULTUM_CONDENSED_SAMPLE;
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
