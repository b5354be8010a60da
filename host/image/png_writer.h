// SPDX-License-Identifier: Apache-2.0
// PNG files of the project's own making: 16-bit RGB, row by row.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace multum {

/// A file that appears whole or not at all. Everything throws Error(kEnvironment) when it cannot be written.
class Png16Writer {
 public:
  Png16Writer(const std::string& path, int width, int height, const std::string& colour_space);
  ~Png16Writer();
  Png16Writer(const Png16Writer&) = delete;
  Png16Writer& operator=(const Png16Writer&) = delete;

  /// The next rows; `interleaved` holds 3 values a texel.
  void write_rows(int row_count, const std::uint16_t* interleaved);
  /// After all rows: the file gets its name.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// `interleaved` holds width * height * 3 values.
void write_png16(const std::string& path, int width, int height, const std::vector<std::uint16_t>& interleaved,
                 const std::string& colour_space);

}  // namespace multum
