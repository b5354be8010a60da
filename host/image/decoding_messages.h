// SPDX-License-Identifier: Apache-2.0
// What a process and its decoder say to each other (host/base/helper_process.h carries it).
//
//   request   kOpen, path, texel_count_max, threads, all_parts     answer   kDone, description
//             kRead, block, offset in the shared memory                     kDone, what the library says against it
//             kClose                                                        kDone
//             any                                                           kRefused, error code, message
//             any                                                           kOutOfMemory
#pragma once

#include <string>
#include <string_view>

#include "host/base/shared_memory.h"
#include "host/image/image_file.h"

namespace multum {

enum class DecodingRequest : std::uint8_t { kOpen, kRead, kClose };
enum class DecodingAnswer : std::uint8_t { kDone, kRefused, kOutOfMemory };

std::string open_answer(const ImageDescription& description);
std::string open_request(const std::string& path, const ImageFileSettings& settings);
std::string read_request(const PixelBlock& block, std::size_t offset);
std::string close_request();

/// What an answer may be of: taken apart by the functions below. They throw Error as the child did, and Error(kInput)
/// that names the file when the answer is none; `memory_max` is what the child was held to.
struct AskedFile {
  std::string path;
  std::uint64_t memory_max;
};
ImageDescription parse_open_answer(const AskedFile& file, std::string_view answer);
std::string parse_read_answer(const AskedFile& file, std::string_view answer);

/// The child's side: one open file at a time.
class ImageDecoder {
 public:
  std::string answer(std::string_view request, SharedMemory& memory);

 private:
  std::string do_as_asked(std::string_view request, SharedMemory& memory);
  std::unique_ptr<LibraryImageFile> file_;
  std::string path_;
};

}  // namespace multum
