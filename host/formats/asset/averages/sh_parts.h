// SPDX-License-Identifier: Apache-2.0
// The parts of baked files of spherical harmonics, for the reader and the writer of these files.
#pragma once

#include <vector>

#include "host/formats/asset/baked_header.h"

namespace multum {

inline constexpr char kShOrderAttribute[] = "multum:shOrder";

std::vector<BakedPart> sh_parts(const BakedHeader& header, int order);

}  // namespace multum
