// SPDX-License-Identifier: Apache-2.0
// Defines tables for a mip pyramid whose texels are in one list, in the order of host/formats/asset/mip_layout.h. The
// tables describe the bilinear interpolation between neighbouring levels and its transpose.
// host/fields/inference/solver/pyramid_tables.h computes them. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MIP_PYRAMID_H
#define MULTUM_KERNELS_SHARED_MIP_PYRAMID_H

typedef struct MultumMipLevel {
  int offset;  // index of the level's first texel
  int width;
  int height;
  int taps_x;     // first tap of the level's columns in the next coarser level; unused in the coarsest level
  int taps_y;     // first tap of the level's rows
  int gathers_x;  // first gather of the level's columns from the next finer level; unused in the finest level
  int gathers_y;  // first gather of the level's rows
  int unused;
} MultumMipLevel;

// The two neighbouring texels of the next coarser level from which a texel is interpolated, in one direction.
typedef struct MultumTap {
  int first;
  int second;
  float fraction;  // weight of the second texel
  int unused;
} MultumTap;

// The texels of the next finer level to whose interpolation a texel contributes, in one direction. They are a range of
// entries.
typedef struct MultumGather {
  int begin;
  int count;
} MultumGather;

typedef struct MultumGatherEntry {
  int fine;
  float weight;
} MultumGatherEntry;

// Neighbouring texels of one row of a level, which one work-item computes. A strip has many texels on CPUs and one on
// GPUs.
typedef struct MultumStrip {
  int level;
  int y;
  int x_begin;
  int x_end;
} MultumStrip;

#endif
