// SPDX-License-Identifier: Apache-2.0
// Enlarges three planes with a sampler's linear filter, so that all maps of a material have the same size.
#pragma once

#include <functional>

#include "host/formats/image/plane_store.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

struct ResizeSettings {
  int width = 1, height = 1;                                            // new size, not smaller than the old one
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;  // apply beyond the borders
  SpillPolicy spill;
  int threads = 1;
};

/// Calls `finish` with the three resulting values of each texel.
PlaneStore enlarged_planes(const PlaneStore& planes, const ResizeSettings& settings,
                           const std::function<void(float& a, float& b, float& c)>& finish);

}  // namespace multum
