// SPDX-License-Identifier: Apache-2.0
// Checks a TOML file before the parser reads it. toml++ 3.3 nests a table for every part of a dotted key, without
// limit, and destroys the tables by recursion. A key of 32,000 parts (64 KB) caused a stack overflow, and an array of
// 24 MB took 1 GB. The scan handles only strings, comments, keys and brackets. The parser rejects other text that is
// not TOML.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace multum {

struct TomlLimits {
  std::size_t byte_max = std::size_t{4} << 20;
  /// Depth of nested tables and arrays, which headers, dotted keys or brackets make. Files of multum have a depth of 4.
  int depth_max = 32;
  int key_part_max = 32;  // parts of one key or header, separated by dots
  /// Number of values and of parts of keys together. A map in a manifest needs about 12 items and 250 bytes of text, so
  /// 16,000 maps are possible.
  std::size_t item_max = 200'000;
  /// Limits on the dots in all keys and headers, and on the names of [[tables]]. Whenever a key or header contains a
  /// dot, toml++ searches all tables that dots have made. Multum's own files need no dots.
  std::size_t dot_max = 10'000;
  std::size_t array_name_max = 1'000;
};

/// Throws Error(kInput): "PATH:LINE: found ..., expected at most ...". Takes time proportional to the text.
void check_toml_limits(const std::string& path, std::string_view text, const TomlLimits& limits);

}  // namespace multum
