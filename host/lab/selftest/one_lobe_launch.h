// SPDX-License-Identifier: Apache-2.0
// Launches the kernels of one_lobe.cl on what a case says. Private to host/lab/selftest and its tests.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "host/formats/opencl/device.h"
#include "host/lab/reference/one_lobe.h"

namespace multum {

/// The lobe of a map's only texel of its coarsest level. `lanes`: 1 or 16, of one_lobe_fit.
reference::OneLobe launch_one_lobe(Device& device, const reference::OneLobeTexel& texel,
                                   const std::vector<glm::vec2>& facets, int grid, int lanes);

}  // namespace multum
