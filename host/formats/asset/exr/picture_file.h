// SPDX-License-Identifier: Apache-2.0
// Writes pictures as OpenEXR files: linear 32-bit floats, whole; halfs, row by row. A file appears whole or not at all.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace multum {

/// `rgba`: 4 * width * height values, row 0 at the top. Channels R, G, B, A, compressed by zip. Throws
/// Error(kEnvironment) when the disk refuses.
void write_exr_picture(const std::string& path, int width, int height, const std::vector<float>& rgba);

/// Channels R, G, B, and A where it is asked for, of half floats, compressed by zip. Everything throws
/// Error(kEnvironment) when the disk refuses.
class ExrHalfWriter {
 public:
  /// `channels`: 3, or 4 with alpha.
  ExrHalfWriter(const std::string& path, int width, int height, int channels = 3);
  ~ExrHalfWriter();
  ExrHalfWriter(const ExrHalfWriter&) = delete;
  ExrHalfWriter& operator=(const ExrHalfWriter&) = delete;

  /// The next rows; `interleaved` holds `channels` values a texel.
  void write_rows(int row_count, const float* interleaved);
  /// Gives the file its name, after all rows.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace multum
