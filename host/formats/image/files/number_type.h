// SPDX-License-Identifier: Apache-2.0
// Types of the numbers that image files store. Their codes are OpenImageIO's TypeDesc::BASETYPE, in which the decoder
// speaks (host/formats/decoder/library_image_file.cpp holds them equal), so that nobody else needs its headers.
#pragma once

#include <cstddef>

namespace multum {

namespace number_type {
constexpr int kUint8 = 2, kInt8 = 3, kUint16 = 4, kInt16 = 5, kUint32 = 6, kInt32 = 7, kUint64 = 8, kInt64 = 9;
constexpr int kHalf = 10, kFloat = 11, kDouble = 12;
}  // namespace number_type

/// Whether the code is one of these.
constexpr bool is_number_type(int code) { return code >= number_type::kUint8 && code <= number_type::kDouble; }

/// Bytes of one number; 0 for other codes.
std::size_t number_bytes(int code);

/// Name of a type in messages: "uint8", "half"; "unknown" for other codes.
const char* number_name(int code);

}  // namespace multum
