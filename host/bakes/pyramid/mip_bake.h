// SPDX-License-Identifier: Apache-2.0
// Bakes image files to pyramid files for `multum mip` (colours) and `multum lod` (heights and positions). The method is
// that of Williams 1983, sections 3 and 5.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "host/bakes/pyramid/box_pyramid.h"
#include "host/formats/asset/pyramid/pyramid_file.h"
#include "host/formats/image/colour_map.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct MipJob {
  PyramidKind kind = PyramidKind::kColour;
  std::string input;
  std::string output;
  std::string report;                              // JSON file; empty if no report is written
  ColourEncoding colours = ColourEncoding::kAuto;  // encoding for kColour; other kinds are data
  WrapMode wrap_s = WrapMode::kPeriodic;
  WrapMode wrap_t = WrapMode::kPeriodic;
  StorageEncoding encoding = StorageEncoding::kHalf;
  float scale = 1.0f;  // factor for the values of the file
  BakedWriteOptions writing;
  std::uint64_t memory_bytes = std::uint64_t{256} << 20;  // limit for buffers and image; does not change the output
  std::string scratch_folder;                             // if empty, the output's folder is used
  int threads = 1;
  bool force = false;
};

struct MipReport {
  bool unchanged = false;  // true if the output already existed; all other fields are then meaningless
  int width = 0, height = 0, level_count = 0;
  std::string format, device, content_hash;
  std::int64_t clamped_count = 0;                 // number of texels with an invalid colour, which is read as 0
  std::map<std::string, std::uint64_t> launches;  // number of launches per kernel
  std::uint64_t limited_count = 0;                // number of values out of range for half floats
  double read_seconds = 0.0, average_seconds = 0.0, write_seconds = 0.0;

  std::string to_json() const;
};

/// Throws Error and Cancelled. Leaves no partial file. Progress includes reading, averaging and writing.
MipReport bake_mip(const MipJob& job, Device& device, Progress* progress);

/// Builds a pyramid from values of any source. `fill_band` writes the rows of `map`'s planes into the pyramid's nodes,
/// band by band from the top. `take` receives the rows of levels. Progress: one unit per texel of the map.
void run_box_bands(BoxPyramid& pyramid, const BoxMap& map, const std::function<void(const MultumBoxBand&)>& fill_band,
                   const std::function<void(const BoxRows&)>& take, Progress* progress);

/// Interleaves the rows of the planes, which is the order in files.
PyramidLevel interleaved(const BoxRows& rows, int channels);

/// Runs run_box_bands() and writes rounded rows to `writer`. Returns the number of values out of range for storage.
std::uint64_t write_box_pyramid(BoxPyramid& pyramid, const BoxMap& map, PyramidWriter& writer, StorageEncoding encoding,
                                const std::function<void(const MultumBoxBand&)>& fill_band, Progress* progress);

/// Makes all levels of an image in memory. `planes` holds map.plane_count planes of width * height floats. This
/// function is used by tests, and for maps that are computed instead of read.
Pyramid box_pyramid(Device& device, const BoxMap& map, const float* planes, std::uint64_t memory_bytes);

/// True if `path` is already a file with the same settings and the same source.
bool is_pyramid_in_place(const std::string& path, const BakedProvenance& provenance);

}  // namespace multum
