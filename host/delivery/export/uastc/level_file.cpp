// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/uastc/level_file.h"

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr std::uint64_t kTexelBytes = 4;

}  // namespace

LevelFile::LevelFile(const std::string& folder, const std::string& name, int width, int height)
    : path_(folder + "/" + name), width_(width), height_(height), offsets_{0}, file_(folder, name) {
  for (int level = 0; level < mip_level_count(width, height); ++level)
    offsets_.push_back(offsets_.back() +
                       kTexelBytes * size_of(mip_level_size(width, level)) * size_of(mip_level_size(height, level)));
}

std::uint64_t LevelFile::row_offset(int level, int row) const {
  return offset(level) + kTexelBytes * size_of(mip_level_size(width_, level)) * size_of(row);
}

void LevelFile::write_rows(int level, int first_row, const std::vector<std::uint8_t>& texels) {
  file_.write(row_offset(level, first_row), texels.data(), texels.size());
}

std::vector<std::uint8_t> LevelFile::read_rows(int level, int first_row, int row_count) const {
  std::vector<std::uint8_t> texels(kTexelBytes * size_of(mip_level_size(width_, level)) * size_of(row_count));
  file_.read(row_offset(level, first_row), texels.data(), texels.size());
  return texels;
}

std::array<std::uint8_t, 4> LevelFile::read_texel(int level, int x, int y) const {
  std::array<std::uint8_t, 4> texel;
  file_.read(row_offset(level, y) + kTexelBytes * size_of(x), texel.data(), texel.size());
  return texel;
}

}  // namespace multum
