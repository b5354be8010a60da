// SPDX-License-Identifier: Apache-2.0
// Makes tables for kernels/pyramidal_regularization.cl. The tables describe bilinear interpolation between the levels
// of a mip pyramid of any size, clamped or periodic, and its transpose.
#pragma once

#include <vector>

#include "host/formats/asset/mip_layout.h"
#include "kernels/shared/mip_pyramid.h"

namespace multum {

struct PyramidTables {
  std::vector<MultumMipLevel> levels;
  std::vector<MultumTap> taps;
  std::vector<MultumGather> gathers;
  std::vector<MultumGatherEntry> entries;
  std::vector<MultumStrip> strips;
  std::vector<float> diagonal;  // diagonal of R^T R, one value per texel
};

/// `strip_length` is the number of texels per work-item, at least 1.
PyramidTables make_pyramid_tables(const MipLayout& layout, bool is_periodic_s, bool is_periodic_t, int strip_length);

}  // namespace multum
