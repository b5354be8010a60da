// SPDX-License-Identifier: Apache-2.0
// Rounding of a texel's lobes, written for obviousness: every way to round is tried in the words of
// docs/reference/file_format.md
// ("Rounding"). The oracle of host/formats/asset/lobes/movmf_quantize.cpp. No bake uses it.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum::reference {

/// Lobes of one texel, each a (r, 1), for kSnorm16 or kHalf.
std::vector<glm::vec4> round_texel(const std::vector<glm::vec4>& lobes, StorageEncoding encoding);

}  // namespace multum::reference
