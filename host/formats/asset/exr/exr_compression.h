// SPDX-License-Identifier: Apache-2.0
// Names of compressions in settings, such as "zip", "zip:4" and "rle".
#pragma once

#include <ImfCompression.h>

#include <string>

namespace multum {

struct ExrCompression {
  Imf::Compression compression;
  int zip_level;  // -1 selects the library's default
};

/// Throws Error(kUsage) for an unknown name.
ExrCompression parse_compression(const std::string& text);

}  // namespace multum
