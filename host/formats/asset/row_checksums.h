// SPDX-License-Identifier: Apache-2.0
// Holds checksums of rows of tiles in the header of a baked file. The checksums show which rows are damaged. A reader
// of some rows can check these rows without reading the others (docs/reference/file_format.md, "Checksum"). Only
// host/formats/asset uses this file.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/asset/baked_header.h"

namespace multum {

// The attribute is only in the first part, because it covers all parts.
constexpr char kRowChecksumsAttribute[] = "multum:rowChecksums";

class RowChecksums {
 public:
  /// Makes the text for a file with tiles of this height. The digits are spaces until they are set.
  RowChecksums(const BakedHeader& header, const std::vector<BakedPart>& parts, int tile_size);

  /// The attribute's text. The text begins with the height of tiles, as in "  128 ", followed by 16 digits per row of
  /// tiles. Parts, levels and rows come in order.
  const std::string& text() const { return text_; }
  /// Takes the text from a file. Returns false if the text is for tiles of another size, for example because another
  /// program has rewritten the file with other tiles.
  bool take(const std::string& text);

  /// Sets the checksum of one row of tiles. `values` holds the interleaved values of all rows of texels in it.
  void set(std::size_t part, int level, int tile_row, const float* values, std::size_t count);
  bool is_same(std::size_t part, int level, int tile_row, const float* values, std::size_t count) const;

 private:
  std::size_t place(std::size_t part, int level, int tile_row) const;

  std::string text_;
  std::vector<int> first_levels_;                 // index: [part]
  std::vector<std::vector<std::size_t>> places_;  // index: [part][level of the part]; position of the first row's
                                                  // digits
};

}  // namespace multum
