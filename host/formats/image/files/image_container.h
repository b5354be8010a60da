// SPDX-License-Identifier: Apache-2.0
// Examines an image file by our own few lines, before any image library sees it: which format it is by its first bytes,
// how large it says it is, and which byte ranges hold the picture. Libraries trust headers (they allocate, or parse
// metadata for minutes); fuzzed files show where.
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
  std::string format;  // OpenImageIO's reader: "png", "jpeg", "webp", "tiff" or "openexr"
  std::int64_t file_size = 0;
  std::int64_t width = 0;  // 0 where the format's own reader is the first to say (TIFF)
  std::int64_t height = 0;
  bool has_metadata = false;               // ranges leave something out
  std::vector<ByteRange> ranges;           // the file without its metadata (texts, EXIF, XMP, ICC), in order
  std::vector<std::string> notes = {};     // what the file says of its picture that is not heeded, a line each
  double texel_metres = 0.0;               // GeoTIFF's ModelPixelScale where its unit is the metre; 0: not said
  std::optional<double> no_data = {};      // GeoTIFF: the number, as stored, of texels that have none
  bool inverts_integers = false;           // TIFF: 0 is white, which OpenImageIO 2.4.7 leaves so beyond 8 bits
  std::vector<ByteRange> byte_words = {};  // TIFF: 16-bit words v * 256 of a colour map, meant as v * 257
  std::vector<BytePatch> patches = {};     // TIFF: what OpenImageIO 2.4.7 takes otherwise than it is meant
  double gamma = 0.0;                      // PNG: exponent from number to light (1 / gAMA); 0: none, or sRGB
};

/// ImageContainer::format by the first bytes alone; empty: of none of these formats, or not there.
std::string image_format(const std::string& path);

/// Throws Error(kInput) when the file is missing, of another format, cut, or declares a size that is not within
/// 1..texel_count_max texels or that its bytes cannot hold.
ImageContainer inspect_image_container(const std::string& path, std::int64_t texel_count_max);

/// Throws Error(kInput) unless 1 <= width * height <= texel_count_max.
void check_image_size(const std::string& path, std::int64_t width, std::int64_t height, std::int64_t texel_count_max);

}  // namespace multum
