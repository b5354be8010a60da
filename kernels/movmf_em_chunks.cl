// SPDX-License-Identifier: Apache-2.0
// Runs EM on coarse levels (Han et al. 2007, section 7, Algorithm 1). A texel covers so many normals that one work-item
// sums only a chunk of them (some rows of its rectangle). A second kernel adds the chunks and does the M-step. Each
// iteration is one pair of launches. Normals are read in place, 16 columns at a time:
//
//   texel rectangle    lane  0 1 2 ... 15 | 0 1 2 ... 15 | ...      columns, from the texel's first
//   chunk 0            rows  0 .. chunk_rows - 1
//   chunk 1            rows  chunk_rows .. 2 chunk_rows - 1
//
// Both variants sum in the same canonical order. A lane adds its columns block by block, and down the chunk's rows in
// each block. The 16 lanes are added as a tree (sum_lanes). The chunks are added one after another with compensation.

#include "device/level_window.clh"
#include "device/movmf_em.clh"
#include "device/texel_coverage.clh"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_WEIGHTED
#define MULTUM_WEIGHTED 0
#endif

#define PARTIAL_SUMS 5  // the sums S, X, Y, Z and D of a lobe

// Returns the coverage of the finest columns of a block, one per lane. Columns outside the texel have weight 0.
static real_v column_weights(int first, int x, int map_size, int level_size) {
#if MULTUM_VECTOR_WIDTH == 1
  return coverage(first, x, map_size, level_size);
#else
  float weights[MULTUM_VECTOR_WIDTH];
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane)
    weights[lane] = coverage(first + lane, x, map_size, level_size);
  return LOAD_V(weights);
#endif
}

// One work-item handles one chunk (vector variant) or one lane of one chunk (scalar variant, local size MULTUM_GROUP).
// The global size is chunk_count * slot_count, times MULTUM_GROUP in the scalar variant. slot_count counts whole
// groups.
//   normal_x, normal_y, normal_z [rows * map_width + MULTUM_GROUP]  the window's rows and the further rows of chunks
//                                                                   that begin in it; the last MULTUM_GROUP are finite
//   start   [group][lobe][MULTUM_START_PLANES][MULTUM_GROUP]
//   partial [slot][chunk][lobe][PARTIAL_SUMS]
// Compute bound, like movmf_em_texels.
__kernel void movmf_em_partial(__global const float* restrict normal_x, __global const float* restrict normal_y,
                               __global const float* restrict normal_z, __global const float* restrict start,
                               __global const int* restrict texel_list, __global float* restrict partial,
                               MultumMovmfFit fit) {
#if MULTUM_VECTOR_WIDTH == 1
  const int lane = (int)get_local_id(0);
  const int chunk_index = (int)get_group_id(0);
  __local float lanes[MULTUM_GROUP];
#else
  const int lane = 0;
  const int chunk_index = (int)get_global_id(0);
#endif
  const int slot = chunk_index / fit.chunk_count, chunk = chunk_index % fit.chunk_count;
  // Unused slots repeat texel 0, so that every work-item of a group takes the same path to the barriers below.
  const int texel = slot < fit.slot_count ? max(texel_list[slot], 0) : 0;
  const int x = texel_column(texel, &fit), y = texel_row(texel, &fit);
  const int top_row = first_covered(y, fit.map_height, fit.height);
  const int first_row = top_row + chunk * fit.chunk_rows;
  const int last_row = min(min(first_row + fit.chunk_rows, top_row + fit.sample_rows), fit.map_height);
  // A chunk is summed when the window in which it begins is loaded. If a smaller texel does not have this chunk, the
  // chunk's sums are set to 0 once.
  if (!in_map_window(min(first_row, fit.map_height - 1), &fit)) return;
  const int used_slot = min(slot, fit.slot_count - 1);

  real_v mu_x[MULTUM_LOBES], mu_y[MULTUM_LOBES], mu_z[MULTUM_LOBES], sharpness[MULTUM_LOBES], log_weight[MULTUM_LOBES];
  real_v sum_s[MULTUM_LOBES], sum_x[MULTUM_LOBES], sum_y[MULTUM_LOBES], sum_z[MULTUM_LOBES], sum_d[MULTUM_LOBES];
  __global const float* p = start +
                            (size_t)(used_slot / MULTUM_GROUP) * MULTUM_LOBES * MULTUM_START_PLANES * MULTUM_GROUP +
                            used_slot % MULTUM_GROUP;
  _Pragma("unroll") for (int j = 0; j < MULTUM_LOBES; ++j, p += MULTUM_START_PLANES * MULTUM_GROUP) {
    mu_x[j] = (real_v)(p[(MULTUM_START_MU + 0) * MULTUM_GROUP]);
    mu_y[j] = (real_v)(p[(MULTUM_START_MU + 1) * MULTUM_GROUP]);
    mu_z[j] = (real_v)(p[(MULTUM_START_MU + 2) * MULTUM_GROUP]);
    sharpness[j] = (real_v)(p[MULTUM_START_SHARPNESS * MULTUM_GROUP]);
    log_weight[j] = (real_v)(p[MULTUM_START_LOG * MULTUM_GROUP]);
    sum_s[j] = sum_x[j] = sum_y[j] = sum_z[j] = sum_d[j] = (real_v)(0.0f);
  }

  for (int block = 0; block < fit.sample_columns; block += MULTUM_GROUP) {
    const int column = first_covered(x, fit.map_width, fit.width) + block + lane;
    const real_v column_weight = column_weights(column, x, fit.map_width, fit.width);
    // Columns beyond the map have weight 0. Their values come from the next row, or are the zeros after the last row.
    const int readable = min(column, fit.map_width);
    for (int first = first_row; first < last_row; first += SAMPLE_BLOCK) {
      const int count = min(SAMPLE_BLOCK, last_row - first);
      real_v responsibility[SAMPLE_BLOCK][MULTUM_LOBES], u[SAMPLE_BLOCK][MULTUM_LOBES];
      for (int i = 0; i < count; ++i) {
        const size_t source = map_row_start(first + i, &fit) + readable;
        real_v nx = LOAD_V(normal_x + source), ny = LOAD_V(normal_y + source), nz = LOAD_V(normal_z + source);
        TO_SAMPLE(real_v, nx, ny, nz, fit.shortened)
#if MULTUM_WEIGHTED
        const real_v weight = column_weight * coverage(first + i, y, fit.map_height, fit.height);
#else
        const real_v weight = column_weight;
#endif
        RESPONSIBILITIES(nx, ny, nz, weight, responsibility[i], u[i])
      }
      for (int i = 0; i < count; ++i) {
        const size_t source = map_row_start(first + i, &fit) + readable;
        real_v nx = LOAD_V(normal_x + source), ny = LOAD_V(normal_y + source), nz = LOAD_V(normal_z + source);
        TO_SAMPLE(real_v, nx, ny, nz, fit.shortened)
        ADD_MOMENTS(nx, ny, nz, responsibility[i], u[i])
      }
    }
  }

  __global float* out = partial + (size_t)chunk_index * MULTUM_LOBES * PARTIAL_SUMS;
#if MULTUM_VECTOR_WIDTH == 1
#define SUM_OVER_LANES(value, destination)                        \
  lanes[lane] = value;                                            \
  for (int apart = MULTUM_GROUP / 2; apart > 0; apart /= 2) {     \
    barrier(CLK_LOCAL_MEM_FENCE);                                 \
    if (lane < apart) lanes[lane] += lanes[lane + apart];         \
  }                                                               \
  barrier(CLK_LOCAL_MEM_FENCE);                                   \
  if (lane == 0 && slot < fit.slot_count) destination = lanes[0]; \
  barrier(CLK_LOCAL_MEM_FENCE);
#else
#define SUM_OVER_LANES(value, destination) \
  if (slot < fit.slot_count) destination = sum_lanes(value);
#endif
  for (int j = 0; j < MULTUM_LOBES; ++j, out += PARTIAL_SUMS) {
    SUM_OVER_LANES(sum_s[j], out[0])
    SUM_OVER_LANES(sum_x[j], out[1])
    SUM_OVER_LANES(sum_y[j], out[2])
    SUM_OVER_LANES(sum_z[j], out[3])
    SUM_OVER_LANES(sum_d[j], out[4])
  }
}
