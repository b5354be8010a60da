// SPDX-License-Identifier: Apache-2.0
// Unpacks a chunk of an OpenEXR file to exactly the expected size.
#pragma once

#include <cstddef>

namespace multum {

/// Values of the attribute "compression" in the header.
namespace exr_compression {
constexpr int kNone = 0, kRle = 1, kZips = 2, kZip = 3, kPiz = 4, kPxr24 = 5, kB44 = 6, kB44a = 7, kDwaa = 8, kDwab = 9;
constexpr int kCount = 10;
}  // namespace exr_compression

/// Returns "none", "zip" and so on.
const char* exr_compression_name(int compression);
/// Rows per chunk of a part that is not tiled; 0 if the compression is unknown.
int exr_rows_per_chunk(int compression);

/// Returns whether unpack_exr() knows the compression.
inline bool can_unpack_exr(int compression) { return compression >= 0 && compression <= exr_compression::kZip; }

/// Writes all `size` bytes of `unpacked` and returns null. On failure, returns a description of the fault, and the
/// contents of `unpacked` are invalid. A chunk whose packed and unpacked sizes are equal is stored unpacked.
const char* unpack_exr(int compression, const unsigned char* packed, std::size_t packed_size, unsigned char* unpacked,
                       std::size_t size);

/// Returns what unpack_exr() would return, but without the unpacked bytes. Used by callers that pass the packed bytes
/// to a library.
const char* check_exr(int compression, const unsigned char* packed, std::size_t packed_size, std::size_t size);

/// Returns whether this number of packed bytes can unpack to `size` bytes. The check prevents allocating memory for a
/// size that is damaged.
bool may_unpack_exr(int compression, std::size_t packed_size, std::size_t size);

}  // namespace multum
