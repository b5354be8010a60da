// SPDX-License-Identifier: Apache-2.0
// Gives names to images in the memory of this process, so that jobs can name them like files. Only libmultum makes such
// names (host/api).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace multum {

/// Pixels in memory. The rows are stored from the top, and the channels are interleaved. `base_type` is a type of
/// host/formats/image/files/number_type.h.
struct MemoryImage {
  int width = 0, height = 0;
  std::vector<std::string> channel_names;  // one per channel
  int base_type = 0;
  std::size_t texel_bytes = 0;
  std::ptrdiff_t row_bytes = 0;  // distance from the beginning of one row to the next; negative if the last row comes
                                 // first
  const std::byte* first_row = nullptr;
};

/// Registers a name for an image while the object exists. During this time, the pixels of the image must stay
/// unchanged.
class MemoryImageName {
 public:
  /// `name` is used in messages, for example "normal map". Throws std::bad_alloc.
  MemoryImageName(MemoryImage image, const std::string& name);
  ~MemoryImageName();
  MemoryImageName(const MemoryImageName&) = delete;
  MemoryImageName& operator=(const MemoryImageName&) = delete;
  /// Returns the name that can be used as the path of a file.
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Returns the image with this name, or nullopt if the path is not such a name.
std::optional<MemoryImage> find_memory_image(const std::string& path);

/// Returns the SHA-256 of an image's size, type and pixels.
std::string hash_memory_image(const MemoryImage& image);

/// Returns the message with plain names of images, such as "normal map" instead of "<memory 3>/normal map".
std::string with_plain_image_names(std::string message);

}  // namespace multum
