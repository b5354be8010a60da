// SPDX-License-Identifier: Apache-2.0
// Makes the head of a KTX 2.0 file (Khronos, "KTX File Format Specification 2.0") for one 2D texture, or an array of 2D
// textures, with mip levels. The head is everything before the levels' bytes:
//
//   identifier (12)  vkFormat  typeSize  width  height  depth 0  layers  faces 1  levels  supercompression (4 each)
//   index: dfd offset, length  kvd offset, length (4 each)  sgd offset 0, length 0 (8 each)
//   level index, level 0 first: offset  length  uncompressed length (8 each)
//   data format descriptor    key/value data    padding    levels, the smallest first
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/delivery/export/texture_head.h"

namespace multum {

struct Ktx2Key {
  std::string key, value;  // pairs stored after "KTXwriter", in byte order of the keys
};

struct Ktx2Settings {
  std::string writer;   // human-readable name of the writing program
  std::string swizzle;  // sources of r, g, b, a in shaders: four of r, g, b, a, 0, 1; if empty, channels are used as
                        // stored
  // The number of bytes of each level after Zstandard supercompression, beginning with level 0. The list is empty if
  // levels are not supercompressed.
  std::vector<std::uint64_t> zstd_lengths;
  std::vector<Ktx2Key> keys = {};
};

/// The data is linear and does not represent colour. Row 0 is at the top ("rd"). The length of the head does not depend
/// on the values of zstd_lengths.
TextureHead ktx2_head(const LeveledTexture& texture, const Ktx2Settings& settings);

}  // namespace multum
