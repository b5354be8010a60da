// SPDX-License-Identifier: Apache-2.0
// Decodes blocks of 4 x 4 texels as kernels/block_encoding.cl makes them: BC4, BC5, and modes 1, 4, 5 and 6 of BC7
// (Khronos Data Format Specification 1.3, chapters 18 and 20). Errors can therefore be measured on the stored values.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec4.hpp>

#include "host/delivery/export/texel_format.h"

namespace multum {

/// Texels row by row, with red, green, blue and alpha from 0 to 1, as shaders see them. Missing green and blue are 0,
/// missing alpha is 1.
using BlockTexels = std::array<glm::vec4, 16>;

/// Decodes one block of block_bytes bytes in a block format. A BC7 mode other than 1, 4, 5 and 6 stops the program.
BlockTexels decode_block(TexelFormat format, const std::uint8_t* block);

}  // namespace multum
