// SPDX-License-Identifier: Apache-2.0
// Exports the lobes of a baked file to a texture file for GPUs (docs/reference/lobe_textures.md, "Lobes for GPUs").
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/asset/textures/lobe_texture.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct LobeExportJob {
  std::string input;   // *.ndf.exr of vMF lobes
  std::string output;  // NAME.ktx2
  std::string report;  // JSON file; empty if no report is written
  LobeTexels texels = LobeTexels::kBlocks;
  int zstd_level = 0;          // 1..kZstdLevelMax; 0 if not supercompressed
  bool keeps_colours = false;  // true if the caller exports the colours elsewhere; otherwise a file with colours gives
                               // a warning
  int threads = 1;
};

struct LobeExportReport {
  LobeTextureHeader header;
  std::uint64_t gpu_bytes = 0;      // size of the texture
  std::uint64_t default_bytes = 0;  // size of all levels of the map as BC5 and of a roughness as BC4
  std::string device;
  std::vector<std::pair<std::string, double>> seconds;  // seconds per stage

  double bytes_ratio() const { return static_cast<double>(gpu_bytes) / static_cast<double>(default_bytes); }
  std::string to_json() const;
};

/// Throws Error and Cancelled. Leaves no partial file. The file's lobes are held in memory, with 16 bytes per lobe and
/// texel. Progress: one unit per texel and lobe.
LobeExportReport export_lobes(const LobeExportJob& job, Device& device, Progress* progress);

}  // namespace multum
