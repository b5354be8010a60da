// SPDX-License-Identifier: Apache-2.0
// Launches mip_blocks on rows of texels. Private to host/selftest and its tests.
#pragma once

#include <vector>

#include "host/opencl/device.h"
#include "host/pyramid/row_blocks.h"

namespace multum {

/// The nodes of each row: its texels and the sums of their blocks.
std::vector<std::vector<float>> block_sums(Device& device, const RowBlocks& blocks,
                                           const std::vector<std::vector<float>>& rows);

}  // namespace multum
