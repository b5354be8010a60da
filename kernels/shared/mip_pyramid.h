// SPDX-License-Identifier: Apache-2.0
// A mip pyramid's texels in one list, as host/formats/asset/mip_layout.h has them, with tables of the bilinear
// interpolation between neighbouring levels and of its transpose (host/fields/inference/solver/pyramid_tables.h makes
// them). Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MIP_PYRAMID_H
#define MULTUM_KERNELS_SHARED_MIP_PYRAMID_H

typedef struct MultumMipLevel {
  int offset;  // of its first texel
  int width;
  int height;
  int taps_x;     // first tap of its columns in the next coarser level; of the coarsest level meaningless
  int taps_y;     // of its rows
  int gathers_x;  // first gather of its columns from the next finer level; of the finest level meaningless
  int gathers_y;  // of its rows
  int unused;
} MultumMipLevel;

// Between which two texels of the next coarser level one lies, in one direction.
typedef struct MultumTap {
  int first;
  int second;
  float fraction;  // weight of the second
  int unused;
} MultumTap;

// Which texels of the next finer level have a texel as one of their two, in one direction: a range of entries.
typedef struct MultumGather {
  int begin;
  int count;
} MultumGather;

typedef struct MultumGatherEntry {
  int fine;
  float weight;
} MultumGatherEntry;

// Neighbouring texels of one row of a level, the work of one work-item: many on CPUs, one on GPUs.
typedef struct MultumStrip {
  int level;
  int y;
  int x_begin;
  int x_end;
} MultumStrip;

#endif
