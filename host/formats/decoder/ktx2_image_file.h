// SPDX-License-Identifier: Apache-2.0
// Decodes level 0 of KTX2 files (host/formats/image/files/ktx2_survey.h), which OpenImageIO cannot read.
#pragma once

#include <memory>
#include <string>

#include "host/formats/decoder/library_image_file.h"

namespace multum {

/// Opens the file. Throws Error(kInput), which names the file.
std::unique_ptr<LibraryImageFile> open_ktx2_image(const std::string& path, const ImageContainer& container);

}  // namespace multum
