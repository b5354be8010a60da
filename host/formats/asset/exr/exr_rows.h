// SPDX-License-Identifier: Apache-2.0
// Converts rows of a part to and from OpenEXR's slices. Only host/formats/asset uses this file.
#pragma once

#include <ImfFrameBuffer.h>
#include <ImfPixelType.h>

#include <cstddef>

#include "host/formats/asset/representation.h"

namespace multum {

/// Stores half values in HALF channels, which is exact because the values were rounded before. Stores all other values
/// in FLOAT channels.
inline Imf::PixelType vector_type(StorageEncoding encoding) {
  return encoding == StorageEncoding::kHalf ? Imf::HALF : Imf::FLOAT;
}
inline Imf::PixelType colour_type(StorageEncoding encoding) {
  return encoding == StorageEncoding::kFloat ? Imf::FLOAT : Imf::HALF;
}

/// Sets the size of OpenEXR's thread pool. All files of the process share one pool, which only grows.
void use_exr_threads(int threads);

/// Returns the slice of one channel of rows. `first` points to the channel's value at the left end of `first_row`.
Imf::Slice row_slice(Imf::PixelType type, const void* first, std::size_t texel_stride, int width, int first_row,
                     int row_count);

inline std::size_t texel_count(int width, int rows) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(rows);
}

}  // namespace multum
