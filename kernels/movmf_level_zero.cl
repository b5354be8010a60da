// SPDX-License-Identifier: Apache-2.0
// Assigns the normals of the finest level, one per texel, to the parent's nearest lobe. Each normal belongs wholly to
// one lobe. The result is exact, and aligned with the parent for trilinear filtering (Han et al. 2007, section 7.2).
// The paper does not say whether to assign a normal to one lobe or to divide it among all lobes. Assigning it to one
// lobe lowers the error midway between texels by a fifth, and only the lobe's index must be stored. If normals were
// shortened to include a BRDF's width, each normal goes to the lobe whose mean vector is nearest in direction and
// width.

#include "device/level_window.clh"
#include "device/planar_sample.clh"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif
#ifndef MULTUM_PLANAR
#define MULTUM_PLANAR 0
#endif

// One work-item handles one texel of the rows from first_row on. The global size is row_count * map_width.
//   normal_x, normal_y, normal_z [rows * map_width]  from row normals_row on
//   parent  [lobe][fit.window_rows * fit.width]      the window of level 1; if has_parent is 0 (a map of one texel, or
//                                                    lobes that are not aligned), lobe 0 takes all normals
//   nearest [row_count * map_width]                  written: the lobe's index
// The kernel is memory bound.
__kernel void movmf_level_zero(__global const float* normal_x, __global const float* normal_y,
                               __global const float* normal_z, __global const MultumVmfLobe* parent,
                               __global uchar* nearest, MultumMovmfFit fit, int has_parent, int normals_row,
                               int first_row, int row_count) {
  const int item = (int)get_global_id(0);
  if (item >= row_count * fit.map_width) return;
  int lobe_of_least = 0;
  if (has_parent) {
    const int x = item % fit.map_width, y = first_row + item / fit.map_width;
    const size_t source = (size_t)normals_row * fit.map_width + item;
    float nx = normal_x[source], ny = normal_y[source], nz = normal_z[source];
#if MULTUM_PLANAR
    TO_PLANAR_SAMPLE(float, nx, ny, nz, fit.shortened)
#endif
    const int parent_x = min(x >> 1, fit.width - 1), parent_y = min(y >> 1, fit.height - 1);
    const int parent_row = row_in_window(parent_y, fit.first_row, fit.height);
    __global const MultumVmfLobe* from = parent + (size_t)parent_row * fit.width + parent_x;
    // The distance is 1 - n . mu, so the lobe with the nearest direction is chosen, whether it is wide or narrow. A
    // lobe with r = 0 has no direction. Its distance to every normal is that of a right angle. For Gaussians, the
    // nearest mean is chosen. If normals have a width, the nearest Gaussian is chosen (Wasserstein distance: |p - q|^2
    // + 2 (sigma - tau)^2). A dead lobe takes no normals.
    float least = 1e30f;
    for (int j = 0; j < MULTUM_LOBES; ++j) {
      const MultumVmfLobe lobe = from[j * level_window_size(&fit)];
#if MULTUM_PLANAR
      const float dx = nx - lobe.mean_x, dy = ny - lobe.mean_y;
      float gap = fma(dx, dx, dy * dy);
      if (fit.shortened) {
        const float wider = sqrt(lobe.mean_z) - sqrt(0.5f * nz);
        gap = fma(2.0f * wider, wider, gap);
      }
#else
      const float length =
          sqrt(fma(lobe.mean_x, lobe.mean_x, fma(lobe.mean_y, lobe.mean_y, lobe.mean_z * lobe.mean_z)));
      const float along = fma(lobe.mean_x, nx, fma(lobe.mean_y, ny, lobe.mean_z * nz));
      float gap = 1.0f - along / max(length, 1e-12f);
      if (fit.shortened) {
        const float dx = lobe.mean_x - nx, dy = lobe.mean_y - ny, dz = lobe.mean_z - nz;
        gap = fma(dx, dx, fma(dy, dy, dz * dz));
      }
#endif
      if (lobe.amplitude > 1e-6f && gap < least) {
        least = gap;
        lobe_of_least = j;
      }
    }
  }
  nearest[item] = (uchar)lobe_of_least;
}
