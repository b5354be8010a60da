// SPDX-License-Identifier: Apache-2.0
// Writes KTX 2.0 files (Khronos, "KTX File Format Specification 2.0"): one 2D texture with a level for each mip, not
// compressed, rows of any level as they come. Its head, before the levels' bytes:
//
//   identifier (12)  vkFormat  typeSize  width  height  depth 0  layers 0  faces 1  levels  supercompression 0 (4 each)
//   index: dfd offset, length  kvd offset, length (4 each)  sgd offset 0, length 0 (8 each)
//   level index, level 0 first: offset  length  uncompressed length (8 each)
//   data format descriptor    key/value data    padding    levels, the smallest first
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/base/files/atomic_file.h"
#include "host/base/files/output_file.h"

namespace multum {

enum class Ktx2Format { kRg8, kRgba8, kRgba16f };

/// Bytes of a texel.
std::size_t texel_bytes(Ktx2Format format);

struct Ktx2Texture {
  Ktx2Format format = Ktx2Format::kRgba8;
  int width = 1, height = 1;
  int level_count = 1;  // of sides that are halved and rounded down
};

/// All before the levels' bytes, and where they go.
struct Ktx2Head {
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint64_t> level_offsets;  // level 0 first
};

/// Data is linear and no colour; row 0 is on top ("rd"); `writer`: who wrote it, for people.
Ktx2Head ktx2_head(const Ktx2Texture& texture, const std::string& writer);

/// A file that appears whole or not at all. Everything throws Error(kEnvironment) when it cannot be written.
class Ktx2File {
 public:
  Ktx2File(const std::string& path, const Ktx2Texture& texture);

  /// The next rows of a level, in the texture's format; levels in any order.
  void write_rows(int level, int row_count, const void* texels);
  /// Gives the file its name, after all rows of all levels.
  void finish();

 private:
  AtomicFile file_;
  OutputFile bytes_;
  const Ktx2Texture texture_;
  const Ktx2Head head_;
  std::vector<int> rows_;  // that are written, by level
};

}  // namespace multum
