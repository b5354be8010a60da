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
  std::string file;  // PNG; empty: the image that the texture was made from has the same texels
  std::uint64_t byte_count = 0;
};

struct EncodedTexture {
  std::string file;
  std::string type;  // "image/ktx2"
  std::uint64_t byte_count = 0;
  std::string format = {};     // "uastc", as choices and reports name it; of lobes "bc"
  double storage_error = 0.0;  // what the format adds to the error of the light, relative L1, of the worst level
  double refused_error = 0.0;  // what blocks would have added, where they were tried and are not taken
  std::string refused_format = "uastc";
  std::optional<FallbackImage> fallback = {};
};

/// What blocks may add before 8 bits a channel are stored, where the user did not ask for either.
constexpr double kStorageErrorMax = 0.003;

struct TextureEncoding {
  GltfTextureFormat format = GltfTextureFormat::kAuto;
  bool has_fallback = false;  // whatever the format
  bool is_original = false;   // level 0 is an image's as it is in the file: it is the fallback
  UastcSettings uastc;
  // The material's light with `decoded` levels in place of the texture's, against that with its own.
  std::function<StorageError(const LevelFile& decoded)> measure;
};

/// Writes files beside the levels'. Throws Error(kEnvironment), Cancelled.
EncodedTexture encode_texture(const LevelFile& levels, const TextureEncoding& how, Progress* progress);

}  // namespace multum
