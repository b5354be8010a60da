// SPDX-License-Identifier: Apache-2.0
// Defines one von Mises-Fisher lobe in the kernels' format. For planar Gaussians, mean_x and mean_y are the mean of
// (n_x, n_y), and mean_z is sigma^2. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_VMF_LOBE_H
#define MULTUM_KERNELS_SHARED_VMF_LOBE_H

typedef struct MultumVmfLobe {
  float mean_x;  // r = mean vector of the normals, |r| <= 1; r has the lobe's direction, and 1 - |r| is its spread
  float mean_y;
  float mean_z;
  float amplitude;  // share of the texel's normals; the lobes of a texel sum to 1
} MultumVmfLobe;

#endif
