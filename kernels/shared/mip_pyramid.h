// SPDX-License-Identifier: Apache-2.0
// A mip pyramid's texels in one list, as host/asset/mip_layout.h has them. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MIP_PYRAMID_H
#define MULTUM_KERNELS_SHARED_MIP_PYRAMID_H

typedef struct MultumMipLevel {
  int offset;  // of its first texel
  int width;
  int height;
  int unused;
} MultumMipLevel;

typedef struct MultumPyramid {
  int level_count;
  int texel_count;
  int periodic_s;  // 1: the texture repeats in this direction, 0: it is clamped
  int periodic_t;
} MultumPyramid;

#endif
