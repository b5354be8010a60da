// SPDX-License-Identifier: Apache-2.0
// Writes KTX2 and DDS texture files with all levels. Rows of any level can arrive in any order of levels.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/delivery/export/ktx2_head.h"
#include "host/delivery/export/texel_format.h"

namespace multum {

/// A texture file that appears complete or not at all. Every function throws Error(kEnvironment) if writing fails.
class TextureFile {
 public:
  virtual ~TextureFile() = default;
  /// Writes the next rows of blocks of a level in the texture's format. Blocks may be single texels. Layers of an array
  /// follow one another. Levels come in any order.
  virtual void write_rows(int level, int row_count, const void* blocks) = 0;
  /// Gives the file its name, after all rows of all levels were written.
  virtual void finish() = 0;
};

/// The highest Zstandard level whose files all readers accept. Higher levels need more memory to read.
constexpr int kZstdLevelMax = 19;

struct Ktx2Choice {
  std::string swizzle;  // see host/delivery/export/ktx2_head.h
  int zstd_level = 0;   // supercompression level, 1..kZstdLevelMax; 0 if not supercompressed
  std::vector<Ktx2Key> keys = {};
};

/// Supercompressed levels wait in a scratch file in the same folder until the file is finished.
std::unique_ptr<TextureFile> make_ktx2_file(const std::string& path, const LeveledTexture& texture,
                                            const Ktx2Choice& choice = {});

/// Writes a DX10 header. Arrays are not supported.
std::unique_ptr<TextureFile> make_dds_file(const std::string& path, const LeveledTexture& texture);

}  // namespace multum
