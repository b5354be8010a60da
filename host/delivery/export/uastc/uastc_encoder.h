// SPDX-License-Identifier: Apache-2.0
// Encodes textures as UASTC (Basis Universal's format of 8 bits a texel, which loaders turn into what a GPU has) by an
// npm package that Node.js runs: a tool of the machine, no part of this program.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/delivery/export/uastc/level_file.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct UastcSettings {
  std::string option;   // of the command that asks for it, "--format": what messages name
  std::string folder;   // for files between the programs
  std::string encoder;  // folder of the package, or of the node_modules with it; empty: looked for where node does
  int effort = 1;       // of Basis Universal, 0..3: how many ways to code a block are tried
  int threads = 1;
  // RGB are normals: of several codings each block takes the one that turns them least. Two to three times as slow.
  bool has_normals = false;
};

/// Throws Error(kEnvironment): there is no Node.js, or it does not find ktx2-encoder; says what to install.
void check_uastc_encoder(const UastcSettings& settings);

/// Blocks of 16 bytes a level, level 0 first. `decoded`: gets what a reader finds in them; null: nobody asks. Throws
/// Error(kEnvironment) where the tool fails, Cancelled.
std::vector<std::vector<std::uint8_t>> encode_uastc(const LevelFile& levels, const UastcSettings& settings,
                                                    Progress* progress, const LevelFile* decoded = nullptr);

}  // namespace multum
