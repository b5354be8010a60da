// SPDX-License-Identifier: Apache-2.0
// The parts of baked files of moments, for the reader and the writer of these files.
#pragma once

#include <vector>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/baked_header.h"

namespace multum {

enum class MomentPart { kSlopes, kNormal, kColour, kWeights };

/// Returns the kind of each part, in the file's order.
std::vector<MomentPart> moment_part_kinds(const BakedHeader& header);

std::vector<BakedPart> moment_parts(const BakedHeader& header);

/// Returns the values of one part of `rows`.
const float* moment_part_values(const MomentLevel& rows, MomentPart kind);

}  // namespace multum
