// SPDX-License-Identifier: Apache-2.0
// OpenImageIO in a child process (tools/multum_decode), which hands pixels over in memory that both see. A child that
// has read a file to its end reads the next one; one that has failed is gone, and a file's failure is no other file's.
//
// What a child may take. Readers hold a whole picture at worst, some of them twice and with 4 channels (WebP), and
// rows of it for every thread; so
//   memory   memory_base + 2 file sizes + 16 bytes a declared texel; once the file is open, + 4 pictures as they are
//   time     time_base + 1 s for every 4 MiB of such pictures, for one answer
#include <chrono>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/helper_process.h"
#include "host/image/decoding_messages.h"

namespace multum {
namespace {

constexpr std::uint64_t kBytesASecond = std::uint64_t{4} << 20;  // what a slow machine decodes at least

// Children between two files.
class IdleDecoders {
 public:
  std::unique_ptr<HelperProcess> take() {
    const std::lock_guard lock(mutex_);
    return std::move(idle_);
  }
  void give_back(std::unique_ptr<HelperProcess> decoder) {
    const std::lock_guard lock(mutex_);
    if (idle_ == nullptr) idle_ = std::move(decoder);
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<HelperProcess> idle_;
};

IdleDecoders& idle_decoders() {
  static IdleDecoders decoders;
  return decoders;
}

HelperLimits limits_for(std::uint64_t held_bytes, std::uint64_t picture_bytes) {
  const ImageDecoding& decoding = image_decoding();
  return {decoding.memory_base + held_bytes,
          std::chrono::milliseconds(decoding.time_base_ms) + std::chrono::seconds(picture_bytes / kBytesASecond)};
}

std::uint64_t picture_bytes(const ImageDescription& description) {
  std::uint64_t bytes = 0;
  for (const ImagePart& part : description.parts)
    bytes += std::uint64_t{part.texel_bytes()} * static_cast<std::uint64_t>(part.width) *
             static_cast<std::uint64_t>(part.height);
  return bytes;
}

class ChildImageFile : public ImageFile {
 public:
  ChildImageFile(std::string path, const ImageContainer& container, const ImageFileSettings& settings)
      : path_(std::move(path)), decoder_(idle_decoders().take()) {
    if (decoder_ == nullptr) decoder_ = std::make_unique<HelperProcess>(image_decoding().program);
    const std::uint64_t held = 2 * static_cast<std::uint64_t>(container.file_size) +
                               16 * static_cast<std::uint64_t>(container.width * container.height);
    limits_ = limits_for(held, static_cast<std::uint64_t>(container.width * container.height) * 4);
    const std::string answer = ask(open_request(path_, settings), {});
    description_ = parse_open_answer({path_, limits_.memory_max}, answer);
    check_described(path_, description_, settings.texel_count_max);
    const std::uint64_t bytes = picture_bytes(description_);
    limits_ = limits_for(held + 4 * bytes, bytes);
  }

  ~ChildImageFile() override {
    try {
      ask(close_request(), {});
      idle_decoders().give_back(std::move(decoder_));
    } catch (const std::exception&) {  // then it is not used again
    }
  }

  std::byte* reserve(std::size_t byte_count) override { return decoder_->memory().reserve(byte_count); }

  std::string read(const PixelBlock& block, std::size_t offset, const std::function<void()>& while_waiting) override {
    return parse_read_answer({path_, limits_.memory_max}, ask(read_request(block, offset), while_waiting));
  }

 private:
  std::string ask(const std::string& request, const std::function<void()>& while_waiting) {
    try {
      return decoder_->ask(request, limits_, while_waiting);
    } catch (const HelperEnded& ended) {
      throw Error(ErrorCode::kInput,
                  fmt::format("{}: the process that decodes it {}; expected a file that OpenImageIO survives, in {} "
                              "bytes of memory and {} s",
                              path_, ended.what(), limits_.memory_max,
                              std::chrono::duration<double>(limits_.time_max).count()));
    }
  }

  std::string path_;
  std::unique_ptr<HelperProcess> decoder_;
  HelperLimits limits_{};
};

}  // namespace

std::unique_ptr<ImageFile> open_in_child(const std::string& path, const ImageContainer& container,
                                         const ImageFileSettings& settings) {
  return std::make_unique<ChildImageFile>(path, container, settings);
}

}  // namespace multum
