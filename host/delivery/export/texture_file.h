// SPDX-License-Identifier: Apache-2.0
// Writes KTX2 and DDS texture files with all levels. Levels can arrive in any order.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/delivery/export/ktx2_head.h"
#include "host/delivery/export/texel_format.h"

namespace multum {

/// A texture file, which appears complete or not at all. Every function throws Error(kEnvironment) if writing fails.
class TextureFile {
 public:
  virtual ~TextureFile() = default;
  /// Writes the next rows of blocks of a level in the texture's format. A block may be a single texel. The layers of an
  /// array follow one another. Levels can arrive in any order.
  virtual void write_rows(int level, int row_count, const void* blocks) = 0;
  /// Renames the file to its final name, after all rows of all levels have been written.
  virtual void finish() = 0;
};

/// The highest Zstandard level whose files all readers accept. Reading files of higher levels needs more memory.
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
