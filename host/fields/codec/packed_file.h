// SPDX-License-Identifier: Apache-2.0
// Joins sections into a packed field, NAME.mpt, which PackedIndex reads.
#pragma once

#include "host/fields/codec/decoder/packed_index.h"

namespace multum {

struct SectionSource {
  std::uint32_t kind = 0, layer = 0, block = 0;
  std::vector<std::uint8_t> bytes;  // up to PackedIndex::kSectionBytesMax
};

/// Returns the file's bytes.
std::vector<std::uint8_t> packed_file(const std::vector<SectionSource>& sections);

}  // namespace multum
