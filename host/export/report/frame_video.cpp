// SPDX-License-Identifier: Apache-2.0
#include "host/export/report/frame_video.h"

#include <fmt/format.h>

#include <chrono>
#include <fstream>

#include "host/base/error.h"
#include "host/base/files/atomic_file.h"
#include "host/base/files/byte_file.h"
#include "host/base/processes/child_process.h"
#include "host/base/size_of.h"

namespace multum {
namespace {

constexpr std::chrono::milliseconds kTimeMax{300000};

}  // namespace

std::string encode_webm(const VideoFrames& video, const std::string& folder) {
  // Neither ever gets its final name: both go with these objects.
  const AtomicFile raw(folder + "/frames.gray"), webm(folder + "/frames.webm");
  std::ofstream file(raw.temporary_path(), std::ios::binary);
  for (const std::vector<std::uint8_t>& frame : video.frames) {
    MULTUM_CHECK(frame.size() == size_of(video.width) * size_of(video.height));
    if (!file.write(reinterpret_cast<const char*>(frame.data()), static_cast<std::streamsize>(frame.size())))
      fail_by_errno(raw.temporary_path(), "cannot be written");
  }
  file.close();
  if (!file) fail_by_errno(raw.temporary_path(), "cannot be written");
  ChildLimits limits;
  limits.time_max = kTimeMax;
  const std::string scale = fmt::format("scale=iw*{0}:ih*{0}:flags=neighbor", video.enlarged);
  ChildResult result;
  try {
    result = run_child({"ffmpeg",
                        "-nostdin",
                        "-v",
                        "error",
                        "-y",
                        "-f",
                        "rawvideo",
                        "-pix_fmt",
                        "gray",
                        "-s",
                        fmt::format("{}x{}", video.width, video.height),
                        "-r",
                        std::to_string(video.frames_per_second),
                        "-i",
                        raw.temporary_path(),
                        "-vf",
                        scale,
                        "-c:v",
                        "libvpx-vp9",
                        "-pix_fmt",
                        "yuv420p",
                        "-b:v",
                        "0",
                        "-crf",
                        "40",
                        "-deadline",
                        "good",
                        "-cpu-used",
                        "5",
                        "-f",
                        "webm",
                        webm.temporary_path()},
                       limits);
  } catch (const Error& error) {
    throw Error(ErrorCode::kEnvironment,
                std::string("ffmpeg cannot be started, expected Debian's package ffmpeg: ") + error.what());
  }
  if (result.exit_code == 127)
    throw Error(ErrorCode::kEnvironment, "ffmpeg was not found, expected Debian's package ffmpeg");
  if (result.exit_code != 0)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("ffmpeg failed{}: {}", result.is_over_time ? " (over time)" : "", result.output));
  return bytes_of_file(webm.temporary_path());
}

}  // namespace multum
