// SPDX-License-Identifier: Apache-2.0
// Rounds a texel's lobes by trying every rounding, as docs/reference/file_format.md ("Rounding") describes. This code
// is the reference for host/formats/asset/lobes/movmf_quantize.cpp. No bake uses it.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum::reference {

/// Rounds the lobes of one texel. Each lobe is given as a (r, 1). `encoding` is kSnorm16 or kHalf.
std::vector<glm::vec4> round_texel(const std::vector<glm::vec4>& lobes, StorageEncoding encoding);

}  // namespace multum::reference
