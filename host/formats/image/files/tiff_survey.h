// SPDX-License-Identifier: Apache-2.0
// Examines the directories of a TIFF file (TIFF 6.0, section 2; BigTIFF) and of EXIF blocks, which have the same
// layout, for what OpenImageIO ignores or does not tell.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "host/formats/image/files/image_container.h"
#include "host/foundation/base/files/byte_file.h"

namespace multum {

/// Findings in the first directory, but for the counts. What is missing or damaged stays at its default: the library
/// that reads the picture refuses what it cannot do without.
struct TiffSurvey {
  bool is_whole = false;  // the first directory could be read to its end
  int orientation = 1;    // 1: as stored; 2 to 8: to be mirrored or turned
  int photometric = -1;
  int bits = 0;         // 0: not said
  int samples = 1;      // of a texel
  int compression = 1;  // 1: none
  int height = 0;
  int sample_format = 1;    // 1 unsigned, 2 signed, 3 floats
  bool is_reduced = false;  // a smaller version of another page
  int page_count = 1;       // directories of the chain
  bool is_tiled = false, is_planar = false;
  std::int64_t rows_per_strip = 0;       // 0: not said
  ByteRange rows_per_strip_at = {0, 0};  // its bytes
  ByteRange colour_map = {0, 0};
  double texel_metres = 0.0;                     // along x; 0: not said, or not in metres
  std::optional<double> no_data = std::nullopt;  // GDAL's: the value of texels that have none
};

/// Examines the directories whose header is at `base`: 0 in a TIFF file.
TiffSurvey survey_tiff(ByteFile& file, std::int64_t base);

/// Orientation in an EXIF block that begins at `position`, with its "Exif" or without; 1 where there is none that can
/// be read.
int exif_orientation(ByteFile& file, std::int64_t position, std::int64_t size);

/// "its orientation (6, turned by 90 degrees) is not applied ..."; empty for 1 and for what is no orientation.
std::string orientation_note(int orientation);

}  // namespace multum
