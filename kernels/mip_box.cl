// SPDX-License-Identifier: Apache-2.0
// Box-filtered mip pyramids (Williams 1983, section 3) of planes of numbers - colours, moments, heights, radiance - of
// every level at once while the map streams by in bands of rows.
//
// A texel of a level averages exactly what it covers of the finest texels (docs/contributing/ALGORITHMS.md,
// "Notation"), for any size; Williams has powers of two alone, each level from the one before:
//
//     along a row      its column covers blocks of 2^k texels and fractions at the ends (row_blocks.h): a few nodes
//     down the rows    whole rows weigh 1, a row between two texels is shared out; a compensated sum
//
// so that no level depends on another, nor on the height of bands, and for powers of two nothing but additions and one
// multiplication by a power of two happens. Sums begin in one band and end in another; they are all that is kept.
// Borders: a texel covers nothing beyond the map, so that averages are the same for every wrap mode.

#include "device/numerics.clh"
#include "shared/mip_box.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "mip_box has only a scalar variant"
#endif

// One work-item = one texel of a plane of the band; global size plane_count * row_count * map_width.
//   planes [plane][row][map_width]
//   nodes  [plane][row][row_length]   written: the texels
// Memory bound.
__kernel void mip_texels(__global const float* planes, __global float* nodes, MultumBoxBand band) {
  const int item = (int)get_global_id(0);
  if (item >= band.plane_count * band.row_count * band.map_width) return;
  nodes[(size_t)(item / band.map_width) * band.row_length + item % band.map_width] = planes[item];
}

// Three planes among others. One work-item = one texel of the band; global size row_count * map_width.
//   value_x, value_y, value_z [row][map_width]
//   nodes [plane][row][row_length]   written: the texels of planes first_plane to first_plane + 2
// Memory bound.
__kernel void mip_features(__global const float* value_x, __global const float* value_y, __global const float* value_z,
                           __global float* nodes, MultumBoxBand band, int first_plane) {
  const int item = (int)get_global_id(0);
  if (item >= band.row_count * band.map_width) return;
  const size_t plane_size = (size_t)band.row_count * band.row_length;
  __global float* out =
      nodes + first_plane * plane_size + (size_t)(item / band.map_width) * band.row_length + item % band.map_width;
  out[0] = value_x[item];
  out[plane_size] = value_y[item];
  out[2 * plane_size] = value_z[item];
}

// One work-item = one block; global size plane_count * row_count * block_count. Launched for blocks of 2, of 4, ...
//   nodes   in place: block i, at first_block + i, is the sum of the two at first_half + 2 i
// Memory bound.
__kernel void mip_blocks(__global float* nodes, MultumBoxBand band, int first_half, int first_block, int block_count) {
  const int item = (int)get_global_id(0);
  if (item >= band.plane_count * band.row_count * block_count) return;
  __global float* row = nodes + (size_t)(item / block_count) * band.row_length;
  const int block = item % block_count;
  row[first_block + block] = row[first_half + 2 * block] + row[first_half + 2 * block + 1];
}

// The level that a column of all levels belongs to.
static MultumBoxLevel level_of_column(__global const MultumBoxLevel* levels, int level_count, int column) {
  int l = level_count - 1;
  while (levels[l].first_column > column) --l;
  return levels[l];
}

// One work-item = one column of a level in one plane, down the rows of the band; global size plane_count *
// column_count.
//   nodes      [plane][row][row_length]
//   tap_begin  [column_count + 1], taps: the nodes of each column
//   sums       [plane][column_count][2]   a sum and what rounding took from it, from one band to the next; first zeros
//   averages   [level][plane][row][column]   written: rows that the band finishes
// Memory bound.
__kernel void mip_levels(__global const float* nodes, __global const MultumBoxLevel* levels,
                         __global const int* tap_begin, __global const MultumBoxTap* taps, __global float* sums,
                         __global float* averages, MultumBoxBand band) {
  const int item = (int)get_global_id(0);
  if (item >= band.plane_count * band.column_count) return;
  const int plane = item / band.column_count, column = item % band.column_count;
  const MultumBoxLevel level = level_of_column(levels, band.level_count, column);
  const int first_tap = tap_begin[column], end_tap = tap_begin[column + 1];
  __global float* out =
      averages + level.first_value + (size_t)plane * level.row_count * level.width + column - level.first_column;
  float sum = sums[2 * (size_t)item], carry = sums[2 * (size_t)item + 1];
  int row = level.first_row;
  for (int i = 0; i < band.row_count; ++i) {
    __global const float* in = nodes + ((size_t)plane * band.row_count + i) * band.row_length;
    float value = 0.0f;
    for (int tap = first_tap; tap < end_tap; ++tap) value = fma(taps[tap].weight, in[taps[tap].node], value);
    // In units of 1/height of a finest row: this one is [begin, end), the level's row ends at `border`. Sides are at
    // most 32768: products fit an int.
    const int begin = (band.first_row + i) * level.height, end = begin + level.height;
    const int border = (row + 1) * band.map_height;
    if (end < border) {
      add_compensated(&sum, &carry, value);
      continue;
    }
    add_compensated(&sum, &carry, value * ((float)(border - begin) / (float)level.height));
    *out = (sum + carry) * level.share;
    out += level.width;
    ++row;
    sum = carry = 0.0f;
    if (end > border) sum = value * ((float)(end - border) / (float)level.height);
  }
  sums[2 * (size_t)item] = sum;
  sums[2 * (size_t)item + 1] = carry;
}
