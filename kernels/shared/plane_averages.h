// SPDX-License-Identifier: Apache-2.0
// What the host hands to kernels/plane_averages.cl, and to the kernels that make the planes. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_PLANE_AVERAGES_H
#define MULTUM_KERNELS_SHARED_PLANE_AVERAGES_H

// A band of rows of the map. A row of a plane is `row_length` nodes: its texels, then the sums of 2, of 4, ... of them.
typedef struct MultumAverageBand {
  int map_width;
  int map_height;
  int first_row;  // of the map
  int row_count;
  int row_length;    // from one row's nodes to the next
  int plane_count;   // with 3 for colours, if there are any
  int level_count;   // levels that are averaged
  int column_count;  // of them all
} MultumAverageBand;

// A level that is averaged, and where the rows of it go that a band finishes: [plane][row][column].
typedef struct MultumAverageLevel {
  int width;
  int height;
  int first_column;  // among the columns of all levels
  int first_row;     // the row that is being summed when the band begins
  int row_count;     // rows that the band finishes
  int first_value;   // of them, among the values of all levels
  float share;       // of a finest texel in an average: its weight
  int unused;
} MultumAverageLevel;

// What a column of a level covers of a row: some nodes.
typedef struct MultumAverageTap {
  int node;
  float weight;
} MultumAverageTap;

#endif
