// SPDX-License-Identifier: Apache-2.0
// Exports the colours of lobes (Han et al. 2007, section 7.3) for GPUs. A surface's colour depends on its normal if,
// for example, bricks are red and mortar is grey, or if dents are dark. The stored tint of a lobe is a y / t - a, where
// a is the lobe's amplitude, y is the luminance of its colour, and t is the luminance of the texel. The tints of a
// texel add up to 0, and are small and smooth. At half the resolution of the lobes, 4 bits per texel and lobe are
// enough for almost the same accuracy (docs/evidence/GLTF_TEXTURES.md, "Colours of lobes").
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

constexpr char kLobeColourKey[] = "multumLobeColours";  // key in the key/value data
constexpr int kLobeColourVersion = 1;
constexpr int kLobeColourFirstLevel = 2;  // map level that is level 0 of the texture

/// Returns the tints [lobe][y * width + x] of a level with colours.
std::vector<std::vector<float>> lobe_tints(const MovmfLevel& level);

struct LobeColourJob {
  std::string input;   // *.ndf.exr of vMF lobes with colours
  std::string output;  // NAME.ktx2 in BC5, with lobes 2 k and 2 k + 1 in red and green of layer k, and an even number
                       // of layers
  int zstd_level = 0;
  int threads = 1;
};

/// Returns the file's bytes. If the map has no level kLobeColourFirstLevel, returns 0 and writes no file. The lobes are
/// held in memory. Throws Error and Cancelled. Leaves no partial file.
std::uint64_t export_lobe_colours(const LobeColourJob& job, Device& device, Progress* progress);

}  // namespace multum
