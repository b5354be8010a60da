// SPDX-License-Identifier: Apache-2.0
// Reads image files by bands of rows, through OpenImageIO: the numbers as the file holds them, with no colour
// conversion, no multiplication by alpha, no resizing. What the numbers mean is decided elsewhere.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host/formats/image/raw_image.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct ImageReadSettings {
  std::int64_t texel_count_max = std::int64_t{1} << 30;
  int threads = 1;            // <= 0: as many as the machine has
  int band_rows = 0;          // rows of a band, up to whole tiles; 0: what suits the file
  bool all_channels = false;  // alpha and all others too, for what is no picture
};

class ImageReader {
 public:
  /// Opens PNG, JPEG, WebP, TIFF or OpenEXR (chosen by content, not by name). Throws Error(kInput) naming the file,
  /// what was found and what was expected.
  ImageReader(const std::string& path, const ImageReadSettings& settings);
  ~ImageReader();
  ImageReader(const ImageReader&) = delete;
  ImageReader& operator=(const ImageReader&) = delete;

  const RawImageInfo& info() const;

  /// Hands every band, from the top, to `consume`: one after another, in a second thread while the next one is read
  /// unless settings.threads is 1. What `consume` throws is thrown again here. Throws Error(kInput) as the constructor
  /// does. Cancels at bands. Called once.
  void read(const std::function<void(const RawBand&)>& consume, Progress* progress);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace multum
