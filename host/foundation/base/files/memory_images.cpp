// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/memory_images.h"

#include <map>
#include <mutex>
#include <utility>

#include "host/foundation/base/files/content_hash.h"

namespace multum {
namespace {

// No file has such a name, and the name contains no colon that could separate a channel.
constexpr char kPrefix[] = "<memory ";

struct Names {
  std::mutex mutex;
  std::map<std::string, MemoryImage> images;
  std::size_t made = 0;
};

Names& names() {
  static Names all;
  return all;
}

}  // namespace

MemoryImageName::MemoryImageName(MemoryImage image, const std::string& name) {
  Names& all = names();
  const std::lock_guard lock(all.mutex);
  path_ = kPrefix + std::to_string(++all.made) + ">/" + name;
  all.images.emplace(path_, std::move(image));
}

MemoryImageName::~MemoryImageName() {
  Names& all = names();
  const std::lock_guard lock(all.mutex);
  all.images.erase(path_);
}

std::optional<MemoryImage> find_memory_image(const std::string& path) {
  if (!path.starts_with(kPrefix)) return std::nullopt;
  Names& all = names();
  const std::lock_guard lock(all.mutex);
  const auto found = all.images.find(path);
  return found == all.images.end() ? std::nullopt : std::optional(found->second);
}

std::string hash_memory_image(const MemoryImage& image) {
  ContentHash hash;
  const int head[] = {image.width, image.height, static_cast<int>(image.channel_names.size()), image.base_type};
  hash.update(head, sizeof(head));
  const std::size_t bytes = static_cast<std::size_t>(image.width) * image.texel_bytes;
  for (int y = 0; y < image.height; ++y) hash.update(image.first_row + y * image.row_bytes, bytes);
  return hash.finish();
}

std::string with_plain_image_names(std::string message) {
  for (std::size_t begin = message.find(kPrefix); begin != std::string::npos; begin = message.find(kPrefix, begin)) {
    std::size_t end = begin + sizeof(kPrefix) - 1;
    const std::size_t digits = end;
    while (end < message.size() && message[end] >= '0' && message[end] <= '9') ++end;
    if (end == digits || message.compare(end, 2, ">/") != 0) begin = digits;
    else message.erase(begin, end + 2 - begin);
  }
  return message;
}

}  // namespace multum
