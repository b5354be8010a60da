// SPDX-License-Identifier: Apache-2.0
// Indexes the texels that a model keeps. A texel has an entry if the file stores it and at least one point reads it
// (texel_selection.h).
#pragma once

#include <cstddef>

#include "host/bakes/accuracy/texel_selection.h"
#include "host/foundation/base/error.h"

namespace multum {

class KeptTexels {
 public:
  /// `texels` must outlive the object.
  KeptTexels(const TexelSelection& texels, int first_level)
      : texels_(texels),
        first_level_(first_level),
        first_slot_(texels.level_begin(first_level)),
        missing_count_(texels.slot_count() - first_slot_) {}

  int first_level() const { return first_level_; }
  std::size_t count() const { return texels_.slot_count() - first_slot_; }
  bool is_stored(std::size_t slot) const { return slot >= first_slot_; }
  /// Returns the entry of a stored slot.
  std::size_t entry(std::size_t slot) const { return slot - first_slot_; }
  /// True if every texel was added.
  bool is_complete() const { return missing_count_ == 0; }

  /// Calls keep(entry, texel) for the kept texels of these rows. `texel` counts from the first texel of the first row.
  /// Add each row only once.
  template <typename Level, typename Keep>
  void take_rows(int level, int first_row, const Level& rows, const Keep& keep) {
    const PlaneSize size = texels_.sizes()[static_cast<std::size_t>(level)];
    MULTUM_CHECK(level >= first_level_ && rows.width == size.width);
    MULTUM_CHECK(first_row >= 0 && first_row + rows.height <= size.height);
    for (int y = 0; y < rows.height; ++y) {
      const std::size_t end = texels_.row_end(level, first_row + y);
      for (std::size_t slot = texels_.row_begin(level, first_row + y); slot < end; ++slot) {
        keep(entry(slot), static_cast<std::size_t>(y) * static_cast<std::size_t>(rows.width) +
                              static_cast<std::size_t>(texels_.column(slot)));
        MULTUM_CHECK(missing_count_ > 0);
        --missing_count_;
      }
    }
  }

 private:
  const TexelSelection& texels_;
  const int first_level_;
  const std::size_t first_slot_;  // slot of the first stored texel
  std::size_t missing_count_;
};

}  // namespace multum
