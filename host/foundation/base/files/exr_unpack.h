// SPDX-License-Identifier: Apache-2.0
// Unpacks a chunk of an OpenEXR file to exactly the bytes that it must have.
#pragma once

#include <cstddef>

namespace multum {

/// Numbers of the header's attribute "compression".
namespace exr_compression {
constexpr int kNone = 0, kRle = 1, kZips = 2, kZip = 3, kPiz = 4, kPxr24 = 5, kB44 = 6, kB44a = 7, kDwaa = 8, kDwab = 9;
constexpr int kCount = 10;
}  // namespace exr_compression

/// "none", "zip", ...
const char* exr_compression_name(int compression);
/// Rows of a chunk where rows are not tiled; 0: no such compression.
int exr_rows_per_chunk(int compression);

/// Does unpack_exr() know the compression?
inline bool can_unpack_exr(int compression) { return compression >= 0 && compression <= exr_compression::kZip; }

/// Writes all `size` bytes of `unpacked` and returns null, or says what is wrong with the packed bytes: what is in
/// `unpacked` is then of no use. As many packed bytes as unpacked ones are stored as they are.
const char* unpack_exr(int compression, const unsigned char* packed, std::size_t packed_size, unsigned char* unpacked,
                       std::size_t size);

/// Says what unpack_exr() would, and keeps nothing: for whoever hands the packed bytes to a library.
const char* check_exr(int compression, const unsigned char* packed, std::size_t packed_size, std::size_t size);

/// Can so few packed bytes unpack to `size`? Keeps a damaged size from taking memory.
bool may_unpack_exr(int compression, std::size_t packed_size, std::size_t size);

}  // namespace multum
