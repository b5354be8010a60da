// SPDX-License-Identifier: Apache-2.0
// Prepares an environment for shading; once, or as it changes.
#pragma once

#include <memory>

#include "host/formats/light/harmonics.h"
#include "host/formats/light/light_samples.h"
#include "host/formats/light/prefiltered_levels.h"

namespace multum {

/// Larger maps are shrunk: a texel of 0.7 degrees.
constexpr int kEnvironmentWidthMax = 512;

struct EnvironmentLight {
  EnvironmentMap map;        // as it was read: what is seen of it
  PrefilteredLevels levels;  // level 0: the map, shrunk
  EnvironmentMap small;      // for half_vector_light()
  SmoothEnvironment smooth;
  LightSampler sampler;
  double processor_seconds = 0.0;  // that making it took
};

std::shared_ptr<const EnvironmentLight> make_environment_light(EnvironmentMap map);

/// What make_environment_light() makes of (1 - share) a + share b, for the cost of mixing what was made of each:
/// levels, harmonics and sums are linear in the light (Han et al. 2007, section 8, of light that changes). `a` and `b`
/// are of one size; at shares of 0 and 1 they are returned.
std::shared_ptr<const EnvironmentLight> mix_environments(const std::shared_ptr<const EnvironmentLight>& a,
                                                         const std::shared_ptr<const EnvironmentLight>& b,
                                                         double share);

}  // namespace multum
