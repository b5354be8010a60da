// SPDX-License-Identifier: Apache-2.0
// Makes the head of a DDS file with a DX10 header (Microsoft, "Programming Guide for DDS") for one 2D texture with mip
// levels. The head is everything before the levels' bytes, which follow one another, level 0 first:
//
//   "DDS "  size 124  flags  height  width  pitch or bytes of level 0  depth 0  levels  0 (11)
//   pixel format: size 32  flags: a code  "DX10"  0 (5)       caps  0 (4)
//   DX10: DXGI_FORMAT  2D  0  array of 1  alpha mode          (4 bytes each)
#pragma once

#include "host/delivery/export/texture_head.h"

namespace multum {

TextureHead dds_head(const LeveledTexture& texture);

}  // namespace multum
