// SPDX-License-Identifier: Apache-2.0
// Grey frames as a WebM of VP9, encoded by ffmpeg: a tool of the machine (Debian package ffmpeg), not part of multum.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace multum {

struct VideoFrames {
  int width = 0, height = 0;  // even
  int enlarged = 2;           // each pixel as a square of so many, 1..8
  int frames_per_second = 24;
  std::vector<std::vector<std::uint8_t>> frames;  // width * height
};

/// The file's bytes. `folder`: for files that come and go. Throws Error(kEnvironment) where there is no ffmpeg, or it
/// fails.
std::string encode_webm(const VideoFrames& video, const std::string& folder);

}  // namespace multum
