// SPDX-License-Identifier: Apache-2.0
// Weights that movmf_choose.cl and its reference share, found on seven maps (docs/contributing/ALGORITHMS.md, "Level
// 1"). Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOVMF_CHOOSE_H
#define MULTUM_KERNELS_SHARED_MOVMF_CHOOSE_H

#define MULTUM_CHOICE_NORMALS 4
// What lies around a texel, the parent and done neighbours, counts as so many texels when lobes are mixed with it.
#define MULTUM_CHOICE_AROUND 3.5f
// The parent in it counts as so many neighbours.
#define MULTUM_CHOICE_PARENT 3.0f
// A parent's lobe that is all but empty counts as having this amplitude: of empty lobes the nearest takes a normal that
// fits no other.
#define MULTUM_CHOICE_AMPLITUDE_MIN 0.01f

#endif
