// SPDX-License-Identifier: Apache-2.0
// Encodes fitted textures as images that a glTF file can hold.
#pragma once

#include <cstdint>
#include <string>

#include "host/delivery/export/uastc/uastc_encoder.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

struct EncodedTexture {
  std::string file;
  std::string type;  // "image/ktx2"
  std::uint64_t byte_count = 0;
};

/// Writes a file beside the levels'. Throws Error(kEnvironment), Cancelled.
EncodedTexture encode_texture(const LevelFile& levels, GltfTextureFormat format, const UastcSettings& uastc,
                              Progress* progress);

}  // namespace multum
