// SPDX-License-Identifier: Apache-2.0
// Writes PNG files. Maps are written as RGB of 16 or 8 bits, row by row. 8-bit pictures for viewing are written as a
// whole.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace multum {

/// Writes a file that appears complete or not at all. All functions throw Error(kEnvironment) if the file cannot be
/// written.
class Png16Writer {
 public:
  Png16Writer(const std::string& path, int width, int height, const std::string& colour_space);
  ~Png16Writer();
  Png16Writer(const Png16Writer&) = delete;
  Png16Writer& operator=(const Png16Writer&) = delete;

  /// Writes the next rows. `interleaved` holds 3 values per texel.
  void write_rows(int row_count, const std::uint16_t* interleaved);
  /// Gives the file its final name. Call this function after all rows are written.
  void finish();

 private:
  std::unique_ptr<class PngFile> file_;
};

/// Writes 8-bit data like Png16Writer. The file does not state a colour space.
class Png8Writer {
 public:
  /// `channels` is 3, or 4 with alpha.
  Png8Writer(const std::string& path, int width, int height, int channels = 3);
  ~Png8Writer();
  Png8Writer(const Png8Writer&) = delete;
  Png8Writer& operator=(const Png8Writer&) = delete;

  /// Writes the next rows. `interleaved` holds `channels` values per texel.
  void write_rows(int row_count, const std::uint8_t* interleaved);
  void finish();

 private:
  std::unique_ptr<class PngFile> file_;
};

/// `interleaved` holds width * height * 3 values.
void write_png16(const std::string& path, int width, int height, const std::vector<std::uint16_t>& interleaved,
                 const std::string& colour_space);

/// Values are sRGB, with row 0 at the top.
struct Png8Image {
  int width = 0, height = 0;
  int channels = 3;  // 1 for grey; 4 with alpha, not premultiplied
  std::vector<std::uint8_t> interleaved;
};

void write_png8(const std::string& path, const Png8Image& image);

}  // namespace multum
