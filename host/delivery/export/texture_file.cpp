// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/texture_file.h"

#include <zstd.h>

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "host/delivery/export/dds_head.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_file.h"
#include "host/foundation/base/files/scratch_file.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/version.h"

namespace multum {
namespace {

// Counts the rows of each level.
class RowCounts {
 public:
  explicit RowCounts(const LeveledTexture& texture) : texture_(texture), rows_(size_of(texture.level_count), 0) {}

  /// Counts new rows and returns the index of the first one.
  int add(int level, int row_count) {
    const int first = rows_[size_of(level)];
    MULTUM_CHECK(first + row_count <= block_rows(texture_, level));
    rows_[size_of(level)] += row_count;
    return first;
  }
  void check_complete() const {
    for (int level = 0; level < texture_.level_count; ++level)
      MULTUM_CHECK(rows_[size_of(level)] == block_rows(texture_, level));
  }

 private:
  const LeveledTexture texture_;
  std::vector<int> rows_;  // by level
};

// Writes uncompressed levels. The head is known before the first row.
class PlainTextureFile : public TextureFile {
 public:
  PlainTextureFile(const std::string& path, const LeveledTexture& texture, TextureHead head)
      : file_(path), bytes_(file_), texture_(texture), head_(std::move(head)), counts_(texture) {
    write_or_throw(bytes_, head_.bytes.data(), head_.bytes.size());
  }

  void write_rows(int level, int row_count, const void* blocks) override {
    const std::uint64_t row_bytes = block_row_bytes(texture_, level);
    const int first = counts_.add(level, row_count);
    // Gaps between levels are zeros, because unwritten parts of a file read as zeros.
    if (!bytes_.seek(head_.level_offsets[size_of(level)] + row_bytes * size_of(first))) bytes_.close();  // throws
    write_or_throw(bytes_, blocks, static_cast<std::size_t>(row_bytes) * size_of(row_count));
  }
  void finish() override {
    counts_.check_complete();
    bytes_.close();
    file_.commit();
  }

 private:
  AtomicFile file_;
  OutputFile bytes_;
  const LeveledTexture texture_;
  const TextureHead head_;
  RowCounts counts_;
};

// Compresses bytes of a scratch file into one Zstandard frame. The pieces have a fixed size, because their size affects
// the compressed bytes.
class ZstdFrames {
 public:
  explicit ZstdFrames(int level)
      : context_(ZSTD_createCCtx(), ZSTD_freeCCtx), in_(kPiece), out_(ZSTD_CStreamOutSize()) {
    MULTUM_CHECK(context_ != nullptr);
    check(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, level));
  }

  /// Returns the compressed size of the frame.
  std::uint64_t write(const ScratchFile& from, std::uint64_t begin, std::uint64_t count, OutputFile& to) {
    check(ZSTD_CCtx_reset(context_.get(), ZSTD_reset_session_only));
    check(ZSTD_CCtx_setPledgedSrcSize(context_.get(), count));
    const std::uint64_t start = to.position();
    for (std::uint64_t at = 0; at < count;) {
      const auto piece = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, count - at));
      from.read(begin + at, in_.data(), piece);
      at += piece;
      ZSTD_inBuffer in = {in_.data(), piece, 0};
      const ZSTD_EndDirective directive = at == count ? ZSTD_e_end : ZSTD_e_continue;
      for (bool is_done = false; !is_done;) {
        ZSTD_outBuffer out = {out_.data(), out_.size(), 0};
        const std::size_t left = check(ZSTD_compressStream2(context_.get(), &out, &in, directive));
        write_or_throw(to, out_.data(), out.pos);
        is_done = directive == ZSTD_e_end ? left == 0 : in.pos == in.size;
      }
    }
    return to.position() - start;
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 20;

  static std::size_t check(std::size_t result) {
    if (ZSTD_isError(result) != 0)
      throw Error(ErrorCode::kEnvironment,
                  std::string("Zstandard cannot compress a texture: ") + ZSTD_getErrorName(result));
    return result;
  }

  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context_;
  std::vector<std::uint8_t> in_, out_;
};

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

// Collects levels in a scratch file, because the file stores the smallest level first, and compressed sizes are known
// only at the end.
class ZstdKtx2File : public TextureFile {
 public:
  ZstdKtx2File(const std::string& path, const LeveledTexture& texture, const Ktx2Choice& choice)
      : file_(path), scratch_(folder_of(path)), texture_(texture), choice_(choice), counts_(texture) {
    begins_.push_back(0);
    for (int level = 0; level < texture.level_count; ++level)
      begins_.push_back(begins_.back() + level_bytes(texture, level));
  }

  void write_rows(int level, int row_count, const void* blocks) override {
    const std::uint64_t row_bytes = block_row_bytes(texture_, level);
    const int first = counts_.add(level, row_count);
    scratch_.write(begins_[size_of(level)] + row_bytes * size_of(first), blocks,
                   static_cast<std::size_t>(row_bytes) * size_of(row_count));
  }
  void finish() override {
    counts_.check_complete();
    OutputFile bytes(file_);
    Ktx2Settings settings{software_version(), choice_.swizzle, {}, choice_.keys};
    settings.zstd_lengths.assign(size_of(texture_.level_count), 1);
    if (!bytes.seek(ktx2_head(texture_, settings).bytes.size())) bytes.close();  // throws
    ZstdFrames frames(choice_.zstd_level);
    for (int level = texture_.level_count - 1; level >= 0; --level)
      settings.zstd_lengths[size_of(level)] =
          frames.write(scratch_, begins_[size_of(level)], level_bytes(texture_, level), bytes);
    const TextureHead head = ktx2_head(texture_, settings);
    if (!bytes.seek(0)) bytes.close();
    write_or_throw(bytes, head.bytes.data(), head.bytes.size());
    bytes.close();
    file_.commit();
  }

 private:
  AtomicFile file_;
  ScratchFile scratch_;
  const LeveledTexture texture_;
  const Ktx2Choice choice_;
  RowCounts counts_;
  std::vector<std::uint64_t> begins_;  // start of each level in the scratch file
};

}  // namespace

std::unique_ptr<TextureFile> make_ktx2_file(const std::string& path, const LeveledTexture& texture,
                                            const Ktx2Choice& choice) {
  MULTUM_CHECK(choice.zstd_level >= 0 && choice.zstd_level <= kZstdLevelMax);
  if (choice.zstd_level > 0) return std::make_unique<ZstdKtx2File>(path, texture, choice);
  return std::make_unique<PlainTextureFile>(path, texture,
                                            ktx2_head(texture, {software_version(), choice.swizzle, {}, choice.keys}));
}

std::unique_ptr<TextureFile> make_dds_file(const std::string& path, const LeveledTexture& texture) {
  return std::make_unique<PlainTextureFile>(path, texture, dds_head(texture));
}

}  // namespace multum
