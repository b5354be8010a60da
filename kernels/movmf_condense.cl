// SPDX-License-Identifier: Apache-2.0
// The normals of a coarse texel, condensed: sorted into the cells of a grid over directions, each cell a sample of EM
// with the number of its normals as weight and their mean vector as normal. Cells are so much smaller than lobes that
// EM does the same with at most 961 of them as with all normals, and first moments stay exact. docs/ALGORITHMS.md,
// "Condensed normals".
//
// Directions lie at p = (x, y) / sqrt(1 + z), Lambert's equal-area disc. Each axis of p has its own map to cells, by
// three quarters from how many normals lie where and by a quarter from their extent: a few steep edges do not coarsen
// the cells of a flat texel. What lies outside the axes belongs to the outermost cells.
// This file has only a scalar variant.

#include "device/numerics.clh"
#include "device/texel_coverage.clh"
#include "shared/movmf_fit.h"

#ifndef MULTUM_WEIGHTED
#define MULTUM_WEIGHTED 0
#endif

#define SAMPLE_SIDE 32  // axes are made from one normal of each of so many blocks, across and down

static float2 equal_area(float x, float y, float z) {
  const float inverse = 1.0f / sqrt(MAX_V(1.0f + z, 1e-6f));
  return (float2)(x * inverse, y * inverse);
}

typedef struct Covered {
  int first_column, last_column, first_row, last_row;  // last: one past
} Covered;

static Covered covered_by(int x, int y, const MultumMovmfFit* fit) {
  Covered c;
  c.first_column = first_covered(x, fit->map_width, fit->width);
  c.first_row = first_covered(y, fit->map_height, fit->height);
  c.last_column = min(c.first_column + fit->sample_columns, fit->map_width);
  c.last_row = min(c.first_row + fit->sample_rows, fit->map_height);
  return c;
}

// Part `index` of `count` parts of a range of `size`: one place in it, by chance, so that a pattern cannot fall in
// step.
static int place_in_part(int index, int count, int size, uint* state) {
  const int first = index * size / count, last = (index + 1) * size / count;
  *state = *state * 1664525u + 1013904223u;
  return first + (int)((*state >> 8) % (uint)(last - first));
}

// The axes of one texel's grid. One work-item = one slot; global size slot_count.
//   normal_x, normal_y, normal_z [map_height * map_width]
//   axes [slot][2][MULTUM_AXIS_FLOATS]  written: the low end, bins a unit of p, and the cell at each bin's edge
// Bound by memory latency: 2048 scattered reads an item.
__kernel void movmf_condense_axes(__global const float* normal_x, __global const float* normal_y,
                                  __global const float* normal_z, __global const int* texel_list, __global float* axes,
                                  MultumMovmfFit fit) {
  const int slot = (int)get_global_id(0);
  if (slot >= fit.slot_count) return;
  const int texel = texel_list[fit.list_offset + slot];
  if (texel < 0) return;
  const Covered covered = covered_by(texel % fit.width, texel / fit.width, &fit);
  const int columns = covered.last_column - covered.first_column, rows = covered.last_row - covered.first_row;
  const int across = min(columns, SAMPLE_SIDE), down = min(rows, SAMPLE_SIDE);

  float low[2] = {1e30f, 1e30f}, high[2] = {-1e30f, -1e30f}, bins_per_unit[2] = {0.0f, 0.0f};
  int counts[2][MULTUM_AXIS_BINS];
  for (int k = 0; k < 2; ++k)
    for (int b = 0; b < MULTUM_AXIS_BINS; ++b) counts[k][b] = 0;
  for (int pass = 0; pass < 2; ++pass) {  // the extent, then the numbers
    uint state = 1u;
    for (int j = 0; j < down; ++j)
      for (int i = 0; i < across; ++i) {
        const int column = covered.first_column + place_in_part(i, across, columns, &state);
        const int row = covered.first_row + place_in_part(j, down, rows, &state);
        const size_t source = (size_t)row * fit.map_width + column;
        const float2 p = equal_area(normal_x[source], normal_y[source], normal_z[source]);
        const float at[2] = {p.x, p.y};
        for (int k = 0; k < 2; ++k) {
          if (pass == 0) {
            low[k] = MIN_V(low[k], at[k]);
            high[k] = MAX_V(high[k], at[k]);
          } else {
            counts[k][clamp((int)((at[k] - low[k]) * bins_per_unit[k]), 0, MULTUM_AXIS_BINS - 1)] += 1;
          }
        }
      }
    if (pass == 0)
      for (int k = 0; k < 2; ++k) bins_per_unit[k] = (float)MULTUM_AXIS_BINS / MAX_V(high[k] - low[k], 1e-6f);
  }
  const float count_inverse = 1.0f / (float)(across * down);
  for (int k = 0; k < 2; ++k) {
    __global float* axis = axes + ((size_t)slot * 2 + k) * MULTUM_AXIS_FLOATS;
    axis[0] = low[k];
    axis[1] = bins_per_unit[k];
    int below = 0;
    for (int b = 0; b <= MULTUM_AXIS_BINS; ++b) {
      const float by_number = (float)below * count_inverse, by_extent = (float)b * (1.0f / (float)MULTUM_AXIS_BINS);
      axis[2 + b] = (float)MULTUM_CELL_SIDE * fma(0.75f, by_number, 0.25f * by_extent);
      if (b < MULTUM_AXIS_BINS) below += counts[k][b];
    }
  }
}

static int cell_along(float p, __global const float* axis) {
  const float at = MIN_V(MAX_V((p - axis[0]) * axis[1], 0.0f), (float)MULTUM_AXIS_BINS);
  const int bin = min((int)at, MULTUM_AXIS_BINS - 1);
  const float low = axis[2 + bin];
  return clamp((int)fma(at - (float)bin, axis[3 + bin] - low, low), 0, MULTUM_CELL_SIDE - 1);
}

// Sums the values of the normals of each cell. One work-item = one chunk of rows of one slot; global size
// chunk_count * slot_count.
//   normal_x, normal_y, normal_z  choose the cell
//   value_x, value_y, value_z     what is summed: the normals again, or colours
//   cells [slot][chunk][cell][MULTUM_CELL_FLOATS]  written
// Compensated: thousands of near-equal normals would round away what they differ by.
// Bound by the latency of scattered adds.
__kernel void movmf_condense_cells(__global const float* normal_x, __global const float* normal_y,
                                   __global const float* normal_z, __global const float* value_x,
                                   __global const float* value_y, __global const float* value_z,
                                   __global const int* texel_list, __global const float* axes, __global float* cells,
                                   MultumMovmfFit fit) {
  const int item = (int)get_global_id(0);
  const int slot = item / fit.chunk_count, chunk = item % fit.chunk_count;
  if (slot >= fit.slot_count) return;
  const int texel = texel_list[fit.list_offset + slot];
  if (texel < 0) return;
  const int x = texel % fit.width, y = texel / fit.width;
  const Covered covered = covered_by(x, y, &fit);
  const int first_row = covered.first_row + chunk * fit.chunk_rows;
  const int last_row = min(first_row + fit.chunk_rows, covered.last_row);
  __global float* out = cells + (size_t)item * MULTUM_CELL_COUNT * MULTUM_CELL_FLOATS;
  for (int i = 0; i < MULTUM_CELL_COUNT * MULTUM_CELL_FLOATS; ++i) out[i] = 0.0f;
  __global const float* axis_x = axes + (size_t)slot * 2 * MULTUM_AXIS_FLOATS;
  __global const float* axis_y = axis_x + MULTUM_AXIS_FLOATS;
  for (int row = first_row; row < last_row; ++row) {
    for (int column = covered.first_column; column < covered.last_column; ++column) {
      const size_t source = (size_t)row * fit.map_width + column;
      const float2 p = equal_area(normal_x[source], normal_y[source], normal_z[source]);
      const int cell = cell_along(p.y, axis_y) * MULTUM_CELL_SIDE + cell_along(p.x, axis_x);
      float4 value = (float4)(value_x[source], value_y[source], value_z[source], 1.0f);
#if MULTUM_WEIGHTED
      value *= coverage(row, y, fit.map_height, fit.height) * coverage(column, x, fit.map_width, fit.width);
#endif
      const float4 old = vload4(2 * cell, out), corrected = value - vload4(2 * cell + 1, out);
      const float4 sum = old + corrected;
      vstore4(sum, 2 * cell, out);
      vstore4((sum - old) - corrected, 2 * cell + 1, out);
    }
  }
}

// Adds the chunks and lines up the cells that hold anything. One work-item = one group of slots; global size
// slot_count / MULTUM_GROUP.
//   samples [group][fit.sample_capacity][4][MULTUM_GROUP]  written: the cell's mean values and its weight; from group
//                                                          fit.sample_group_offset on, counts too
//   sample_counts [group]                                  written: those of the texel that has most
// Memory bound.
__kernel void movmf_condense_pack(__global const float* cells, __global const int* texel_list, __global float* samples,
                                  __global int* sample_counts, MultumMovmfFit fit) {
  const int group = (int)get_global_id(0);
  if (group * MULTUM_GROUP >= fit.slot_count) return;
  const int sample_group = group + fit.sample_group_offset;
  __global float* out = samples + (size_t)sample_group * fit.sample_capacity * 4 * MULTUM_GROUP;
  int used[MULTUM_GROUP];
  int most = 1;
  for (int lane = 0; lane < MULTUM_GROUP; ++lane) {
    const int slot = group * MULTUM_GROUP + lane;
    used[lane] = 0;
    if (texel_list[fit.list_offset + slot] < 0) continue;
    __global const float* in = cells + (size_t)slot * fit.chunk_count * MULTUM_CELL_COUNT * MULTUM_CELL_FLOATS;
    for (int cell = 0; cell < MULTUM_CELL_COUNT; ++cell) {
      float sum[4] = {0.0f, 0.0f, 0.0f, 0.0f}, carry[4] = {0.0f, 0.0f, 0.0f, 0.0f};
      for (int chunk = 0; chunk < fit.chunk_count; ++chunk) {
        __global const float* part = in + ((size_t)chunk * MULTUM_CELL_COUNT + cell) * MULTUM_CELL_FLOATS;
        for (int k = 0; k < 4; ++k) {
          add_compensated(&sum[k], &carry[k], part[k]);
          add_compensated(&sum[k], &carry[k], -part[4 + k]);
        }
      }
      const float weight = sum[3] + carry[3];
      if (!(weight > 0.0f)) continue;
      __global float* sample = out + (size_t)used[lane] * 4 * MULTUM_GROUP + lane;
      for (int k = 0; k < 3; ++k) sample[k * MULTUM_GROUP] = (sum[k] + carry[k]) / weight;
      sample[3 * MULTUM_GROUP] = weight;
      ++used[lane];
    }
    most = max(most, used[lane]);
  }
  for (int lane = 0; lane < MULTUM_GROUP; ++lane)
    for (int i = used[lane]; i < most; ++i) {
      __global float* sample = out + (size_t)i * 4 * MULTUM_GROUP + lane;
      sample[0] = sample[MULTUM_GROUP] = sample[3 * MULTUM_GROUP] = 0.0f;
      sample[2 * MULTUM_GROUP] = 1.0f;
    }
  sample_counts[sample_group] = most;
}
