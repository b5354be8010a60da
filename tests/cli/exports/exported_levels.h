// SPDX-License-Identifier: Apache-2.0
// Levels of the files that multum export writes, for tests: images by OpenImageIO, KTX2 and DDS by their heads.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/texel_format.h"

namespace multum::testing {

/// An image as OpenImageIO reads it.
struct Picture {
  int width = 0, height = 0, channels = 0;
  bool is_half = false;
  std::string colour_space;
  std::vector<float> values;

  float at(int x, int y, int c) const { return values[static_cast<std::size_t>((y * width + x) * channels + c)]; }
};

/// Fails the test where it cannot be read.
Picture read_picture(const std::string& path);

/// A level's bytes in a file with a head that is not packed: of KTX2 by its index, of DDS one behind the other.
std::string level_of(const std::string& bytes, TexelFormat format, int width, int height, int level);

/// Texels as shaders find them, four values each.
std::vector<float> decoded_level(const std::string& bytes, TexelFormat format, int width, int height);

}  // namespace multum::testing
