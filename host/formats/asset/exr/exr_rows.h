// SPDX-License-Identifier: Apache-2.0
// Converts rows of a baked file's part to what OpenEXR takes and gives. For host/formats/asset alone.
#pragma once

#include <ImfFrameBuffer.h>
#include <ImfPixelType.h>

#include <cstddef>

#include "host/formats/asset/representation.h"

namespace multum {

/// Half values go to HALF channels exactly (they were rounded before); everything else to FLOAT.
inline Imf::PixelType vector_type(StorageEncoding encoding) {
  return encoding == StorageEncoding::kHalf ? Imf::HALF : Imf::FLOAT;
}
inline Imf::PixelType colour_type(StorageEncoding encoding) {
  return encoding == StorageEncoding::kFloat ? Imf::FLOAT : Imf::HALF;
}

/// OpenEXR's threads are one pool for all files of the process: it only grows.
void use_exr_threads(int threads);

/// One channel of rows: `first` is its value at the left end of `first_row`.
Imf::Slice row_slice(Imf::PixelType type, const void* first, std::size_t texel_stride, int width, int first_row,
                     int row_count);

inline std::size_t texel_count(int width, int rows) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(rows);
}

}  // namespace multum
