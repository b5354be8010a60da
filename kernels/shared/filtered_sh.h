// SPDX-License-Identifier: Apache-2.0
// The arguments of kernels/sh_shade.cl except the coefficients. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_FILTERED_SH_H
#define MULTUM_KERNELS_SHARED_FILTERED_SH_H

// The shares of a filter's weights. `share` is the part on stored levels, and multiplies their coefficients. map_share
// is the part on the normal map, and multiplies its mean normal.
typedef struct MultumFilteredSh {
  float map_x, map_y, map_z, map_share;
  float share, unused[3];
} MultumFilteredSh;

#endif
