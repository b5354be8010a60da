// SPDX-License-Identifier: Apache-2.0
// Launches mip_blocks on rows of texels. Private to host/lab/selftest and its tests.
#pragma once

#include <vector>

#include "host/bakes/pyramid/row_blocks.h"
#include "host/formats/opencl/device.h"

namespace multum {

/// Returns the nodes of each row. The nodes are the texels of the row and the sums of blocks of texels.
std::vector<std::vector<float>> block_sums(Device& device, const RowBlocks& blocks,
                                           const std::vector<std::vector<float>>& rows);

}  // namespace multum
