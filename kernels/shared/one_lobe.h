// SPDX-License-Identifier: Apache-2.0
// The arguments of kernels/one_lobe.cl. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_ONE_LOBE_H
#define MULTUM_KERNELS_SHARED_ONE_LOBE_H

// The planes of the finest texels whose averages start a fit. These are the normal, and the products of its components.
// The product z z is 1 minus x x and y y.
#define MULTUM_ONE_LOBE_NORMAL 0  // x, y, z
#define MULTUM_ONE_LOBE_XX 3
#define MULTUM_ONE_LOBE_YY 4
#define MULTUM_ONE_LOBE_XY 5
#define MULTUM_ONE_LOBE_XZ 6
#define MULTUM_ONE_LOBE_YZ 7
#define MULTUM_ONE_LOBE_PLANES 8
// The plane after these in the input of the fit, which has the average of alpha^2 of the base roughness.
#define MULTUM_ONE_LOBE_BASE 8
#define MULTUM_ONE_LOBE_AVERAGES 9

// The planes of a fitted texel.
#define MULTUM_ONE_LOBE_FITTED_NORMAL 0  // x, y, z, a unit vector
#define MULTUM_ONE_LOBE_ALPHA_WIDE 3     // alpha along the axis
#define MULTUM_ONE_LOBE_ALPHA_NARROW 4   // alpha across the axis
#define MULTUM_ONE_LOBE_AXIS 5           // x, y of a unit vector, whose sign has no meaning
#define MULTUM_ONE_LOBE_FITTED 7

// The number of texels whose slopes are interleaved, sample after sample, so that a cache holds them during all steps
// of a fit. Separate planes of slopes would be a power of two apart and would evict one another from the cache. The
// number is a multiple of every vector width.
#define MULTUM_ONE_LOBE_BLOCK 16

// Describes texels of a level that are fitted at once, and their samples. A texel has grid * grid samples, evenly
// spread over the finest texels that it covers. Each sample has one half vector.
typedef struct MultumOneLobePiece {
  int map_width;  // size of the finest level
  int width;      // width of the fitted level
  int row_count;  // number of rows of this level that are fitted
  int grid;       // samples along a side of a texel, a power of two; with 0, there are no samples and the closed form
                  // is the result
  int stride;     // distance between planes of texels: row_count * width, rounded up to whole blocks
  int iteration_count;
  int is_anisotropic;
  int has_base_map;    // if 1, a plane holds alpha^2 of the finest texels; if 0, base_squared is alpha^2 of all texels
  float base_squared;  // alpha^2 of the base roughness
  float alpha_min;     // 0 < alpha_min <= alpha <= 1
} MultumOneLobePiece;

#endif
