// SPDX-License-Identifier: Apache-2.0
// Checksums of rows of tiles, as a baked file's header holds them: whoever reads some rows alone knows whether they are
// what was baked, and where they are not (docs/reference/file_format.md, "Checksum"). For host/formats/asset alone.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/asset/baked_header.h"

namespace multum {

// In the first part alone: it is of all parts.
constexpr char kRowChecksumsAttribute[] = "multum:rowChecksums";

class RowChecksums {
 public:
  /// Of a file with tiles of this height; digits are spaces until they are set.
  RowChecksums(const BakedHeader& header, const std::vector<BakedPart>& parts, int tile_size);

  /// The attribute: "  128 ", which is the tiles' height, then 16 digits a row of tiles; parts, levels and rows in
  /// order.
  const std::string& text() const { return text_; }
  /// Takes what a file says; false where it is of other tiles, as after a program that cut them anew.
  bool take(const std::string& text);

  /// `values`: all rows of the row of tiles, interleaved.
  void set(std::size_t part, int level, int tile_row, const float* values, std::size_t count);
  bool is_same(std::size_t part, int level, int tile_row, const float* values, std::size_t count) const;

 private:
  std::size_t place(std::size_t part, int level, int tile_row) const;

  std::string text_;
  std::vector<int> first_levels_;                 // [part]
  std::vector<std::vector<std::size_t>> places_;  // [part][level of the part]: of its first row's digits
};

}  // namespace multum
