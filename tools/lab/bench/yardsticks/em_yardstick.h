// SPDX-License-Identifier: Apache-2.0
// The yardstick for the EM kernels. It computes the same sums in plain, readable C++ with OpenMP, and uses vectors that
// are as wide as a register (GCC's vector extensions, compiled for AVX-512 and for AVX2).
#pragma once

#include <cstddef>
#include <vector>

#include "tools/lab/bench/measuring/instructions.h"

namespace multum::bench {

/// Contains samples and starting lobes in the layouts of the kernels (kernels/shared/movmf_fit.h). There are only whole
/// texels, so there are no weights.
struct YardstickLevel {
  int lobe_count;
  int iteration_count;
  int group_count;       // number of groups, of 16 texels each
  int sample_count;      // samples per texel
  const float* samples;  // [group][sample][3][16]; if null, the planes are used, and texels are fitted one after
                         // another
  const float* start;    // [group][lobe][MULTUM_START_PLANES][16]
  float kappa_cap;
  float kappa_cap_slope;
  // Planes for coarse levels, in which each texel is a rectangle of the planes.
  const float* plane_x = nullptr;
  const float* plane_y = nullptr;
  const float* plane_z = nullptr;
  int map_width = 0;
  int level_width = 0;
  int texel_count = 0;
  int texel_side = 0;  // number of finest texels along a side of a texel
};

/// Returns (r_x, r_y, r_z, a) of [lobe][texel slot]. Runs the build for `instructions`, which the processor must
/// support.
std::vector<float> fit_with_yardstick(const YardstickLevel& level, Instructions instructions);

}  // namespace multum::bench
