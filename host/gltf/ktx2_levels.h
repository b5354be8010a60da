// SPDX-License-Identifier: Apache-2.0
// Writes the KTX 2.0 files that glTF textures name: levels that are there whole, of RGBA or of UASTC's blocks, perhaps
// supercompressed by Zstandard; no colour, so linear and without primaries (KHR_texture_basisu, "KTX v2 Images").
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace multum {

enum class Ktx2Texels { kRgba8, kUastc };

struct Ktx2LevelsSettings {
  Ktx2Texels texels = Ktx2Texels::kUastc;
  int width = 1, height = 1;
  int level_count = 1;
  bool is_supercompressed = true;
};

/// `level_bytes` is asked for each level once. Throws Error(kEnvironment). Returns the file's bytes.
std::uint64_t write_ktx2_levels(const std::string& path, const Ktx2LevelsSettings& settings,
                                const std::function<std::vector<std::uint8_t>(int level)>& level_bytes);

}  // namespace multum
