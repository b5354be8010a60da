// SPDX-License-Identifier: Apache-2.0
// Decodes blocks of UASTC LDR 4x4, the texels of KHR_texture_basisu that multum gltf writes ("UASTC LDR 4x4 Texture
// Specification", Basis Universal). The format repacks 19 modes of ASTC blocks, with partitions that BC7 also has.
#pragma once

#include <cstdint>

namespace multum {

constexpr int kUastcBlockBytes = 16, kUastcBlockSide = 4;

/// Writes 16 RGBA texels, row by row. If the mode is not a UASTC mode, returns false and writes nothing.
bool decode_uastc_block(const std::uint8_t* block, std::uint8_t* rgba);

}  // namespace multum
