// SPDX-License-Identifier: Apache-2.0
// Messages between a process and its decoder of images (host/formats/decoder/image_decoder.h).
//
//   request   kOpenImage, path, texel_count_max, threads, all_parts   answer   description
//             kReadImage, block, offset in the shared memory                   the library's error, or nothing
#pragma once

#include <string>

#include "host/formats/image/files/image_file.h"
#include "host/foundation/sandbox/decoding_answer.h"

namespace multum {

std::string open_answer(const ImageDescription& description);
std::string open_request(const std::string& path, const ImageFileSettings& settings);
std::string read_request(const PixelBlock& block, std::size_t offset);

ImageDescription parse_open_answer(MessageReader& in);
std::string parse_read_answer(MessageReader& in);

}  // namespace multum
