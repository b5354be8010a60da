// SPDX-License-Identifier: Apache-2.0
// Converts what a file says of itself to the attributes of its parts' headers, and back. For host/formats/asset alone.
#pragma once

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPixelType.h>

#include <string>
#include <vector>

#include "host/formats/asset/baked_file.h"

namespace multum {

// What headers say that is known when the pixels are written: filled in at the end.
constexpr char kMeasuredErrorAttribute[] = "multum:measuredError";  // in the first part alone: it is long
constexpr char kContentHashAttribute[] = "multum:contentHash";      // in every part
constexpr int kContentHashDigits = 64;

struct BakedChannel {
  std::string name;
  Imf::PixelType type;
};

/// A part as writer, reader and checksum agree on it (docs/reference/file_format.md, "Parts and channels").
struct BakedPart {
  std::string name;
  std::vector<BakedChannel> channels;  // as values lie in memory, interleaved, and as they are hashed
  int first_level;                     // of the map's levels
  int level_count;
  bool is_one_level;  // tiles of one level, no mip levels
  std::string channels_text;

  bool has_level(int level) const { return level >= first_level && level < first_level + level_count; }
};

/// One header a part, with spaces where the measured error, the content hash and the header's own will be. A
/// representation adds attributes of its own.
std::vector<Imf::Header> make_baked_headers(const BakedHeader& header, const std::vector<BakedPart>& parts,
                                            const BakedWriteOptions& options);

/// Reads everything but pixels from the first part's header. Throws Error(kInput) naming `path`, what was found and
/// what was expected.
BakedHeader parse_baked_header(const Imf::Header& header, const std::string& path);
/// The same for a file that must be of one representation.
BakedHeader parse_baked_header(const Imf::Header& header, Representation expected, const std::string& path);

/// Mean colours, mean weights of basis BRDFs: parts of those representations whose texels are averages.
BakedPart mean_colour_part(const BakedHeader& header);
BakedPart mean_weights_part(const BakedHeader& header);

/// Checks that every part is there and as `parts` says.
void check_baked_parts(const Imf::MultiPartInputFile& file, const BakedHeader& header,
                       const std::vector<BakedPart>& parts, const std::string& path);

/// Reads what files of every kind state: sizes, wrap modes, encoding (one of `encodings`) and where it comes from.
BakedHeader parse_map_header(const Imf::Header& header, const std::vector<StorageEncoding>& encodings,
                             const std::string& path);

/// For attributes of one representation.
std::string text_attribute(const Imf::Header& header, const char* name, const std::string& path);
int int_attribute(const Imf::Header& header, const char* name, const std::string& path);
[[noreturn]] void refuse_file(const std::string& path, const std::string& found, const std::string& expected);

}  // namespace multum
