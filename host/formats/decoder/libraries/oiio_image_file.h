// SPDX-License-Identifier: Apache-2.0
// Opens image files with OpenImageIO in this process.
#pragma once

#include <memory>
#include <string>

#include "host/formats/decoder/library_image_file.h"

namespace multum {

/// Throws like open_image_file().
std::unique_ptr<LibraryImageFile> open_oiio_image(const std::string& path, const ImageFileSettings& settings);

/// Opens a file with the small library of its format, or with OpenImageIO. Throws like open_image_file(). This function
/// can be passed to set_image_opener().
std::unique_ptr<LibraryImageFile> open_library_image(const std::string& path, const ImageFileSettings& settings);

}  // namespace multum
