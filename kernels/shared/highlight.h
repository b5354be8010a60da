// SPDX-License-Identifier: Apache-2.0
// A BRDF's facets, as the host passes them to the shading kernels. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_HIGHLIGHT_H
#define MULTUM_KERNELS_SHARED_HIGHLIGHT_H

#define MULTUM_HIGHLIGHT_TERMS 4

// The function f(n . h), which is Blinn-Phong or a sum of term_count vMFs. Each vMF is a weight times a density of
// spread 1 - A(kappa).
typedef struct MultumHighlight {
  float exponent;  // the exponent s of f if f is Blinn-Phong, otherwise that of an equally wide Blinn-Phong
  float total;     // the integral of f over the sphere; 1 for Blinn-Phong
  int term_count;  // 1..4; 0 means Blinn-Phong
  int unused;
  float weights[MULTUM_HIGHLIGHT_TERMS], spreads[MULTUM_HIGHLIGHT_TERMS];
} MultumHighlight;

#endif
