// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/files/memory_image_file.h"

#include <fmt/format.h>

#include <cstring>
#include <utility>
#include <vector>

#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/memory_images.h"

namespace multum {
namespace {

class MemoryImageFile : public ImageFile {
 public:
  explicit MemoryImageFile(MemoryImage image) : image_(std::move(image)) {
    ImagePart part;
    part.width = part.full_width = image_.width;
    part.height = part.full_height = image_.height;
    part.base_type = image_.base_type;
    part.channel_names = image_.channel_names;
    const bool has_alpha = part.channel_names.size() == 2 || part.channel_names.size() == 4;
    if (has_alpha && part.channel_names.back() == "A") part.alpha_channel = part.channel_count() - 1;
    description_.format = "array";
    description_.file_size = std::int64_t{image_.height} * image_.width * static_cast<std::int64_t>(image_.texel_bytes);
    description_.parts.push_back(std::move(part));
  }

  std::byte* reserve(std::size_t byte_count) override {
    memory_.resize(byte_count);
    return memory_.data();
  }

  std::string read(const PixelBlock& block, std::size_t offset, const std::function<void()>&) override {
    MULTUM_CHECK(offset <= memory_.size() && block_bytes(part(), block) <= memory_.size() - offset);
    if (block.base_type != image_.base_type)
      return fmt::format("found samples of type {}, expected {}", number_name(image_.base_type),
                         number_name(block.base_type));
    const std::size_t sample = number_bytes(image_.base_type);
    const std::size_t first = static_cast<std::size_t>(block.channel_begin) * sample;
    const std::size_t count = static_cast<std::size_t>(block.channel_end - block.channel_begin) * sample;
    std::byte* to = memory_.data() + offset;
    for (int y = block.y_begin; y < block.y_end; ++y) {
      const std::byte* from = image_.first_row + y * image_.row_bytes + first;
      if (count == image_.texel_bytes) {
        std::memcpy(to, from, static_cast<std::size_t>(image_.width) * count);
        to += static_cast<std::size_t>(image_.width) * count;
        continue;
      }
      for (int x = 0; x < image_.width; ++x, to += count, from += image_.texel_bytes) std::memcpy(to, from, count);
    }
    return "";
  }

 private:
  const MemoryImage image_;
  std::vector<std::byte> memory_;
};

}  // namespace

std::unique_ptr<ImageFile> open_memory_image(const std::string& path) {
  std::optional<MemoryImage> image = find_memory_image(path);
  if (!image) return nullptr;
  return std::make_unique<MemoryImageFile>(std::move(*image));
}

}  // namespace multum
