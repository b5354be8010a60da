// SPDX-License-Identifier: Apache-2.0
// Prepares an environment for shading, once.
#pragma once

#include <memory>
#include <utility>

#include "host/light/harmonics.h"
#include "host/light/light_samples.h"
#include "host/light/prefiltered_levels.h"

namespace multum {

/// Larger maps are shrunk: a texel of 0.7 degrees.
constexpr int kEnvironmentWidthMax = 512;

struct EnvironmentLight {
  EnvironmentMap map;        // as it was read: what is seen of it
  PrefilteredLevels levels;  // level 0: the map, shrunk
  EnvironmentMap small;      // for half_vector_light()
  SmoothEnvironment smooth;
  LightSampler sampler;
};

inline std::shared_ptr<const EnvironmentLight> make_environment_light(EnvironmentMap map) {
  const EnvironmentMap shown = shrink(map, kEnvironmentWidthMax);
  return std::make_shared<const EnvironmentLight>(EnvironmentLight{std::move(map), prefilter(shown), shrink(shown, 64),
                                                                   smooth_environment(shown), LightSampler(shown)});
}

}  // namespace multum
