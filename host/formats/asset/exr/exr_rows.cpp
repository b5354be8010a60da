// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/exr/exr_rows.h"

#include <ImfThreading.h>

namespace multum {

void use_exr_threads(int threads) {
  // If there is only one thread, each call does its work itself.
  if (threads > 1 && Imf::globalThreadCount() < threads) Imf::setGlobalThreadCount(threads);
}

Imf::Slice row_slice(Imf::PixelType type, const void* first, std::size_t texel_stride, int width, int first_row,
                     int row_count) {
  return Imf::Slice::Make(type, first, Imath::V2i(0, first_row), width, row_count, texel_stride,
                          texel_stride * static_cast<std::size_t>(width));
}

}  // namespace multum
