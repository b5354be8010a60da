// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/kept_reference.h"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <string_view>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/byte_file.h"

namespace multum {
namespace {

constexpr std::string_view kKeptMagic = "MTREF001";

struct KeptHead {
  std::int32_t width, height, samples, unused;
  double noise, frame_time_ms;
};

}  // namespace

bool has_kept_reference(const std::string& path) {
  std::error_code ignored;
  return !path.empty() && std::filesystem::exists(path, ignored);
}

gl::Picture read_kept_reference(const std::string& path, int width, int height) {
  ByteFile file(path);
  const std::int64_t pixels = std::int64_t{width} * height;
  const auto head_bytes = static_cast<std::int64_t>(kKeptMagic.size() + sizeof(KeptHead));
  const std::int64_t pixel_bytes = pixels * 4 * static_cast<std::int64_t>(sizeof(float));
  const auto refuse = [&](const std::string& found) {
    refuse_file(path, fmt::format("{}, expected a reference of {} x {} pixels that --keep-reference wrote; remove the "
                                  "file to draw the reference again",
                                  found, width, height));
  };
  if (file.size() < head_bytes || file.bytes(0, std::ssize(kKeptMagic), "the kind of file") != kKeptMagic)
    refuse("is not a reference picture");
  KeptHead head{};
  const std::string bytes = file.bytes(std::ssize(kKeptMagic), sizeof(KeptHead), "the head");
  std::memcpy(&head, bytes.data(), sizeof(KeptHead));
  if (head.width != width || head.height != height) refuse(fmt::format("is {} x {}", head.width, head.height));
  if (file.size() != head_bytes + pixel_bytes) refuse("is too short or too long");
  gl::Picture picture{{width, height, std::vector<float>(static_cast<std::size_t>(4 * pixels))}, head.frame_time_ms};
  const std::string values = file.bytes(head_bytes, pixel_bytes, "the pixels");
  std::memcpy(picture.image.rgba.data(), values.data(), values.size());
  picture.sample_count = head.samples;
  picture.noise = head.noise;
  return picture;
}

void write_kept_reference(const std::string& path, const gl::Picture& reference) {
  const KeptHead head{reference.image.width, reference.image.height, reference.sample_count, 0,
                      reference.noise,       reference.frame_time_ms};
  std::string bytes(kKeptMagic);
  bytes.append(reinterpret_cast<const char*>(&head), sizeof(head));
  bytes.append(reinterpret_cast<const char*>(reference.image.rgba.data()), reference.image.rgba.size() * sizeof(float));
  write_text_file(path, bytes);
}

}  // namespace multum
