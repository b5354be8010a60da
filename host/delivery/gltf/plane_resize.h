// SPDX-License-Identifier: Apache-2.0
// Enlarges three planes as a sampler's linear filter does, so that maps of one material have one size.
#pragma once

#include <functional>

#include "host/formats/image/plane_store.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

struct ResizeSettings {
  int width = 1, height = 1;                                            // after; at least those before
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;  // beyond the borders
  SpillPolicy spill;
  int threads = 1;
};

/// `finish` is called for each texel's three values after.
PlaneStore enlarged_planes(const PlaneStore& planes, const ResizeSettings& settings,
                           const std::function<void(float& a, float& b, float& c)>& finish);

}  // namespace multum
