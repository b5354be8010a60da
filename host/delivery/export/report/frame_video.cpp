// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/report/frame_video.h"

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <memory>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr std::chrono::milliseconds kTimeMax{300000};

}  // namespace

std::string encode_webm(const VideoFrames& video, const std::string& folder) {
  const std::unique_ptr<WorkFolder> work = WorkFolder::make(folder);
  const std::string raw = work->path() + "/frames.gray", webm = work->path() + "/frames.webm";
  std::ofstream file(raw, std::ios::binary);
  for (const std::vector<std::uint8_t>& frame : video.frames) {
    MULTUM_CHECK(frame.size() == size_of(video.width) * size_of(video.height));
    if (!file.write(reinterpret_cast<const char*>(frame.data()), static_cast<std::streamsize>(frame.size())))
      fail_by_errno(work->shown_path() + "/frames.gray", "cannot be written");
  }
  file.close();
  if (!file) fail_by_errno(work->shown_path() + "/frames.gray", "cannot be written");
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
                        raw,
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
                        webm},
                       limits);
  } catch (const Error& error) {
    throw Error(
        ErrorCode::kEnvironment,
        std::string("ffmpeg cannot be started, expected the Debian package ffmpeg to be installed: ") + error.what());
  }
  if (result.exit_code == 127)
    throw Error(ErrorCode::kEnvironment, "ffmpeg was not found, expected the Debian package ffmpeg to be installed");
  if (result.exit_code != 0)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("ffmpeg failed{}: {}", result.is_over_time ? " (over time)" : "", result.output));
  return bytes_of_file(webm);
}

}  // namespace multum
