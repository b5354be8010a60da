// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/library_image_file.h"

#include <algorithm>

#include "host/formats/decoder/jpeg_image_file.h"
#include "host/formats/decoder/ktx2_image_file.h"
#include "host/formats/decoder/png_image_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/sandbox/damaged_file.h"

namespace multum {

std::byte* LibraryImageFile::reserve(std::size_t byte_count) {
  memory_.resize(std::max(byte_count, memory_.size()));
  return memory_.data();
}

std::string LibraryImageFile::read(const PixelBlock& block, std::size_t offset, const std::function<void()>&) {
  MULTUM_CHECK(offset <= memory_.size() && block_bytes(part(block.part), block) <= memory_.size() - offset);
  return read_into(block, memory_.data() + offset);
}

std::unique_ptr<LibraryImageFile> open_small_library_image(const std::string& path, const ImageFileSettings& settings) {
  struct Reader {
    const char* format;
    std::unique_ptr<LibraryImageFile> (*open)(const std::string&, const ImageContainer&);
    bool reads_texts;
  };
  constexpr Reader kReaders[] = {
      {"jpeg", open_jpeg_image, false}, {"ktx2", open_ktx2_image, true}, {"png", open_png_image, false}};
  const std::string format = image_format(path);
  for (const Reader& reader : kReaders) {
    if (format != reader.format || (settings.all_parts && !reader.reads_texts)) continue;
    const ImageContainer container = inspect_image_container(path, settings.texel_count_max);
    return with_damage_named(path, [&] { return reader.open(path, container); });
  }
  return nullptr;
}

}  // namespace multum
