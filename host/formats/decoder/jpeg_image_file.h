// SPDX-License-Identifier: Apache-2.0
// Opens JPEG files with libjpeg in this process. The descriptions and values are the same as from OpenImageIO, which
// calls libjpeg too.
#pragma once

#include <memory>
#include <string>

#include "host/formats/decoder/library_image_file.h"

namespace multum {

/// Reads grey or RGB. Returns null for other colours (CMYK), which OpenImageIO converts. Throws Error(kInput), which
/// names the file, if it is damaged.
std::unique_ptr<LibraryImageFile> open_jpeg_image(const std::string& path, const ImageContainer& container);

}  // namespace multum
