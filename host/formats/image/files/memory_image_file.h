// SPDX-License-Identifier: Apache-2.0
// Reads images that are in the memory of this process (host/foundation/base/files/memory_images.h). No child process
// and no library is needed, because there is nothing to decode.
#pragma once

#include <memory>
#include <string>

#include "host/formats/image/files/image_file.h"

namespace multum {

/// Returns null if `path` is not the name of an image in memory.
std::unique_ptr<ImageFile> open_memory_image(const std::string& path);

}  // namespace multum
