// SPDX-License-Identifier: Apache-2.0
// Decodes blocks of 4 x 4 texels as kernels/block_encoding.cl makes them: BC4, BC5, and of BC7 the modes 1, 4, 5 and 6
// (Khronos Data Format Specification 1.3, chapters 18 and 20). So that errors are measured of what is stored.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec4.hpp>

#include "host/delivery/export/texel_format.h"

namespace multum {

/// Row by row; red, green, blue, alpha from 0 to 1, as shaders see them: 0, 0 and 1 where there are no such channels.
using BlockTexels = std::array<glm::vec4, 16>;

/// `format`: one of blocks; `block`: block_bytes of it. Modes that are not ours stop the program.
BlockTexels decode_block(TexelFormat format, const std::uint8_t* block);

}  // namespace multum
