// SPDX-License-Identifier: Apache-2.0
// A look at a TOML file before the parser sees it. toml++ 3.3 nests a table for every part of a dotted key, without
// limit, and tears them down by recursion: a key of 32,000 parts (64 KB) ended the program by a stack overflow, and an
// array of 24 MB took 1 GB. The scan knows strings, comments, keys and brackets, and no more: what is no TOML it leaves
// to the parser to refuse.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace multum {

struct TomlLimits {
  std::size_t byte_max = std::size_t{4} << 20;
  /// Tables and arrays below one another, whatever makes them: headers, dotted keys, brackets. Files of multum have 4.
  int depth_max = 32;
  int key_part_max = 32;  // of one key or header, which dots separate
  /// Parts of keys, and values. A map of a manifest takes about 12, its text about 250 bytes: 16,000 maps.
  std::size_t item_max = 200'000;
  /// Dots in keys and headers together, and names of [[tables]]: toml++ looks through all tables that dots have made
  /// whenever a key or header leads through one of them. No file of multum needs any.
  std::size_t dot_max = 10'000;
  std::size_t array_name_max = 1'000;
};

/// Throws Error(kInput): "PATH:LINE: found ..., expected at most ...". The time is in proportion to the text.
void check_toml_limits(const std::string& path, std::string_view text, const TomlLimits& limits);

}  // namespace multum
