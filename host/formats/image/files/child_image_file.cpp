// SPDX-License-Identifier: Apache-2.0
// Runs image libraries in a child process (host/foundation/sandbox/decoding_child.h).
//
// Limits of a child. In the worst case, a reader holds the whole picture, and some rows for every thread. Some readers,
// such as WebP, hold the picture twice and with 4 channels. Therefore the limits are
//   memory   memory_base + 2 file sizes + 16 bytes per declared texel; once the file is open, + 4 times the picture
//   time     time_base + 1 s per 4 MiB of the picture, for one answer
#include <chrono>
#include <filesystem>
#include <utility>

#include "host/formats/image/files/decoding_messages.h"
#include "host/foundation/sandbox/decoding_child.h"

namespace multum {
namespace {

std::chrono::seconds time_for(std::uint64_t picture_bytes) {
  constexpr std::uint64_t kBytesASecond = std::uint64_t{4} << 20;  // decoding speed that even a slow machine reaches
  return std::chrono::seconds(picture_bytes / kBytesASecond);
}

std::uint64_t picture_bytes(const ImageDescription& description) {
  std::uint64_t bytes = 0;
  for (const ImagePart& part : description.parts)
    bytes += std::uint64_t{part.texel_bytes()} * static_cast<std::uint64_t>(part.width) *
             static_cast<std::uint64_t>(part.height);
  return bytes;
}

// Returns the library that reads most files of a format.
const char* library_of(const std::string& format) {
  return format == "png" ? "libpng" : format == "jpeg" ? "libjpeg" : "OpenImageIO";
}

class ChildImageFile : public ImageFile {
 public:
  // Examines the container before a library opens the file, and finds the amount of data to decode.
  ChildImageFile(const DecodingChild& child, std::string path, const ImageFileSettings& settings)
      : path_(std::move(path)),
        container_(inspect_image_container(path_, settings.texel_count_max)),
        file_(child, path_, library_of(container_.format)) {
    const auto texels = static_cast<std::uint64_t>(container_.width * container_.height);
    const std::uint64_t held = 2 * static_cast<std::uint64_t>(container_.file_size) + 16 * texels;
    file_.allow(held, time_for(4 * texels));
    description_ = file_.ask(open_request(std::filesystem::absolute(path_).string(), settings), parse_open_answer);
    check_described(path_, description_, settings.texel_count_max);
    const std::uint64_t bytes = picture_bytes(description_);
    file_.allow(held + 4 * bytes, time_for(bytes));
  }

  std::byte* reserve(std::size_t byte_count) override { return file_.memory().reserve(byte_count); }

  std::string read(const PixelBlock& block, std::size_t offset, const std::function<void()>& while_waiting) override {
    return file_.ask(read_request(block, offset), parse_read_answer, while_waiting);
  }

 private:
  std::string path_;
  ImageContainer container_;
  DecodedFile file_;
};

}  // namespace

ImageOpener open_in_child(const DecodingChild& child) {
  return [child](const std::string& path, const ImageFileSettings& settings) {
    return std::make_unique<ChildImageFile>(child, path, settings);
  };
}

}  // namespace multum
