// SPDX-License-Identifier: Apache-2.0
// Encodes fitted textures as images that a glTF file can hold.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "host/delivery/export/accuracy/storage_error.h"
#include "host/delivery/export/uastc/uastc_encoder.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// A plain image of level 0, for loaders that cannot read the texture.
struct FallbackImage {
  std::string file;  // PNG file; empty if the source image has the same texels
  std::uint64_t byte_count = 0;
};

struct EncodedTexture {
  std::string file;
  std::string type;  // media type, such as "image/ktx2"
  std::uint64_t byte_count = 0;
  std::string format = {};     // name in choices and reports, such as "uastc", or "bc" for lobes
  double storage_error = 0.0;  // amount by which the format increases the relative L1 error of the light, at the worst
                               // level
  double refused_error = 0.0;  // the same amount for blocks that were rejected
  std::string refused_format = "uastc";
  std::optional<FallbackImage> fallback = {};
};

/// The largest error that blocks may add, unless the user chose a format. If the error is larger, 8 bits per channel
/// are stored.
constexpr double kStorageErrorMax = 0.003;

struct TextureEncoding {
  GltfTextureFormat format = GltfTextureFormat::kAuto;
  bool has_fallback = false;  // true to add a fallback for every format
  bool is_original = false;   // true if level 0 is the unchanged image of the file, which is then the fallback
  UastcSettings uastc;
  // Measures the change of the light that the material reflects if `decoded` levels replace the texture's own levels.
  std::function<StorageError(const LevelFile& decoded)> measure;
};

/// Writes the encoded files next to the file of the levels. Throws Error(kEnvironment) and Cancelled.
EncodedTexture encode_texture(const LevelFile& levels, const TextureEncoding& how, Progress* progress);

}  // namespace multum
