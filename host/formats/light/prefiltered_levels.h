// SPDX-License-Identifier: Apache-2.0
// An environment convolved with vMF lobes, one a mip level, so that a lobe of any spread reads it by two levels.
#pragma once

#include <vector>

#include "host/formats/light/environment_map.h"

namespace multum {

struct PrefilteredLevels {
  std::vector<EnvironmentMap> levels;  // level 0 is the map; each next one is half as wide and high
  std::vector<double> spreads;         // 1 - A(kappa) of each: growing
};

/// A level's lobe has a standard deviation of two of its texels, so that bilinear filtering of it is smooth.
PrefilteredLevels prefilter(const EnvironmentMap& map);

}  // namespace multum
