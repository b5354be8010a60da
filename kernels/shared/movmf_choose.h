// SPDX-License-Identifier: Apache-2.0
// Weights that movmf_choose.cl and its reference share, tuned on seven maps (docs/contributing/ALGORITHMS.md, "Level
// 1"). Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOVMF_CHOOSE_H
#define MULTUM_KERNELS_SHARED_MOVMF_CHOOSE_H

#define MULTUM_CHOICE_NORMALS 4
// Weight of a texel's surroundings (the parent and done neighbours) when lobes are mixed with them, in texels.
#define MULTUM_CHOICE_AROUND 3.5f
// Weight of the parent in the surroundings, in neighbours.
#define MULTUM_CHOICE_PARENT 3.0f
// Least amplitude that a parent's nearly empty lobe counts with. So the nearest of several empty lobes takes a normal
// that fits no other.
#define MULTUM_CHOICE_AMPLITUDE_MIN 0.01f

#endif
