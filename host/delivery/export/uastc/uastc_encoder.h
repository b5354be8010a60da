// SPDX-License-Identifier: Apache-2.0
// Encodes textures as UASTC, a format of Basis Universal with 8 bits per texel that loaders convert to a format of the
// GPU. Runs an npm package in Node.js. Both must be installed separately.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/delivery/export/uastc/level_file.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct UastcSettings {
  std::string option;   // the option that selects UASTC, such as "--format", for messages
  std::string folder;   // folder for files that the programs exchange
  std::string encoder;  // folder of the package, or of the node_modules that contains it; if empty, node's search path
                        // is used
  int effort = 1;       // Basis Universal effort, 0..3; a higher effort tries more codings of a block
  int threads = 1;
  // True if RGB are normals. Each block then uses the coding with the lowest angle error, and encoding takes two to
  // three times as long.
  bool has_normals = false;
};

/// Throws Error(kEnvironment) with installation advice if Node.js or ktx2-encoder is missing.
void check_uastc_encoder(const UastcSettings& settings);

/// Returns 16-byte blocks per level, level 0 first. `decoded` receives the texels that a reader decodes, and may be
/// null. Throws Error(kEnvironment) if the encoder fails, and Cancelled.
std::vector<std::vector<std::uint8_t>> encode_uastc(const LevelFile& levels, const UastcSettings& settings,
                                                    Progress* progress, const LevelFile* decoded = nullptr);

}  // namespace multum
