// SPDX-License-Identifier: Apache-2.0
// Opens PNG files with libpng in this process. The descriptions and values are the same as from OpenImageIO, whose
// libraries take a quarter of a second to load.
#pragma once

#include <memory>
#include <string>

#include "host/formats/decoder/library_image_file.h"

namespace multum {

/// Reads the picture's values as stored. Palettes become RGB, grey of less than 8 bits becomes 8 bits, and a
/// transparent colour becomes alpha. Throws Error(kInput), which names the file, if it is damaged.
std::unique_ptr<LibraryImageFile> open_png_image(const std::string& path, const ImageContainer& container);

}  // namespace multum
