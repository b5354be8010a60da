// SPDX-License-Identifier: Apache-2.0
// Examines an image file with a few lines of our own code before any image library sees it. Finds its format from the
// first bytes, its declared size, and the byte ranges of the picture. Libraries trust headers. Fuzzed files can
// therefore make them allocate too much memory, or parse metadata for minutes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace multum {

struct ByteRange {
  std::int64_t begin;
  std::int64_t end;
};

struct BytePatch {
  std::int64_t position;
  std::string bytes;
};

struct ImageContainer {
  std::string format;  // name of OpenImageIO's reader: "png", "jpeg", "webp", "tiff" or "openexr"
  std::int64_t file_size = 0;
  std::int64_t width = 0;  // 0 if only the reader of the format knows the size (TIFF)
  std::int64_t height = 0;
  bool has_metadata = false;               // true if `ranges` leave something out
  std::vector<ByteRange> ranges;           // the file without its metadata (texts, EXIF, XMP, ICC), in order
  std::vector<std::string> notes = {};     // ignored statements of the file about its picture, one per line
  double texel_metres = 0.0;               // GeoTIFF's ModelPixelScale if its unit is the metre; 0 if unknown
  std::optional<double> no_data = {};      // for GeoTIFF: stored value of texels without data
  bool inverts_integers = false;           // for TIFF: true if 0 is white; OpenImageIO 2.4.7 inverts only values of up
                                           // to 8 bits
  std::vector<ByteRange> byte_words = {};  // for TIFF: 16-bit words `v * 256` of a colour map, which stand for `v *
                                           // 257`
  std::vector<BytePatch> patches = {};     // for TIFF: bytes that OpenImageIO 2.4.7 would misread
  double gamma = 0.0;                      // for PNG: exponent from value to light (1 / gAMA); 0 for none or sRGB
};

/// Returns ImageContainer::format according to the first bytes. Returns an empty text if the file is missing or has
/// another format.
std::string image_format(const std::string& path);

/// Throws Error(kInput) if the file is missing, truncated or of another format. Also throws if the declared size is
/// outside 1..texel_count_max texels, or if the file has too few bytes for its size.
ImageContainer inspect_image_container(const std::string& path, std::int64_t texel_count_max);

/// Throws Error(kInput) unless 1 <= width * height <= texel_count_max.
void check_image_size(const std::string& path, std::int64_t width, std::int64_t height, std::int64_t texel_count_max);

}  // namespace multum
