// SPDX-License-Identifier: Apache-2.0
// Defines weights for movmf_choose.cl and its reference implementation, which were tuned on seven maps
// (docs/contributing/ALGORITHMS.md, "Level 1"). This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOVMF_CHOOSE_H
#define MULTUM_KERNELS_SHARED_MOVMF_CHOOSE_H

#define MULTUM_CHOICE_NORMALS 4
// The weight, in texels, of a texel's surroundings (the parent and done neighbours) when lobes are mixed with them.
#define MULTUM_CHOICE_AROUND 3.5f
// The weight of the parent in the surroundings. A neighbour has weight 1.
#define MULTUM_CHOICE_PARENT 3.0f
// The least amplitude for a parent's nearly empty lobes. With this limit, a normal that fits no other lobe goes to the
// nearest of several empty lobes.
#define MULTUM_CHOICE_AMPLITUDE_MIN 0.01f

#endif
