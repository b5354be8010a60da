// SPDX-License-Identifier: Apache-2.0
// Arguments of kernels/one_lobe.cl. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_ONE_LOBE_H
#define MULTUM_KERNELS_SHARED_ONE_LOBE_H

// Planes of the finest texels whose averages a fit begins with: the normal, and products of its components. That of z
// with itself is 1 less those of x and y.
#define MULTUM_ONE_LOBE_NORMAL 0  // x, y, z
#define MULTUM_ONE_LOBE_XX 3
#define MULTUM_ONE_LOBE_YY 4
#define MULTUM_ONE_LOBE_XY 5
#define MULTUM_ONE_LOBE_XZ 6
#define MULTUM_ONE_LOBE_YZ 7
#define MULTUM_ONE_LOBE_PLANES 8
// Behind those planes, as the fit takes them: alpha^2 of the base roughness, averaged.
#define MULTUM_ONE_LOBE_BASE 8
#define MULTUM_ONE_LOBE_AVERAGES 9

// Planes of a fitted texel.
#define MULTUM_ONE_LOBE_FITTED_NORMAL 0  // x, y, z, a unit vector
#define MULTUM_ONE_LOBE_ALPHA_WIDE 3     // along the axis
#define MULTUM_ONE_LOBE_ALPHA_NARROW 4   // across it
#define MULTUM_ONE_LOBE_AXIS 5           // x, y of a unit vector; of no sign
#define MULTUM_ONE_LOBE_FITTED 7

// Texels whose slopes lie side by side, sample after sample: a cache holds them over all steps of a fit, where planes
// of slopes, a power of two apart, would drive one another out of it. A multiple of every vector width.
#define MULTUM_ONE_LOBE_BLOCK 16

// Texels of a level that are fitted at once, and the samples of each: grid * grid places, evenly spread over what it
// covers of the finest texels, with a half vector each.
typedef struct MultumOneLobePiece {
  int map_width;  // of the finest level
  int width;      // of the level that is fitted
  int row_count;  // of it
  int grid;       // samples along a side of a texel, a power of two; 0: none, the closed form is the result
  int stride;     // from one plane of texels to the next: row_count * width, rounded up to whole blocks
  int iteration_count;
  int is_anisotropic;
  int has_base_map;    // alpha^2 of the finest texels is a plane; else base_squared is that of all
  float base_squared;  // alpha^2
  float alpha_min;     // 0 < alpha_min <= alpha <= 1
} MultumOneLobePiece;

#endif
