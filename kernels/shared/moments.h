// SPDX-License-Identifier: Apache-2.0
// What the host hands to kernels/moments.cl and kernels/moment_shade.cl. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOMENTS_H
#define MULTUM_KERNELS_SHARED_MOMENTS_H

// Planes that are averaged: of slopes b = -(n_x, n_y) / n_z the moments, then the normal, then features if there are
// any, three planes at a time.
#define MULTUM_MOMENT_S 0
#define MULTUM_MOMENT_T 1
#define MULTUM_MOMENT_SS 2
#define MULTUM_MOMENT_TT 3
#define MULTUM_MOMENT_ST 4
#define MULTUM_MOMENT_NORMAL 5
#define MULTUM_MOMENT_PLANES 8

// A band of rows of the map. A row of a plane is `row_length` nodes: its texels, then the sums of 2, of 4, ... of them.
typedef struct MultumMomentBand {
  int map_width;
  int map_height;
  int first_row;  // of the map
  int row_count;
  int row_length;    // from one row's nodes to the next
  int plane_count;   // MULTUM_MOMENT_PLANES and those of features
  int level_count;   // levels that are averaged
  int column_count;  // of them all
  float slope_z_min;
  int shortened;  // not 0: a normal's length is its BRDF's mean cosine
  int unused[2];
} MultumMomentBand;

// A level that is averaged, and where the rows of it go that a band finishes: [plane][row][column].
typedef struct MultumMomentLevel {
  int width;
  int height;
  int first_column;  // among the columns of all levels
  int first_row;     // the row that is being summed when the band begins
  int row_count;     // rows that the band finishes
  int first_value;   // of them, among the values of all levels
  float share;       // of a finest texel in an average: its weight
  int unused;
} MultumMomentLevel;

// What a column of a level covers of a row: some nodes.
typedef struct MultumMomentTap {
  int node;
  float weight;
} MultumMomentTap;

// Moments as a filter gives them, all of them multiplied by `share`, the part of the filter's weights that fell on
// stored levels; the rest, map_share, fell on the normal map itself.
typedef struct MultumFilteredMoments {
  float normal_x, normal_y, normal_z, share;
  float s, t, ss, tt;
  float st, unused[3];
  float map_x, map_y, map_z, map_share;
} MultumFilteredMoments;

// How moments are shaded (docs/ALGORITHMS.md, "Moments").
#define MULTUM_SHADE_TOKSVIG 0
#define MULTUM_SHADE_LEAN 1
#define MULTUM_SHADE_LEAN_JACOBIAN 2

#endif
