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
  std::unique_ptr<HelperProcess> take(const std::string& program) {
    const std::lock_guard lock(mutex_);
    if (idle_ != nullptr && idle_->program() == program) return std::move(idle_);
    return std::make_unique<HelperProcess>(program);
  }
  void give_back(std::unique_ptr<HelperProcess> decoder) {
    const std::lock_guard lock(mutex_);
    idle_ = std::move(decoder);
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<HelperProcess> idle_;
};

IdleDecoders& idle_decoders() {
  static IdleDecoders decoders;
  return decoders;
}

HelperLimits limits_for(const DecodingChild& child, std::uint64_t held_bytes, std::uint64_t picture_bytes) {
  return {child.memory_base + held_bytes,
          std::chrono::milliseconds(child.time_base_ms) + std::chrono::seconds(picture_bytes / kBytesASecond)};
}

std::uint64_t picture_bytes(const ImageDescription& description) {
  std::uint64_t bytes = 0;
  for (const ImagePart& part : description.parts)
    bytes += std::uint64_t{part.texel_bytes()} * static_cast<std::uint64_t>(part.width) *
             static_cast<std::uint64_t>(part.height);
  return bytes;
}

// A child for one file; whoever answers "close" after it is fit for the next.
class BorrowedDecoder {
 public:
  explicit BorrowedDecoder(const std::string& program) : process_(idle_decoders().take(program)) {}
  ~BorrowedDecoder() {
    if (!process_->is_alive()) return;
    try {
      parse_read_answer({}, process_->ask(close_request(), limits_, {}));
      idle_decoders().give_back(std::move(process_));
    } catch (const std::exception&) {  // then it is ended
    }
  }
  BorrowedDecoder(const BorrowedDecoder&) = delete;
  BorrowedDecoder& operator=(const BorrowedDecoder&) = delete;

  void hold_to(const HelperLimits& limits) { limits_ = limits; }
  const HelperLimits& limits() const { return limits_; }
  HelperProcess& process() { return *process_; }

 private:
  std::unique_ptr<HelperProcess> process_;
  HelperLimits limits_{};
};

class ChildImageFile : public ImageFile {
 public:
  // The container is looked at before a library sees it, and says how much there is to decode.
  ChildImageFile(const DecodingChild& child, std::string path, const ImageFileSettings& settings)
      : path_(std::move(path)),
        container_(inspect_image_container(path_, settings.texel_count_max)),
        decoder_(child.program) {
    const auto texels = static_cast<std::uint64_t>(container_.width * container_.height);
    const std::uint64_t held = 2 * static_cast<std::uint64_t>(container_.file_size) + 16 * texels;
    decoder_.hold_to(limits_for(child, held, 4 * texels));
    description_ = parse_open_answer(asked(), ask(open_request(path_, settings), {}));
    check_described(path_, description_, settings.texel_count_max);
    const std::uint64_t bytes = picture_bytes(description_);
    decoder_.hold_to(limits_for(child, held + 4 * bytes, bytes));
  }

  std::byte* reserve(std::size_t byte_count) override { return decoder_.process().memory().reserve(byte_count); }

  std::string read(const PixelBlock& block, std::size_t offset, const std::function<void()>& while_waiting) override {
    return parse_read_answer(asked(), ask(read_request(block, offset), while_waiting));
  }

 private:
  AskedFile asked() const { return {path_, decoder_.limits().memory_max}; }

  std::string ask(const std::string& request, const std::function<void()>& while_waiting) {
    const HelperLimits& limits = decoder_.limits();
    try {
      return decoder_.process().ask(request, limits, while_waiting);
    } catch (const HelperEnded& ended) {
      throw Error(
          ErrorCode::kInput,
          fmt::format("{}: the process that decodes it {}; expected a file that OpenImageIO survives, in {} "
                      "bytes of memory and {} s",
                      path_, ended.what(), limits.memory_max, std::chrono::duration<double>(limits.time_max).count()));
    }
  }

  std::string path_;
  ImageContainer container_;
  BorrowedDecoder decoder_;
};

}  // namespace

ImageOpener open_in_child(const DecodingChild& child) {
  return [child](const std::string& path, const ImageFileSettings& settings) {
    return std::make_unique<ChildImageFile>(child, path, settings);
  };
}

}  // namespace multum
