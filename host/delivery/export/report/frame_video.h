// SPDX-License-Identifier: Apache-2.0
// Encodes grey frames as VP9 in WebM by running ffmpeg (Debian package ffmpeg), which is not part of multum.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace multum {

struct VideoFrames {
  int width = 0, height = 0;  // even numbers
  int enlarged = 2;           // side of the square of video pixels that shows one pixel, 1..8
  int frames_per_second = 24;
  std::vector<std::vector<std::uint8_t>> frames;  // width * height pixels each
};

/// Returns the file's bytes. `folder` is for temporary files. Throws Error(kEnvironment) if ffmpeg is missing or fails.
std::string encode_webm(const VideoFrames& video, const std::string& folder);

}  // namespace multum
