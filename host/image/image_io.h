// SPDX-License-Identifier: Apache-2.0
// Image files to planes of floats and back, through OpenImageIO: the numbers as the file holds them, no colour
// conversion, no multiplication by alpha, no resizing. What the numbers mean is somebody else's question.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/progress.h"

namespace multum {

enum class SampleType { kUint8, kUint16, kOtherInteger, kHalf, kFloat };  // kFloat: also double

struct RawImage {
  int width = 0;
  int height = 0;
  std::vector<std::vector<float>> planes;  // 1 to 3 colour channels, row 0 on top; integers scaled to 0..1. No alpha.
  SampleType sample_type = SampleType::kFloat;
  std::string colour_space;  // as the file says: "sRGB", "Linear", "Gamma2.2", or empty
  bool has_alpha = false;    // in the file; never read
  std::string format;        // "png uint8, 4 channels (alpha not read)"
};

struct ImageReadSettings {
  std::int64_t texel_count_max = std::int64_t{1} << 30;
  int threads = 1;  // <= 0: as many as the machine has
};

inline bool is_float_type(SampleType type) { return type == SampleType::kHalf || type == SampleType::kFloat; }

/// Reads PNG, JPEG, WebP, TIFF or OpenEXR (chosen by content, not by name). Throws Error(kInput) naming the file, what
/// was found and what was expected. Cancels at bands of rows.
RawImage read_raw_image(const std::string& path, const ImageReadSettings& settings, Progress* progress);

/// Writes 16-bit RGB PNG atomically. `interleaved` holds width * height * 3 values. Throws Error(kEnvironment).
void write_png16(const std::string& path, int width, int height, const std::vector<std::uint16_t>& interleaved,
                 const std::string& colour_space);

}  // namespace multum
