// SPDX-License-Identifier: Apache-2.0
// A mip pyramid's texels in one list, as host/asset/mip_layout.h has them, and the bilinear interpolation between
// neighbouring levels, of any size, clamped or periodic: it is separable, so that a table a direction holds all of it.
// Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MIP_PYRAMID_H
#define MULTUM_KERNELS_SHARED_MIP_PYRAMID_H

// Where a fine column or row lies among the coarse ones: (1 - fraction) first + fraction second.
typedef struct MultumCoarseTap {
  int first;
  int second;
  float fraction;
  int unused;
} MultumCoarseTap;

// The transpose: a fine column or row that a coarse one has weight in.
typedef struct MultumFineTap {
  int index;
  float weight;
} MultumFineTap;

typedef struct MultumMipLevel {
  int offset;  // of its first texel
  int width;
  int height;
  int coarse_columns;  // into the coarse taps: `width` of them, then `height` for rows; not in the coarsest level
  int coarse_rows;
  int fine_columns;  // into the beginnings of fine taps: `width` + 1 of them, then `height` + 1; not in the finest
                     // level
  int fine_rows;
  int unused;
} MultumMipLevel;

#endif
