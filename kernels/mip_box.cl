// SPDX-License-Identifier: Apache-2.0
// Computes all levels of box-filtered mip pyramids (Williams 1983, section 3) at once, while the map is read in bands
// of rows. The planes hold colours, moments, heights or radiance.
//
// A texel of a level averages exactly the finest texels that it covers (docs/contributing/ALGORITHMS.md, "Notation"),
// for any size. Williams supports only powers of two, and computes each level from the previous one. Here:
//
//     along a row      a column covers blocks of 2^k texels and fractions at its ends (row_blocks.h): a few nodes
//     down the rows    whole rows weigh 1, a row between two texels is split between them; sums are compensated
//
// Therefore no level depends on another level or on the height of the bands. For powers of two, the only operations are
// additions and one multiplication by a power of two. Sums may begin in one band and end in another; no other data is
// kept between bands. A texel covers nothing beyond the map's borders, so averages do not depend on the wrap mode.

#include "device/numerics.clh"
#include "shared/mip_box.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "mip_box has only a scalar variant"
#endif

// Copies the texels of planes to nodes.
// One work-item handles one texel of a plane of the band. The global size is plane_count * row_count * map_width.
//   planes [plane][row][map_width]
//   nodes  [plane][row][row_length]   written: the texels
// The kernel is memory bound.
__kernel void mip_texels(__global const float* planes, __global float* nodes, MultumBoxBand band) {
  const int item = (int)get_global_id(0);
  if (item >= band.plane_count * band.row_count * band.map_width) return;
  nodes[(size_t)(item / band.map_width) * band.row_length + item % band.map_width] = planes[item];
}

// Copies three features to consecutive planes. One work-item handles one texel of the band. The global size is
// row_count * map_width.
//   value_x, value_y, value_z [row][map_width]
//   nodes [plane][row][row_length]   written: the texels of planes first_plane to first_plane + 2
// The kernel is memory bound.
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

// Sums pairs of blocks. The kernel is launched for blocks of 2 texels, of 4 texels, and so on. One work-item handles
// one block. The global size is plane_count * row_count * block_count.
//   nodes   in place: block i, at first_block + i, is the sum of the two blocks at first_half + 2 i
// The kernel is memory bound.
__kernel void mip_blocks(__global float* nodes, MultumBoxBand band, int first_half, int first_block, int block_count) {
  const int item = (int)get_global_id(0);
  if (item >= band.plane_count * band.row_count * block_count) return;
  __global float* row = nodes + (size_t)(item / block_count) * band.row_length;
  const int block = item % block_count;
  row[first_block + block] = row[first_half + 2 * block] + row[first_half + 2 * block + 1];
}

// Returns the level of a column. Columns are counted over all levels.
static MultumBoxLevel level_of_column(__global const MultumBoxLevel* levels, int level_count, int column) {
  int l = level_count - 1;
  while (levels[l].first_column > column) --l;
  return levels[l];
}

// Adds the rows of a band to the sums of all levels, and writes the averages of finished rows.
// One work-item handles one column of a level in one plane, down the rows of the band. The global size is
// plane_count * column_count.
//   nodes      [plane][row][row_length]
//   tap_begin  [column_count + 1], taps: the nodes of each column
//   sums       [plane][column_count][2]   a sum and its rounding error, passed from band to band; initially zeros
//   averages   [level][plane][row][column]   written: rows that the band finishes
// The kernel is memory bound.
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
    // Positions are in units of 1/height of a finest row. This row is [begin, end), and the level's row ends at
    // `border`. Sides are at most 32768, so the products are in the range of int.
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
