// SPDX-License-Identifier: Apache-2.0
// Rounds a texel's lobes in the simplest form: tries every rounding, as docs/reference/file_format.md ("Rounding")
// describes. This is the reference of host/formats/asset/lobes/movmf_quantize.cpp. No bake uses it.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum::reference {

/// Rounds the lobes of one texel, each given as a (r, 1). `encoding` is kSnorm16 or kHalf.
std::vector<glm::vec4> round_texel(const std::vector<glm::vec4>& lobes, StorageEncoding encoding);

}  // namespace multum::reference
