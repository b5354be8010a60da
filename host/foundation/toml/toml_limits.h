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
  /// The depth of nested tables and arrays, which come from headers, dotted keys or brackets. Files of multum have a
  /// depth of 4.
  int depth_max = 32;
  int key_part_max = 32;  // parts of one key or header, separated by dots
  /// The number of values plus the number of parts of keys. A map in a manifest needs about 12 items and 250 bytes of
  /// text, so 16,000 maps are possible.
  std::size_t item_max = 200'000;
  /// Limits on the number of dots in all keys and headers, and on the names of [[tables]]. Whenever a key or header
  /// contains a dot, toml++ searches all tables that were made by dots. The files of multum need no dots.
  std::size_t dot_max = 10'000;
  std::size_t array_name_max = 1'000;
};

/// Throws Error(kInput) with the message "PATH:LINE: found ..., expected at most ...". Takes time proportional to the
/// length of the text.
void check_toml_limits(const std::string& path, std::string_view text, const TomlLimits& limits);

}  // namespace multum
