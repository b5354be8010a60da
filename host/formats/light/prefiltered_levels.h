// SPDX-License-Identifier: Apache-2.0
// An environment convolved with vMF lobes, one lobe per mip level. A lobe of any spread is interpolated from two
// levels.
#pragma once

#include <vector>

#include "host/formats/light/environment_map.h"

namespace multum {

struct PrefilteredLevels {
  std::vector<EnvironmentMap> levels;  // level 0 is the map; every level is half as wide and high as the previous one
  std::vector<double> spreads;         // 1 - A(kappa) of each level, increasing
};

/// Convolves level by level. The standard deviation of the lobe of a level is two of its texels, so that bilinear
/// filtering is smooth.
PrefilteredLevels prefilter(const EnvironmentMap& map);

}  // namespace multum
