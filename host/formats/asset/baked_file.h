// SPDX-License-Identifier: Apache-2.0
// Types that baked files of all representations share. A baked file is a multi-part, tiled, mip-mapped OpenEXR file
// whose header names its source (docs/reference/file_format.md).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/formats/asset/representation.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// The Blinn-Phong exponent that is used to shade files with roughness. It is the largest exponent in the tests of the
/// formulas. A highlight with this exponent adds no width to roughness above 0.1, and keeps the highlights of mirrors
/// finite.
constexpr float kRoughnessExponent = 1e5f;

constexpr int kWeightCountMax = 4;  // the number of channels of a texture

/// The origin of a file, which is stored in its header.
struct BakedProvenance {
  std::string software;        // "multum 0.1.0"
  std::string source_name;     // file name of the normal map, without folder
  std::string source_hash;     // SHA-256 of the normal map's file and of the data from other tiles
  std::string settings;        // JSON with every setting that changes the file
  std::string settings_hash;   // SHA-256 of `settings`
  std::string measured_error;  // JSON with the relative L1 error of the file, compared with its source
                               // (docs/evidence/ACCURACY.md); may be empty
  std::string content_hash;  // SHA-256 of all channel values (docs/reference/file_format.md, "Checksum"); set by write
                             // and read
  std::string reading = {};  // JSON with findings about the source files; empty in files of older programs
  std::string source_file_hash = "";  // SHA-256 of the normal map's file if source_hash covers more; otherwise empty
  std::string source_tiles = "";      // JSON with data from other tiles of the map's set; may be empty

  const std::string& file_hash() const { return source_file_hash.empty() ? source_hash : source_file_hash; }
};

/// The header fields that files of every representation have.
struct BakedHeader {
  Representation representation = Representation::kMovmf;
  StorageEncoding encoding = StorageEncoding::kSnorm16;
  WrapMode wrap_s = WrapMode::kPeriodic;
  WrapMode wrap_t = WrapMode::kPeriodic;
  BakedProvenance provenance;
  int width = 0, height = 0;  // size of the map (level 0)
  int first_level = 0;        // the finest stored level, 0..level_count() - 1
  bool has_colours = false;
  int weight_count = 0;  // linear blend weights of basis BRDFs, 0..kWeightCountMax
  // True if the lengths of normals include the width of a BRDF. Each normal of level 0 is then c(roughness) n
  // (host/formats/image/material_maps.h).
  bool has_roughness = false;
  float mean_cosine = 1.0f;  // mean of c over the map; diffuse light is divided by it

  int level_count() const;
  /// The value of multum:formatVersion. Programs that do not support weights or roughness reject the file.
  int format_version() const;
};

/// Selects what happens to texels with wrong checksums. kRefuse throws, and kReport lists the places of the texels for
/// `multum verify`.
enum class TexelCheck { kRefuse, kReport };

struct BakedWriteOptions {
  // docs/contributing/ALGORITHMS.md, "Reasons for the file format", gives the reasons for the next two defaults.
  std::string compression = "zip:1";  // none, rle, zips, zip or piz; zip and zips may end with ":LEVEL"
  int tile_size = 128;
  int threads = 2;
  // The room in the header for provenance.measured_error, which is known only after all rows are written
  // (MovmfWriter::commit()). A bake makes at most 16 levels. With colours, the errors of 16 levels need 28 KiB (test
  // AccuracyTable.TheLongestFitsIntoTheRoomOfAHeader).
  int measured_error_bytes = 32 * 1024;
  bool is_checked = true;  // false only in tests of `multum verify`, which write files that it rejects
};

/// Lists the compressions that BakedWriteOptions accepts.
constexpr char kCompressionsInWords[] =
    "none, rle, zips, zip or piz (all lossless); zip and zips take an optional level, such as zip:4";

/// Throws Error(kUsage) for an unknown compression, so that a bake fails before it starts.
void validate(const BakedWriteOptions& options);

/// Returns the number of ROUND_DOWN levels of a width x height map: 1 + floor(log2(max(width, height))).
int mip_level_count(int width, int height);
inline int mip_level_size(int size, int level) { return (size >> level) > 1 ? size >> level : 1; }

/// Copies the values of some texels. `values` holds `texel_count` texels, each with the same number of values.
template <typename Value>
std::vector<Value> texels_of(const std::vector<Value>& values, std::size_t texel_count, std::size_t first,
                             std::size_t end) {
  if (values.empty()) return {};
  const std::size_t stride = values.size() / texel_count;
  const auto at = [&](std::size_t texel) { return values.begin() + static_cast<std::ptrdiff_t>(texel * stride); };
  return {at(first), at(end)};
}

/// Returns "7 levels" if all levels are stored. Otherwise returns "levels 1 to 6 of 0 to 6" or "level 6 of 0 to 6".
std::string levels_text(int first_level, int level_count);

/// Lists what texels contain in addition to normals, such as " with colours, 2 weights and roughness". May be empty.
std::string materials_text(const BakedHeader& header);

/// Reads only the representation from the header of a file.
const RepresentationInfo& representation_of(const std::string& path);

/// Reads the header of a file of any representation. This takes little time for files of any size. Throws
/// Error(kInput), which names the file, what was found and what was expected.
BakedHeader read_baked_header(const std::string& path);

/// Returns the value of the bake's option `--surface`, "texels" or "interpolated". It describes the surface between the
/// texels of the source map. Files written before that option existed have "texels".
std::string baked_surface(const BakedHeader& header);

}  // namespace multum
