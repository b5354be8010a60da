// SPDX-License-Identifier: Apache-2.0
// The finest level: one normal a texel, given whole to the parent's lobe that lies nearest: exact, and aligned with the
// parent for trilinear filtering (Han et al. 2007, section 7.2; hard or soft was left to measurement: midway
// between texels hard is better by a fifth, and three of four lobes are zeros that compress to nothing).

#include "device/numerics.clh"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

// One work-item = one texel of a band of rows; global size band_rows * map_width.
//   normal_x, normal_y, normal_z [map_height * map_width]
//   parent  [lobe][parent_height * parent_width]; parent_width 0: none (a map of one texel), amplitudes are 1, 0, 0 ...
//   band    [lobe][band_rows * map_width]   written
// Memory bound.
__kernel void movmf_level_zero(__global const float* normal_x, __global const float* normal_y,
                               __global const float* normal_z, __global const MultumVmfLobe* parent,
                               __global MultumVmfLobe* band, int map_width, int parent_width, int parent_height,
                               int first_row, int band_rows) {
  const int item = (int)get_global_id(0);
  if (item >= band_rows * map_width) return;
  const int x = item % map_width, y = first_row + item / map_width;
  const size_t source = (size_t)y * map_width + x;
  const float nx = normal_x[source], ny = normal_y[source], nz = normal_z[source];

  float amplitude[MULTUM_LOBES];
  if (parent_width > 0) {
    const int parent_x = min(x >> 1, parent_width - 1), parent_y = min(y >> 1, parent_height - 1);
    const size_t parent_size = (size_t)parent_width * parent_height;
    __global const MultumVmfLobe* from = parent + (size_t)parent_y * parent_width + parent_x;
    // |r_p| - n . r_p = |r_p| (1 - cos): the nearest direction, wide lobes and narrow ones alike. A dead lobe takes
    // none.
    float least = 1e30f;
    int nearest = 0;
    for (int j = 0; j < MULTUM_LOBES; ++j) {
      const MultumVmfLobe lobe = from[j * parent_size];
      const float length =
          sqrt(fma(lobe.mean_x, lobe.mean_x, fma(lobe.mean_y, lobe.mean_y, lobe.mean_z * lobe.mean_z)));
      const float gap = length - fma(lobe.mean_x, nx, fma(lobe.mean_y, ny, lobe.mean_z * nz));
      if (lobe.amplitude > 1e-6f && gap < least) {
        least = gap;
        nearest = j;
      }
    }
    for (int j = 0; j < MULTUM_LOBES; ++j) amplitude[j] = j == nearest ? 1.0f : 0.0f;
  } else {
    for (int j = 0; j < MULTUM_LOBES; ++j) amplitude[j] = j == 0 ? 1.0f : 0.0f;
  }
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    __global MultumVmfLobe* out = band + (size_t)j * band_rows * map_width + item;
    out->mean_x = nx;
    out->mean_y = ny;
    out->mean_z = nz;
    out->amplitude = amplitude[j];
  }
}
