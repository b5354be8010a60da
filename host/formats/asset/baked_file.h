// SPDX-License-Identifier: Apache-2.0
// Common part of all baked files, whatever their representation: a multi-part, tiled, mip-mapped OpenEXR file whose
// header says where it comes from (docs/reference/file_format.md).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/formats/asset/representation.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// Exponent of the Blinn-Phong that shades files with roughness in them, the sharpest that the formulas are tested
/// with: it adds no width to what is rougher than 0.1, and keeps mirrors finite.
constexpr float kRoughnessExponent = 1e5f;

constexpr int kWeightCountMax = 4;  // channels of a texture

/// Origin of a file, as its header states it beside the pixels.
struct BakedProvenance {
  std::string software;       // "multum 0.1.0"
  std::string source_name;    // file name of the normal map, without folder
  std::string source_hash;    // SHA-256 of the normal map's file, or of it and what others of its set gave to it
  std::string settings;       // JSON: every setting that changes the file
  std::string settings_hash;  // SHA-256 of `settings`
  std::string
      measured_error;        // JSON: relative L1 error of file against source (docs/evidence/ACCURACY.md); may be empty
  std::string content_hash;  // of every channel value in the file (docs/reference/file_format.md, "Checksum"); filled
                             // by write, read
  std::string reading = {};  // JSON: what was found in the source's files; empty in files of earlier programs
  std::string source_file_hash = "";  // SHA-256 of the normal map's file, where source_hash is of more; else empty
  std::string source_tiles = "";      // JSON: what other tiles of the map's set gave to it; empty: nothing

  const std::string& file_hash() const { return source_file_hash.empty() ? source_hash : source_file_hash; }
};

/// Header that files of every representation have.
struct BakedHeader {
  Representation representation = Representation::kMovmf;
  StorageEncoding encoding = StorageEncoding::kSnorm16;
  WrapMode wrap_s = WrapMode::kPeriodic;
  WrapMode wrap_t = WrapMode::kPeriodic;
  BakedProvenance provenance;
  int width = 0, height = 0;  // of the map, that is, of level 0
  int first_level = 0;        // the finest level that is stored, 0..level_count() - 1
  bool has_colours = false;
  int weight_count = 0;  // linear blend weights of basis BRDFs, 0..kWeightCountMax
  // A BRDF's width is in the normals' lengths: each of level 0 is c(roughness) n (host/formats/image/material_maps.h).
  bool has_roughness = false;
  float mean_cosine = 1.0f;  // mean of c over the map: diffuse light divides by it what roughness took of the lengths

  int level_count() const;
  /// multum:formatVersion: programs that know neither weights nor roughness refuse the file.
  int format_version() const;
};

/// What a reader does with texels that are not those that were baked, by the file's checksums: refuses them, or lists
/// where they are, as `multum verify` does.
enum class TexelCheck { kRefuse, kReport };

struct BakedWriteOptions {
  // docs/contributing/ALGORITHMS.md, "Why the file is as it is", has the measurements behind these two.
  std::string compression = "zip:1";  // none, rle, zips, zip or piz; with ":LEVEL" for zip and zips
  int tile_size = 128;
  int threads = 2;
  // Room in the header for provenance.measured_error, which is known when all rows are written (MovmfWriter::commit()).
  // That of 16 levels, the most that a bake makes, with colours, takes 28 KiB (test
  // AccuracyTable.TheLongestFitsIntoTheRoomOfAHeader).
  int measured_error_bytes = 32 * 1024;
  bool is_checked = true;  // false: what `multum verify` would refuse is written all the same, as its tests need it
};

/// Compressions that BakedWriteOptions may name, in words.
constexpr char kCompressionsInWords[] =
    "none, rle, zips, zip or piz (every one is lossless), and for zip and zips an optional level such as zip:4";

/// Throws Error(kUsage) for an unknown compression: before a bake, not after it.
void validate(const BakedWriteOptions& options);

/// Number of ROUND_DOWN levels of a width x height map: 1 + floor(log2(max(width, height))).
int mip_level_count(int width, int height);
inline int mip_level_size(int size, int level) { return (size >> level) > 1 ? size >> level : 1; }

/// Some texels' worth of `values`, which lie `texel_count` texels in all: as many values a texel as there are.
template <typename Value>
std::vector<Value> texels_of(const std::vector<Value>& values, std::size_t texel_count, std::size_t first,
                             std::size_t end) {
  if (values.empty()) return {};
  const std::size_t stride = values.size() / texel_count;
  const auto at = [&](std::size_t texel) { return values.begin() + static_cast<std::ptrdiff_t>(texel * stride); };
  return {at(first), at(end)};
}

/// "7 levels" where all are stored, else "levels 1 to 6 of 0 to 6", "level 6 of 0 to 6".
std::string levels_text(int first_level, int level_count);

/// " with colours, 2 weights and roughness": what texels hold beside normals; empty for none.
std::string materials_text(const BakedHeader& header);

/// The header of a file of any representation. Cheap for files of any size. Throws Error(kInput) naming the file, what
/// was found and what was expected.
BakedHeader read_baked_header(const std::string& path);

/// What lies between the texels of the map that a file was baked from: `--surface` of the bake, "texels" or
/// "interpolated". Files from before the option have texels.
std::string baked_surface(const BakedHeader& header);

}  // namespace multum
