// SPDX-License-Identifier: Apache-2.0
// What a process and its decoder of images say to each other (host/base/decoding_answer.h).
//
//   request   kOpenImage, path, texel_count_max, threads, all_parts   answer   description
//             kReadImage, block, offset in the shared memory                   what the library says against it
#pragma once

#include <string>
#include <string_view>

#include "host/base/decoding_answer.h"
#include "host/base/shared_memory.h"
#include "host/image/image_file.h"

namespace multum {

std::string open_answer(const ImageDescription& description);
std::string open_request(const std::string& path, const ImageFileSettings& settings);
std::string read_request(const PixelBlock& block, std::size_t offset);

ImageDescription parse_open_answer(MessageReader& in);
std::string parse_read_answer(MessageReader& in);

/// The child's side: one open file at a time. Throws Error where it cannot do as asked.
class ImageDecoder {
 public:
  std::string answer(std::string_view request, SharedMemory& memory);
  void close() { file_.reset(); }

 private:
  std::unique_ptr<LibraryImageFile> file_;
};

}  // namespace multum
