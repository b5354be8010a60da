// SPDX-License-Identifier: Apache-2.0
// Constants of the refinement of lobes, which kernel and reference share. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOVMF_REFINE_H
#define MULTUM_KERNELS_SHARED_MOVMF_REFINE_H

// Highlights that lobes are refined for: Blinn-Phong of exponent s. By their squares a sharp highlight would outweigh a
// broad one by the ratio of their exponents, so that each counts 1/s; the broadest and the sharpest one less: the one
// differs little between fits, and what the other shows most of is single normals, which no few lobes follow.
#define MULTUM_REFINE_BRDFS 3
#define MULTUM_REFINE_EXPONENTS \
  { 20.0f, 100.0f, 500.0f }
#define MULTUM_REFINE_WEIGHTS \
  { 0.15f / 20.0f, 1.0f / 100.0f, 0.24f / 500.0f }
// 1 - c^2 = (2 s + 3)/(s + 2)^2 of the mean cosine c = (s + 1)/(s + 2).
#define MULTUM_REFINE_SPREADS \
  { 43.0f / 484.0f, 203.0f / 10404.0f, 1003.0f / 252004.0f }

// Steps, and how far the diagonal is raised in each; one that does not lower the energy is cut to this share.
#define MULTUM_REFINE_STEPS 10
#define MULTUM_REFINE_DAMPING 0.1f
#define MULTUM_REFINE_STEP_CUT 0.25f
// An energy that is higher by no more than single precision rounds it is no reason to take a step back.
#define MULTUM_REFINE_ENERGY_ROUNDING 1e-6f
#define MULTUM_REFINE_ENERGY_MAX 3e38f
// Weight of what is seen midway to each of the four texels beside, where the texel's centre has 1. Without it lobes
// come nearer at centres and lose alignment.
#define MULTUM_REFINE_MIDWAY_WEIGHT 0.4f
// Weight of the mean normal, which diffuse light shows, and of the sum of amplitudes beside the highlights. A mean
// normal that is held exactly costs highlights more than half of what refining brings at centres.
#define MULTUM_REFINE_MOMENT_WEIGHT 1.5f
// Pooled lobes shorter than this turn as if they were as long.
#define MULTUM_REFINE_LENGTH_MIN 0.02f
// Raises the diagonal of lobes without weight, which would be 0.
#define MULTUM_REFINE_DIAGONAL_MIN 1e-6f
// An amplitude keeps at least this share in a step; kappa changes by at most a factor e, and a lobe turns by at most
// its width, sqrt(1 - |r| + MULTUM_REFINE_TURN_MIN).
#define MULTUM_REFINE_SHARE_MIN 0.3f
#define MULTUM_REFINE_TURN_MIN 0.01f
// A lobe is not widened to a spread 1 - |r| above this: it would have no direction.
#define MULTUM_REFINE_SPREAD_MAX 0.95f
#define MULTUM_REFINE_KAPPA_MIN 0.05f
// Directions (x, y) in which EM's lobes and the refined ones are compared, z above 0: evenly over the disc of radius
// sqrt(3/4), by the golden angle, which is about where half vectors of lights and views above a surface lie.
#define MULTUM_REFINE_LOOKS 24
#define MULTUM_REFINE_LOOK_XY                                                                                    \
  {                                                                                                              \
    {0.1250f, 0.0000f}, {-0.1596f, 0.1462f}, {0.0244f, -0.2784f}, {0.2012f, 0.2625f}, {-0.3693f, -0.0653f},      \
        {0.3498f, -0.2225f}, {-0.1170f, 0.4352f}, {-0.2231f, -0.4296f}, {0.4841f, 0.1768f}, {-0.5036f, 0.2079f}, \
        {0.2428f, -0.5188f}, {0.1794f, 0.5720f}, {-0.5408f, -0.3134f}, {0.6344f, -0.1395f}, {-0.3871f, 0.5507f}, \
        {-0.0894f, -0.6902f}, {0.5491f, 0.4628f}, {-0.7389f, 0.0306f}, {0.5390f, -0.5363f}, {-0.0361f, 0.7798f}, \
        {-0.5128f, -0.6145f}, {0.8124f, 0.1093f}, {-0.6883f, 0.4789f}, {                                         \
      0.1881f, -0.8361f                                                                                          \
    }                                                                                                            \
  }
// Refined lobes stay whose error is up to this times EM's: beside refined ones, those of EM fit less well (four-quarter
// map of 1024, 4 lobes, s = 100, midway in x at level 3: 9.8 % with 1). A level's only texel has none beside: 1.
#define MULTUM_REFINE_LOOK_SLACK 1.1f
// Highlights below this, of exponents that no direction shows, are equal.
#define MULTUM_REFINE_SEEN_MIN 1e-6f
// Smallest amplitude inside; of less a step would know nothing.
#define MULTUM_REFINE_AMPLITUDE_MIN 1e-5f

#endif
