// SPDX-License-Identifier: Apache-2.0
// Defines constants for the refinement of lobes, which the kernel and its reference share. This file is valid OpenCL C
// and C++.
#ifndef MULTUM_KERNELS_SHARED_MOVMF_REFINE_H
#define MULTUM_KERNELS_SHARED_MOVMF_REFINE_H

// Lobes are refined for these highlights, which are Blinn-Phong with exponents s. Squared errors of a sharp highlight
// would outweigh those of a broad one by the ratio of their exponents, so each highlight is weighted by 1/s. The
// broadest and the sharpest highlights have even less weight. The broadest differs little between fits, and the
// sharpest mainly shows single normals, which a few lobes cannot represent.
#define MULTUM_REFINE_BRDFS 3
#define MULTUM_REFINE_EXPONENTS \
  { 20.0f, 100.0f, 500.0f }
#define MULTUM_REFINE_WEIGHTS \
  { 0.15f / 20.0f, 1.0f / 100.0f, 0.24f / 500.0f }
// The value of 1 - c^2 = (2 s + 3)/(s + 2)^2, for the mean cosine c = (s + 1)/(s + 2).
#define MULTUM_REFINE_SPREADS \
  { 43.0f / 484.0f, 203.0f / 10404.0f, 1003.0f / 252004.0f }

// The number of steps, and the factor by which each step raises the diagonal. A step that does not lower the energy is
// cut to MULTUM_REFINE_STEP_CUT of its size.
#define MULTUM_REFINE_STEPS 10
#define MULTUM_REFINE_DAMPING 0.1f
#define MULTUM_REFINE_STEP_CUT 0.25f
// A step is not undone if it raises the energy by no more than single-precision rounding.
#define MULTUM_REFINE_ENERGY_ROUNDING 1e-6f
#define MULTUM_REFINE_ENERGY_MAX 3e38f
// The weight of each point midway to one of the four adjacent texels. The texel's centre has weight 1. Without these
// points, errors at centres are lower, but lobes lose their alignment.
#define MULTUM_REFINE_MIDWAY_WEIGHT 0.4f
// The weight, relative to highlights, of the mean normal and of the sum of amplitudes. Diffuse light depends on the
// mean normal. If the mean normal were kept exactly, highlights would lose more than half of what the refinement gains
// at centres.
#define MULTUM_REFINE_MOMENT_WEIGHT 1.5f
// The derivatives of the direction of an averaged lobe are divided by the length of its mean vector, but at least by
// this length.
#define MULTUM_REFINE_LENGTH_MIN 0.02f
// The least diagonal entry. Otherwise, the entries of lobes without weight would be 0.
#define MULTUM_REFINE_DIAGONAL_MIN 1e-6f
// In one step, an amplitude keeps at least this share of its value, kappa changes by at most a factor e, and a lobe
// turns by at most its width, sqrt(1 - |r| + MULTUM_REFINE_TURN_MIN).
#define MULTUM_REFINE_SHARE_MIN 0.3f
#define MULTUM_REFINE_TURN_MIN 0.01f
// The largest spread 1 - |r| to which a step may widen a lobe. A wider lobe would have no direction.
#define MULTUM_REFINE_SPREAD_MAX 0.95f
#define MULTUM_REFINE_KAPPA_MIN 0.05f
// The directions (x, y), with z above 0, in which EM's lobes and the refined lobes are compared. The golden angle
// spreads them evenly over the disc of radius sqrt(3/4). This is about where the half vectors of lights and views above
// a surface are.
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
// Refined lobes are kept if their error is at most this factor times the error of EM's lobes. The factor is above 1,
// because EM's lobes mix less well with refined neighbours. With a factor of 1, the error would rise to 9.8 % (a map of
// four quarters, 1024 texels wide, 4 lobes, s = 100, midway in x at level 3). If a level has only one texel, there are
// no neighbours and the factor is 1.
#define MULTUM_REFINE_LOOK_SLACK 1.1f
// The least brightness by which the errors of highlights are divided. Darker highlights are invisible in every
// direction.
#define MULTUM_REFINE_SEEN_MIN 1e-6f
// The least amplitude inside the refinement. A smaller amplitude would have no gradient.
#define MULTUM_REFINE_AMPLITUDE_MIN 1e-5f

#endif
