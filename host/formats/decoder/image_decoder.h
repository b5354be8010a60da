// SPDX-License-Identifier: Apache-2.0
// Decodes images in the child process, and answers the requests of host/formats/image/files/decoding_messages.h.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "host/formats/decoder/library_image_file.h"
#include "host/foundation/sandbox/shared_memory.h"

namespace multum {

/// Decodes one open file at a time.
class ImageDecoder {
 public:
  /// Throws Error if the request fails.
  std::string answer(std::string_view request, SharedMemory& memory);
  void close() { file_.reset(); }

 private:
  std::unique_ptr<LibraryImageFile> file_;
};

}  // namespace multum
