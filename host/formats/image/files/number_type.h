// SPDX-License-Identifier: Apache-2.0
// The types of the numbers in image files. Their codes are those of OpenImageIO's TypeDesc::BASETYPE, which the decoder
// uses (host/formats/decoder/library_image_file.cpp checks that they are equal). Therefore only the decoder needs
// OpenImageIO's headers.
#pragma once

#include <cstddef>

namespace multum {

namespace number_type {
constexpr int kUint8 = 2, kInt8 = 3, kUint16 = 4, kInt16 = 5, kUint32 = 6, kInt32 = 7, kUint64 = 8, kInt64 = 9;
constexpr int kHalf = 10, kFloat = 11, kDouble = 12;
}  // namespace number_type

/// Returns whether the code belongs to one of these types.
constexpr bool is_number_type(int code) { return code >= number_type::kUint8 && code <= number_type::kDouble; }

/// Returns the number of bytes of one number, or 0 for other codes.
std::size_t number_bytes(int code);

/// Returns the name of a type for messages, such as "uint8" or "half". Returns "unknown" for other codes.
const char* number_name(int code);

}  // namespace multum
