// SPDX-License-Identifier: Apache-2.0
// PNG files of the project's own making: RGB of 16 or 8 bits, row by row, for maps; 8-bit, whole, for pictures to look
// at.
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
  /// Gives the file its name, after all rows.
  void finish();

 private:
  std::unique_ptr<class PngFile> file_;
};

/// The same of 8 bits, whose numbers are data: the file names no colour space.
class Png8Writer {
 public:
  /// `channels`: 3, or 4 with alpha.
  Png8Writer(const std::string& path, int width, int height, int channels = 3);
  ~Png8Writer();
  Png8Writer(const Png8Writer&) = delete;
  Png8Writer& operator=(const Png8Writer&) = delete;

  /// The next rows; `interleaved` holds `channels` values a texel.
  void write_rows(int row_count, const std::uint8_t* interleaved);
  void finish();

 private:
  std::unique_ptr<class PngFile> file_;
};

/// `interleaved` holds width * height * 3 values.
void write_png16(const std::string& path, int width, int height, const std::vector<std::uint16_t>& interleaved,
                 const std::string& colour_space);

/// sRGB, row 0 at the top.
struct Png8Image {
  int width = 0, height = 0;
  int channels = 3;  // 1: grey; 4: with alpha, which colours are not multiplied by
  std::vector<std::uint8_t> interleaved;
};

void write_png8(const std::string& path, const Png8Image& image);

}  // namespace multum
