// SPDX-License-Identifier: Apache-2.0
// Opens image files by OpenImageIO in this process: for multum-decode, which a broken file may end, and for tests.
#pragma once

#include <memory>
#include <string>

#include "host/image/files/image_file.h"

namespace multum {

/// Reads into any memory.
class LibraryImageFile : public ImageFile {
 public:
  virtual std::string read_into(const PixelBlock& block, std::byte* memory) = 0;
};

/// Throws as open_image_file() does. Fits set_image_opener().
std::unique_ptr<LibraryImageFile> open_library_image(const std::string& path, const ImageFileSettings& settings);

}  // namespace multum
