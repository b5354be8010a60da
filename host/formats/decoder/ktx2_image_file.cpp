// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/ktx2_image_file.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "host/formats/decoder/uastc_block.h"
#include "host/formats/image/files/ktx2_survey.h"
#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/byte_file.h"

namespace multum {
namespace {

class Ktx2ImageFile : public LibraryImageFile {
 public:
  Ktx2ImageFile(const std::string& path, const ImageContainer& container) : path_(path) {
    ByteFile file(path_);
    survey_ = survey_ktx2(path_, file);
    read_level(file);
    ImagePart part;
    part.width = part.full_width = static_cast<int>(survey_.width);
    part.height = part.full_height = static_cast<int>(survey_.height);
    part.base_type = survey_.base_type;
    const char* const kNames[] = {"R", "G", "B", "A"};
    part.channel_names.assign(kNames, kNames + survey_.channel_count);
    part.alpha_channel = survey_.channel_count == 4 ? 3 : -1;
    if (survey_.is_srgb) part.colour_space = "sRGB";
    description_ = {container.format, container.file_size, {part}, container.notes, 0.0};
  }

  std::string read_into(const PixelBlock& block, std::byte* memory) override {
    if (block.base_type != survey_.base_type) return "cannot convert its texels to this number type";
    const std::size_t value_bytes = survey_.base_type == number_type::kHalf ? 2 : 1;
    const auto channels = static_cast<std::size_t>(survey_.channel_count);
    const std::size_t texel_bytes = channels * value_bytes;
    const auto wanted = static_cast<std::size_t>(block.channel_end - block.channel_begin) * value_bytes;
    const std::size_t first = static_cast<std::size_t>(block.channel_begin) * value_bytes;
    const auto width = static_cast<std::size_t>(survey_.width);
    for (int y = block.y_begin; y < block.y_end; ++y) {
      const std::uint8_t* from = row_of(y);
      for (std::size_t x = 0; x < width; ++x, memory += wanted)
        std::memcpy(memory, from + x * texel_bytes + first, wanted);
    }
    return "";
  }

 private:
  void read_level(const ByteFile& file) {
    std::vector<std::uint8_t> stored(static_cast<std::size_t>(survey_.stored_bytes));
    file.read(survey_.begin, survey_.stored_bytes, stored.data(), "level 0 of a KTX2 texture");
    if (!survey_.is_zstd) {
      level_ = std::move(stored);
      return;
    }
    const auto size = static_cast<std::size_t>(survey_.bytes);
    const unsigned long long stated = ZSTD_getFrameContentSize(stored.data(), stored.size());
    if (stated != ZSTD_CONTENTSIZE_UNKNOWN && stated != size)
      refuse_file(path_, fmt::format("damaged KTX2: level 0 unpacks to {} bytes, expected {}", stated, size));
    level_.resize(size);
    const std::size_t found = ZSTD_decompress(level_.data(), size, stored.data(), stored.size());
    if (found != size)
      refuse_file(path_, fmt::format("damaged KTX2: level 0 is not a Zstandard frame of {} bytes: {}", size,
                                     ZSTD_isError(found) != 0 ? ZSTD_getErrorName(found) : "it has fewer"));
  }

  // Decodes a row of blocks when its first row of texels is needed, and keeps it until another row of blocks is needed.
  const std::uint8_t* row_of(int y) {
    const auto width = static_cast<std::size_t>(survey_.width);
    if (!survey_.is_uastc)
      return level_.data() + static_cast<std::size_t>(y) * (level_.size() / static_cast<std::size_t>(survey_.height));
    const int block_row = y / kUastcBlockSide;
    if (block_row != decoded_row_) decode_block_row(block_row);
    return decoded_.data() + static_cast<std::size_t>(y % kUastcBlockSide) * 4 * width;
  }

  void decode_block_row(int block_row) {
    const auto width = static_cast<std::size_t>(survey_.width);
    const std::size_t columns = (width + 3) / 4;
    decoded_.resize(kUastcBlockSide * 4 * width);
    std::uint8_t texels[kUastcBlockSide * kUastcBlockSide * 4];
    const std::uint8_t* from = level_.data() + static_cast<std::size_t>(block_row) * columns * kUastcBlockBytes;
    for (std::size_t column = 0; column < columns; ++column, from += kUastcBlockBytes) {
      if (!decode_uastc_block(from, texels))
        refuse_file(path_,
                    fmt::format("damaged KTX2: block ({}, {}) of level 0 is not a UASTC block", column, block_row));
      const std::size_t x = 4 * column, count = std::min<std::size_t>(4, width - x);
      for (std::size_t row = 0; row < kUastcBlockSide; ++row)
        std::memcpy(&decoded_[(row * width + x) * 4], texels + 16 * row, 4 * count);
    }
    decoded_row_ = block_row;
  }

  std::string path_;
  Ktx2Survey survey_;
  std::vector<std::uint8_t> level_;    // decompressed: texels or blocks
  std::vector<std::uint8_t> decoded_;  // decoded row of blocks, as rows of RGBA
  int decoded_row_ = -1;
};

}  // namespace

std::unique_ptr<LibraryImageFile> open_ktx2_image(const std::string& path, const ImageContainer& container) {
  return std::make_unique<Ktx2ImageFile>(path, container);
}

}  // namespace multum
