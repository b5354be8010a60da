// SPDX-License-Identifier: Apache-2.0
// Writes pictures as OpenEXR files, either as a whole with linear 32-bit floats, or row by row with 16-bit floats. A
// file appears complete or not at all.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace multum {

/// Writes channels R, G, B and A, compressed by zip. `rgba` holds 4 * width * height values, with row 0 at the top.
/// Throws Error(kEnvironment) if the disk fails.
void write_exr_picture(const std::string& path, int width, int height, const std::vector<float>& rgba);

/// Writes channels R, G, B and optionally A as half floats, compressed by zip. Every function throws
/// Error(kEnvironment) if the disk fails.
class ExrHalfWriter {
 public:
  /// `channels` is 3, or 4 with alpha.
  ExrHalfWriter(const std::string& path, int width, int height, int channels = 3);
  ~ExrHalfWriter();
  ExrHalfWriter(const ExrHalfWriter&) = delete;
  ExrHalfWriter& operator=(const ExrHalfWriter&) = delete;

  /// Writes the next rows; `interleaved` holds `channels` values per texel.
  void write_rows(int row_count, const float* interleaved);
  /// Gives the file its final name. Call this function after all rows are written.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace multum
