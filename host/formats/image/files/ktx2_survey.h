// SPDX-License-Identifier: Apache-2.0
// Examines KTX2 files (Khronos, KTX 2.0), which hold textures for GPUs. Accepts the kinds of texels that multum writes
// into models, which are plain values and UASTC blocks, with or without Zstandard. Only level 0 is used as a picture.
#pragma once

#include <cstdint>
#include <string>

#include "host/foundation/base/files/byte_file.h"

namespace multum {

constexpr char kKtx2Magic[] = "\xabKTX 20\xbb\r\n\x1a\n";  // the first twelve bytes

struct Ktx2Survey {
  std::int64_t width = 0, height = 0;  // size of level 0
  int base_type = 0;                   // a code of host/formats/image/files/number_type.h
  int channel_count = 0;
  bool is_uastc = false;  // true for blocks of 4 x 4 texels with 16 bytes each and four 8-bit channels
  bool is_srgb = false;
  bool is_zstd = false;
  std::int64_t begin = 0, stored_bytes = 0;  // place and size of level 0 in the file
  std::int64_t bytes = 0;                    // size of all rows of texels or blocks after decompression
};

/// Throws Error(kInput), which names the file, if it is truncated, is an array, a cube or a volume, or has texels or a
/// compression of another kind.
Ktx2Survey survey_ktx2(const std::string& path, ByteFile& file);

}  // namespace multum
