// SPDX-License-Identifier: Apache-2.0
// Examines the directories of a TIFF file (TIFF 6.0, section 2; BigTIFF) or of an EXIF block, which has the same
// layout. Finds information that OpenImageIO ignores or does not report.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "host/formats/image/files/image_container.h"
#include "host/foundation/base/files/byte_file.h"

namespace multum {

/// Findings from the first directory, except that page_count covers all directories. Missing or damaged values keep
/// their defaults. The library that reads the picture rejects the file if it needs these values.
struct TiffSurvey {
  bool is_whole = false;  // true if the first directory could be read completely
  int orientation = 1;    // 1 means as stored; 2 to 8 mean mirrored or rotated
  int photometric = -1;
  int bits = 0;         // 0 if the file does not say
  int samples = 1;      // samples per texel
  int compression = 1;  // 1 if uncompressed
  int height = 0;
  int sample_format = 1;    // 1 for unsigned, 2 for signed, 3 for floats
  bool is_reduced = false;  // true for a smaller version of another page
  int page_count = 1;       // number of directories in the chain
  bool is_tiled = false, is_planar = false;
  std::int64_t rows_per_strip = 0;       // 0 if the file does not say
  ByteRange rows_per_strip_at = {0, 0};  // position of this value
  ByteRange colour_map = {0, 0};
  double texel_metres = 0.0;                     // texel size along x; 0 if unknown or not in metres
  std::optional<double> no_data = std::nullopt;  // value of texels without data (GDAL_NODATA)
};

/// Examines the directories whose header is at `base`, which is 0 in a TIFF file.
TiffSurvey survey_tiff(ByteFile& file, std::int64_t base);

/// Returns the orientation in an EXIF block that begins at `position`, with or without its "Exif". Returns 1 if no
/// orientation can be read.
int exif_orientation(ByteFile& file, std::int64_t position, std::int64_t size);

/// Returns "its orientation (6, turned by 90 degrees) is not applied ...". Empty for orientation 1 and invalid values.
std::string orientation_note(int orientation);

}  // namespace multum
