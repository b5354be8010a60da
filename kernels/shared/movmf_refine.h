// SPDX-License-Identifier: Apache-2.0
// Constants of the refinement of lobes, which kernel and reference share. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOVMF_REFINE_H
#define MULTUM_KERNELS_SHARED_MOVMF_REFINE_H

// Highlights that lobes are refined for: Blinn-Phong of exponent s. By their squares a sharp highlight would outweigh a
// broad one by the ratio of their exponents, so that each counts 1/s; the sharpest one less, because what it shows most
// of is single normals, which no few lobes follow (four-quarter map, s = 100, level 3: 10.5 % with 0.3/s, 10.9 with
// 1/s).
#define MULTUM_REFINE_BRDFS 3
#define MULTUM_REFINE_EXPONENTS \
  { 20.0f, 100.0f, 500.0f }
#define MULTUM_REFINE_WEIGHTS \
  { 1.0f / 20.0f, 1.0f / 100.0f, 0.3f / 500.0f }
// 1 - c^2 = (2 s + 3)/(s + 2)^2 of the mean cosine c = (s + 1)/(s + 2).
#define MULTUM_REFINE_SPREADS \
  { 43.0f / 484.0f, 203.0f / 10404.0f, 1003.0f / 252004.0f }

// Steps, and how far the diagonal is raised in each. More and bolder steps come nearer at texel centres, lose alignment
// and with it what lies midway: 20 steps with 0.1 take level 3 to 9.8 % at centres, and midway from 10.3 to 11.5.
#define MULTUM_REFINE_STEPS 6
#define MULTUM_REFINE_DAMPING 0.5f
// Weight of the mean normal, which diffuse light shows, and of the sum of amplitudes beside the highlights. It is in
// the diagonal too, where it holds lobes near their start.
#define MULTUM_REFINE_MOMENT_WEIGHT 10.0f
// Raises the diagonal of lobes without weight, which would be 0.
#define MULTUM_REFINE_DIAGONAL_MIN 1e-6f
// An amplitude keeps at least this share in a step; kappa changes by at most a factor e, and a lobe turns by at most
// its width, sqrt(1 - |r| + MULTUM_REFINE_TURN_MIN).
#define MULTUM_REFINE_SHARE_MIN 0.3f
#define MULTUM_REFINE_TURN_MIN 0.01f
// A lobe is not widened to a spread 1 - |r| above this: it would have no direction.
#define MULTUM_REFINE_SPREAD_MAX 0.95f
#define MULTUM_REFINE_KAPPA_MIN 0.05f
// Smallest amplitude inside; of less a step would know nothing.
#define MULTUM_REFINE_AMPLITUDE_MIN 1e-5f

#endif
