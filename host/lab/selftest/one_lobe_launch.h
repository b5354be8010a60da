// SPDX-License-Identifier: Apache-2.0
// Launches the kernels of one_lobe.cl with the inputs of a case. Private to host/lab/selftest and its tests.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "host/formats/opencl/device.h"
#include "host/lab/reference/one_lobe.h"

namespace multum {

/// Returns the lobe of the single texel in a map's coarsest level. `lanes` is the number of lanes of one_lobe_fit, 1 or
/// 16.
reference::OneLobe launch_one_lobe(Device& device, const reference::OneLobeTexel& texel,
                                   const std::vector<glm::vec2>& facets, int grid, int lanes);

}  // namespace multum
