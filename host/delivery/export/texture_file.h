// SPDX-License-Identifier: Apache-2.0
// Writes files of textures with all their levels, KTX2 and DDS, rows of any level as they come.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/delivery/export/ktx2_head.h"
#include "host/delivery/export/texel_format.h"

namespace multum {

/// A file that appears whole or not at all. Everything throws Error(kEnvironment) when it cannot be written.
class TextureFile {
 public:
  virtual ~TextureFile() = default;
  /// The next rows of blocks of a level, in the texture's format (of texels where blocks are texels); layers of an
  /// array one behind the other, levels in any order.
  virtual void write_rows(int level, int row_count, const void* blocks) = 0;
  /// Gives the file its name, after all rows of all levels.
  virtual void finish() = 0;
};

/// The highest level of Zstandard whose files any reader takes: those above need more memory to read.
constexpr int kZstdLevelMax = 19;

struct Ktx2Choice {
  std::string swizzle;  // host/delivery/export/ktx2_head.h
  int zstd_level = 0;   // of supercompression, 1..kZstdLevelMax; 0: none
  std::vector<Ktx2Key> keys = {};
};

/// Supercompressed levels wait in a scratch file in the same folder until the file is finished.
std::unique_ptr<TextureFile> make_ktx2_file(const std::string& path, const LeveledTexture& texture,
                                            const Ktx2Choice& choice = {});

/// With a DX10 header; no arrays.
std::unique_ptr<TextureFile> make_dds_file(const std::string& path, const LeveledTexture& texture);

}  // namespace multum
