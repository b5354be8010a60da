// SPDX-License-Identifier: Apache-2.0
// Reads an image file with a library in this process. This code is used by multum-decode, which may crash on a broken
// file, and by tests.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/image/files/image_file.h"

namespace multum {

/// Reads an image into the caller's memory, or into its own memory.
class LibraryImageFile : public ImageFile {
 public:
  virtual std::string read_into(const PixelBlock& block, std::byte* memory) = 0;

  std::byte* reserve(std::size_t byte_count) override;
  std::string read(const PixelBlock& block, std::size_t offset, const std::function<void()>&) override;

 private:
  std::vector<std::byte> memory_;
};

/// Opens a JPEG, KTX2 or PNG file with the small library of its format. Returns null for other formats, for CMYK, and
/// if the texts of a JPEG or PNG file are wanted. Throws like open_image_file().
std::unique_ptr<LibraryImageFile> open_small_library_image(const std::string& path, const ImageFileSettings& settings);

}  // namespace multum
