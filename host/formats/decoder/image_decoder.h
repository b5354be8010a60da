// SPDX-License-Identifier: Apache-2.0
// Decodes images in the child process, and answers the requests of host/formats/image/files/decoding_messages.h.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "host/formats/decoder/library_image_file.h"
#include "host/foundation/sandbox/shared_memory.h"

namespace multum {

/// Decodes one open file at a time.
class ImageDecoder {
 public:
  using Opener = std::function<std::unique_ptr<LibraryImageFile>(const std::string&, const ImageFileSettings&)>;

  explicit ImageDecoder(Opener opener) : opener_(std::move(opener)) {}

  /// Throws Error if the request fails. Returns "" if the opener returns null.
  std::string answer(std::string_view request, SharedMemory& memory);
  bool is_open() const { return file_ != nullptr; }
  void close() { file_.reset(); }

 private:
  Opener opener_;
  std::unique_ptr<LibraryImageFile> file_;
};

}  // namespace multum
