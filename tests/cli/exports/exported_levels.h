// SPDX-License-Identifier: Apache-2.0
// Reads levels of the files of multum export, for tests: images by OpenImageIO, KTX2 and DDS by their headers.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/texel_format.h"

namespace multum::testing {

/// Holds an image as OpenImageIO reads it.
struct Picture {
  int width = 0, height = 0, channels = 0;
  bool is_half = false;
  std::string colour_space;
  std::vector<float> values;

  float at(int x, int y, int c) const { return values[static_cast<std::size_t>((y * width + x) * channels + c)]; }
};

/// Fails the test if the image cannot be read.
Picture read_picture(const std::string& path);

/// Returns a level's bytes from a file without supercompression. The index of a KTX2 file gives the place of each
/// level. In a DDS file, the levels are stored in order.
std::string level_of(const std::string& bytes, TexelFormat format, int width, int height, int level);

/// Returns the texels as a shader reads them, with four values per texel.
std::vector<float> decoded_level(const std::string& bytes, TexelFormat format, int width, int height);

}  // namespace multum::testing
