// SPDX-License-Identifier: Apache-2.0
// The arguments of kernels/moments.cl and kernels/moment_shade.cl. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOMENTS_H
#define MULTUM_KERNELS_SHARED_MOMENTS_H

// The averaged planes. The first planes are the moments of slopes b = -(n_x, n_y) / n_z, followed by the normal, and
// then by features if there are any, three planes at a time.
#define MULTUM_MOMENT_S 0
#define MULTUM_MOMENT_T 1
#define MULTUM_MOMENT_SS 2
#define MULTUM_MOMENT_TT 3
#define MULTUM_MOMENT_ST 4
#define MULTUM_MOMENT_NORMAL 5
#define MULTUM_MOMENT_PLANES 8

// Filtered moments. All are multiplied by `share`, the part of the filter's weights on stored levels. The rest of the
// weights, map_share, is on the normal map.
typedef struct MultumFilteredMoments {
  float normal_x, normal_y, normal_z, share;
  float s, t, ss, tt;
  float st, unused[3];
  float map_x, map_y, map_z, map_share;
} MultumFilteredMoments;

// The shading methods of moments (docs/contributing/ALGORITHMS.md, "Moments").
#define MULTUM_SHADE_TOKSVIG 0
#define MULTUM_SHADE_LEAN 1
#define MULTUM_SHADE_LEAN_JACOBIAN 2

#endif
