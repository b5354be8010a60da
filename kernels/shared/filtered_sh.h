// SPDX-License-Identifier: Apache-2.0
// Arguments of kernels/sh_shade.cl beside the coefficients. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_FILTERED_SH_H
#define MULTUM_KERNELS_SHARED_FILTERED_SH_H

// Of a filter's weights `share` fell on stored levels, whose coefficients are multiplied by it, and map_share on the
// normal map itself, whose mean normal is multiplied by that.
typedef struct MultumFilteredSh {
  float map_x, map_y, map_z, map_share;
  float share, unused[3];
} MultumFilteredSh;

#endif
