// SPDX-License-Identifier: Apache-2.0
// The arguments of kernels/mip_box.cl. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MIP_BOX_H
#define MULTUM_KERNELS_SHARED_MIP_BOX_H

// A band of rows of the map. A row of a plane has `row_length` nodes. These are its texels, then sums of 2 texels, of 4
// texels, and so on.
typedef struct MultumBoxBand {
  int map_width;
  int map_height;
  int first_row;  // first row of the band in the map
  int row_count;
  int row_length;  // distance from one row's nodes to the next
  int plane_count;
  int level_count;   // number of averaged levels
  int column_count;  // columns of all these levels together
} MultumBoxBand;

// An averaged level, and the place of the rows that a band finishes: [plane][row][column].
typedef struct MultumBoxLevel {
  int width;
  int height;
  int first_column;  // index among the columns of all levels
  int first_row;     // the unfinished row when the band begins
  int row_count;     // number of rows that the band finishes
  int first_value;   // index of the first value of these rows among the values of all levels
  float share;       // weight of a finest texel in an average
  int unused;
} MultumBoxLevel;

// One of the nodes of a row that a level's column covers.
typedef struct MultumBoxTap {
  int node;
  float weight;
} MultumBoxTap;

#endif
