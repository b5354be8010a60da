// SPDX-License-Identifier: Apache-2.0
// Prepares an environment for shading, once or whenever it changes.
#pragma once

#include <memory>

#include "host/formats/light/harmonics.h"
#include "host/formats/light/light_samples.h"
#include "host/formats/light/prefiltered_levels.h"

namespace multum {

/// Larger maps are shrunk to this width, at which a texel covers 0.7 degrees.
constexpr int kEnvironmentWidthMax = 512;

struct EnvironmentLight {
  EnvironmentMap map;        // the environment as read, which is visible in pictures
  PrefilteredLevels levels;  // level 0 is the shrunk map
  EnvironmentMap small;      // a small version, for half_vector_light()
  SmoothEnvironment smooth;
  LightSampler sampler;
  double processor_seconds = 0.0;  // time that making this object has taken
};

std::shared_ptr<const EnvironmentLight> make_environment_light(EnvironmentMap map);

/// Returns the same light as make_environment_light() for (1 - share) a + share b, but only mixes the two results. This
/// is exact because levels, harmonics and sums are linear in the light (Han et al. 2007, section 8, changing light).
/// `a` and `b` must have the same size. At shares of 0 and 1, the result is `a` or `b`.
std::shared_ptr<const EnvironmentLight> mix_environments(const std::shared_ptr<const EnvironmentLight>& a,
                                                         const std::shared_ptr<const EnvironmentLight>& b,
                                                         double share);

}  // namespace multum
