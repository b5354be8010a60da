// SPDX-License-Identifier: Apache-2.0
// Finds parts of texts.
#pragma once

#include <cstddef>
#include <string>

namespace multum::testing {

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Counts `part` in `text`, overlaps included.
inline std::size_t part_count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace multum::testing
