// SPDX-License-Identifier: Apache-2.0
// Reads image files in bands of rows, through OpenImageIO. Returns the file's own numbers, without colour conversion,
// multiplication by alpha, or resizing. Other code interprets them.
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
  int threads = 1;            // <= 0 means one per core
  int band_rows = 0;          // rows per band, rounded up to whole tiles; 0 chooses a number for the file
  bool all_channels = false;  // true to read alpha and all other channels too, for files that are not pictures
};

class ImageReader {
 public:
  /// Opens PNG, JPEG, WebP, TIFF or OpenEXR (recognized by content, not by name). Throws Error(kInput), which names the
  /// file, what was found and what was expected.
  ImageReader(const std::string& path, const ImageReadSettings& settings);
  ~ImageReader();
  ImageReader(const ImageReader&) = delete;
  ImageReader& operator=(const ImageReader&) = delete;

  const RawImageInfo& info() const;

  /// Passes the bands to `consume`, one after another from the top. Unless settings.threads is 1, a second thread
  /// consumes a band while the next one is read. Rethrows exceptions of `consume`, and throws Error(kInput) like the
  /// constructor. The work can be cancelled between bands. Call this function only once.
  void read(const std::function<void(const RawBand&)>& consume, Progress* progress);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace multum
