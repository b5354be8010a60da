// SPDX-License-Identifier: Apache-2.0
// Assigns the normals of the finest level, one per texel, to the parent's nearest lobe. Each normal belongs wholly to
// one lobe. The result is exact, and aligned with the parent for trilinear filtering (Han et al. 2007, section 7.3).
// The paper does not say whether to assign a normal to one lobe or to divide it among all lobes. Assigning it to one
// lobe lowers the error midway between texels by a fifth, and only the lobe's index must be stored. If normals were
// shortened to include a BRDF's width, each normal goes to the lobe whose mean vector is nearest in direction and
// width.

#include "device/lane_transpose.clh"
#include "device/level_window.clh"
#include "device/planar_sample.clh"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif
#ifndef MULTUM_PLANAR
#define MULTUM_PLANAR 0
#endif

// Loads one value per lane. There are `count` values, and lanes after them repeat the last value.
static real_v load_row(__global const float* values, int count) {
  if (count >= MULTUM_VECTOR_WIDTH) return LOAD_V(values);
  float lanes[MULTUM_VECTOR_WIDTH];
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) lanes[lane] = values[min(lane, count - 1)];
  return LOAD_V(lanes);
}

static void store_row(int_v numbers, __global uchar* to, int count) {
  int lanes[MULTUM_VECTOR_WIDTH];
  STORE_V(numbers, lanes);
  for (int lane = 0; lane < min(count, MULTUM_VECTOR_WIDTH); ++lane) to[lane] = (uchar)lanes[lane];
}

// One work-item handles MULTUM_VECTOR_WIDTH texels of one row. The global size is row_count times map_width divided by
// MULTUM_VECTOR_WIDTH and rounded up.
//   normal_x, normal_y, normal_z [rows * map_width]  from row normals_row on
//   parent  [lobe][fit.window_rows * fit.width]      the window of level 1; if has_parent is 0 (a map of one texel, or
//                                                    lobes that are not aligned), lobe 0 takes all normals
//   nearest [row_count * map_width]                  written: the lobe's index, for rows from first_row on
// The kernel is memory bound.
__kernel void movmf_level_zero(__global const float* normal_x, __global const float* normal_y,
                               __global const float* normal_z, __global const MultumVmfLobe* parent,
                               __global uchar* nearest, MultumMovmfFit fit, int has_parent, int normals_row,
                               int first_row, int row_count) {
  const int items_per_row = (fit.map_width + MULTUM_VECTOR_WIDTH - 1) / MULTUM_VECTOR_WIDTH;
  const int row = (int)get_global_id(0) / items_per_row;
  const int first_column = (int)get_global_id(0) % items_per_row * MULTUM_VECTOR_WIDTH;
  if (row >= row_count) return;
  const int count = fit.map_width - first_column;
  int_v lobe_of_least = (int_v)(0);
  if (has_parent) {
    const size_t source = (size_t)(normals_row + row) * fit.map_width + first_column;
    real_v nx = load_row(normal_x + source, count), ny = load_row(normal_y + source, count),
           nz = load_row(normal_z + source, count);
#if MULTUM_PLANAR
    TO_PLANAR_SAMPLE(real_v, nx, ny, nz, fit.shortened)
#endif
    const int parent_y = min((first_row + row) >> 1, fit.height - 1);
    const int parent_row = row_in_window(parent_y, fit.first_row, fit.height);
    __global const float* from = (__global const float*)(parent + (size_t)parent_row * fit.width);
    // The distance is 1 - n . mu, so the lobe with the nearest direction is chosen, whether it is wide or narrow. A
    // lobe with r = 0 has no direction. Its distance to every normal is that of a right angle. For Gaussians, the
    // nearest mean is chosen. If normals have a width, the nearest Gaussian is chosen (Wasserstein distance: |p - q|^2
    // + 2 (sigma - tau)^2). A dead lobe takes no normals.
    real_v least = (real_v)(1e30f);
    for (int j = 0; j < MULTUM_LOBES; ++j, from += 4 * level_window_size(&fit)) {
      float4 of_lanes[MULTUM_VECTOR_WIDTH];
#pragma unroll
      for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane)
        of_lanes[lane] = vload4(min((first_column + lane) >> 1, fit.width - 1), from);
      real_v mean_x, mean_y, mean_z, amplitude;
      transpose(of_lanes, &mean_x, &mean_y, &mean_z, &amplitude);
#if MULTUM_PLANAR
      const real_v dx = nx - mean_x, dy = ny - mean_y;
      real_v gap = fma(dx, dx, dy * dy);
      if (fit.shortened) {
        const real_v wider = sqrt(mean_z) - sqrt(0.5f * nz);
        gap = fma(2.0f * wider, wider, gap);
      }
#else
      const real_v length = length_of(mean_x, mean_y, mean_z);
      const real_v along = fma(mean_x, nx, fma(mean_y, ny, mean_z * nz));
      real_v gap = 1.0f - along / MAX_V(length, (real_v)(1e-12f));
      if (fit.shortened) {
        const real_v dx = mean_x - nx, dy = mean_y - ny, dz = mean_z - nz;
        gap = fma(dx, dx, fma(dy, dy, dz * dz));
      }
#endif
      const int_v is_nearer = (amplitude > 1e-6f) & (gap < least);
      least = is_nearer ? gap : least;
      lobe_of_least = is_nearer ? (int_v)(j) : lobe_of_least;
    }
  }
  store_row(lobe_of_least, nearest + (size_t)row * fit.map_width + first_column, count);
}
