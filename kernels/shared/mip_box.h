// SPDX-License-Identifier: Apache-2.0
// Arguments of kernels/mip_box.cl. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MIP_BOX_H
#define MULTUM_KERNELS_SHARED_MIP_BOX_H

// A band of rows of the map. A row of a plane is `row_length` nodes: its texels, then the sums of 2, of 4, ... of them.
typedef struct MultumBoxBand {
  int map_width;
  int map_height;
  int first_row;  // of the map
  int row_count;
  int row_length;  // from one row's nodes to the next
  int plane_count;
  int level_count;   // levels that are averaged
  int column_count;  // of them all
} MultumBoxBand;

// A level that is averaged, and where the rows of it go that a band finishes: [plane][row][column].
typedef struct MultumBoxLevel {
  int width;
  int height;
  int first_column;  // among the columns of all levels
  int first_row;     // the row that is being summed when the band begins
  int row_count;     // rows that the band finishes
  int first_value;   // of them, among the values of all levels
  float share;       // of a finest texel in an average: its weight
  int unused;
} MultumBoxLevel;

// What a column of a level covers of a row: some nodes.
typedef struct MultumBoxTap {
  int node;
  float weight;
} MultumBoxTap;

#endif
