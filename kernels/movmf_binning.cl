// SPDX-License-Identifier: Apache-2.0
// Bins the normals of a coarse texel, which means that it sorts them into the cells of a grid over directions. Each
// cell becomes one EM sample, whose weight is the number of the cell's normals and whose normal is their mean vector.
// Cells are much smaller than lobes, so EM gives the same result with some thousand cells as with all normals. First
// moments stay exact (docs/contributing/ALGORITHMS.md, "Binned normals").
//
// Directions are mapped to p = (x, y) / sqrt(1 + z), which is Lambert's equal-area disc. Each axis of p has its own map
// to cells. Three quarters of the cells follow the density of the normals, and one quarter follow their extent. Without
// the density, a few steep edges would make the cells of a flat texel too coarse. Normals outside the range of an axis
// belong to its outermost cells.
//
// If normals were shortened to include a BRDF's width (MovmfFit::shortened), each class of lengths has its own grid of
// directions. Lobes can then distinguish sharp and wide BRDFs under one texel. The classes are separated at kappas of
// 1250, 133 and 22, which correspond to perceptual roughnesses of 0.2, 0.35 and 0.55. The kappas of a class thus differ
// by a factor of 9 at most, except in the sharpest class, whose widths are hardly visible.
//
// The map is read in bands of rows. Sums are integers in units of 2^-30, so they do not depend on the order of bands,
// chunks or threads. These units are small enough to keep the differences between thousands of nearly equal normals.
// The sum of 2^28 normals is at most 2^58. A launch handles the texels of one row of a level.
//
// This file has only a scalar variant. movmf_binning_team.cl has variants for devices with atomic additions and teams
// of work-items. These variants write the same bytes as this file.

#include "device/binned_cells.clh"

#define CELL_BLOCK 64

// Returns a random place in part `index` of `count` parts of a range of `size`. The place is random, because regular
// places could coincide with a regular pattern of the map.
static int place_in_part(int index, int count, int size, uint seed) {
  const int first = (int)((long)index * size / count), last = (int)((long)(index + 1) * size / count);
  uint state = seed * 1664525u + 1013904223u;
  state = (state ^ (state >> 15)) * 0x2c1b3c6du;
  state = (state ^ (state >> 12)) * 0x297a2d39u;
  return first + (int)((state >> 8) % (uint)(last - first));
}

// Probes one normal in each of MULTUM_PROBE_SIDE blocks across and down (fewer if there are fewer normals), in the rows
// that the window holds. One work-item handles one row of blocks of one texel. The global size is
// width * MULTUM_PROBE_SIDE.
//   normal_x, normal_y, normal_z [map_window_rows * map_width]
//   probes [texel][MULTUM_PROBE_COUNT][2]   written: p
// Bound by memory latency: 32 scattered reads per item.
__kernel void movmf_bin_probe(__global const float* normal_x, __global const float* normal_y,
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

// Computes the axes of one texel's grid from its probes. One work-item handles one axis of one texel. The global size
// is 2 * width.
//   axes [texel][2][MULTUM_AXIS_FLOATS]  written: the low end, bins per unit of p, and the cell at each bin's edge
__kernel void movmf_bin_axes(__global const float* probes, __global float* axes, MultumMovmfFit fit, int texel_row) {
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

// Adds the values of normals to their cells. One work-item handles one of chunk_count chunks of columns of one texel.
// The global size is width * chunk_count.
//   normal_x, normal_y, normal_z [map_window_rows * map_width]  choose the cell
//   value_x, value_y, value_z                                   summed: the normals again, or colours
//   cells [texel][chunk][fit.sample_capacity][MULTUM_CELL_SUMS]   added to
// If `are_normals`, the third sum of Gaussians over (x, y) is E[x^2 + y^2], which cannot be computed from the cell's
// mean x and y. Bound by the latency of scattered adds.
__kernel void movmf_bin_cells(__global const float* restrict normal_x, __global const float* restrict normal_y,
                              __global const float* restrict normal_z, __global const float* restrict value_x,
                              __global const float* restrict value_y, __global const float* restrict value_z,
                              __global const float* restrict axes, __global long* restrict cells, MultumMovmfFit fit,
                              int texel_row, int chunk_count, int are_normals) {
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
      // Finds all cells of a block first, and then adds to the sums of these cells one after another.
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

// Adds the chunks of cells, and packs the cells that are not empty. One work-item handles one texel. The global size is
// texel_count.
//   cells [texel][chunk][cell_count][MULTUM_CELL_SUMS]
//   samples [texel][cell_count][MULTUM_CONDENSED_SAMPLE]  written: mean values and weight
//   sample_counts [texel]                                        written
// `are_normals` is as above; the samples then have the form that planar_family.clh expects. The kernel is memory bound.
__kernel void movmf_bin_means(__global const long* cells, __global float* samples, __global int* sample_counts,
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
