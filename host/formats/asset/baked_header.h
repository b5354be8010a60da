// SPDX-License-Identifier: Apache-2.0
// Converts the header of a file to the attributes of its parts, and back. Only host/formats/asset uses this file.
#pragma once

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPixelType.h>

#include <string>
#include <vector>

#include "host/formats/asset/baked_file.h"

namespace multum {

// Attributes whose values are known only after the pixels are written. These values are filled in at the end.
constexpr char kMeasuredErrorAttribute[] = "multum:measuredError";  // only in the first part, because it is long
constexpr char kContentHashAttribute[] = "multum:contentHash";      // in every part
constexpr int kContentHashDigits = 64;

struct BakedChannel {
  std::string name;
  Imf::PixelType type;
};

/// A part of the file. Writer, reader and checksum use this same description (docs/reference/file_format.md, "Parts and
/// channels").
struct BakedPart {
  std::string name;
  std::vector<BakedChannel> channels;  // in the order of values in memory (interleaved) and in the checksum
  int first_level;                     // the finest level of the part, as a level number of the map
  int level_count;
  bool is_one_level;  // true for tiles of one level, without mip levels
  std::string channels_text;

  bool has_level(int level) const { return level >= first_level && level < first_level + level_count; }
};

/// Makes one header per part. Spaces reserve room for the measured error, the content hash and the hash of the header.
/// Each representation adds its own attributes.
std::vector<Imf::Header> make_baked_headers(const BakedHeader& header, const std::vector<BakedPart>& parts,
                                            const BakedWriteOptions& options);

/// Reads everything except pixels from the header of the first part. Throws Error(kInput), which names `path`, what was
/// found and what was expected.
BakedHeader parse_baked_header(const Imf::Header& header, const std::string& path);
/// Reads the header of a file. The file must have this representation.
BakedHeader parse_baked_header(const Imf::Header& header, Representation expected, const std::string& path);

/// Return the parts with mean colours and mean weights of basis BRDFs, for representations whose texels are averages.
BakedPart mean_colour_part(const BakedHeader& header);
BakedPart mean_weights_part(const BakedHeader& header);

/// Checks that every part exists and matches `parts`.
void check_baked_parts(const Imf::MultiPartInputFile& file, const BakedHeader& header,
                       const std::vector<BakedPart>& parts, const std::string& path);

/// Reads the attributes that files of every kind have: sizes, wrap modes, encoding (one of `encodings`) and provenance.
BakedHeader parse_map_header(const Imf::Header& header, const std::vector<StorageEncoding>& encodings,
                             const std::string& path);

/// Reads a text attribute that only one representation has.
std::string text_attribute(const Imf::Header& header, const char* name, const std::string& path);
int int_attribute(const Imf::Header& header, const char* name, const std::string& path);
[[noreturn]] void refuse_file(const std::string& path, const std::string& found, const std::string& expected);

}  // namespace multum
