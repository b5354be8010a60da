// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/movmf_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/formats/asset/baked_reader.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/asset/lobes/movmf_header.h"
#include "host/formats/asset/lobes/movmf_parts.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// The number of tile rows that each read covers when all rows are read.
constexpr int kTileRowsAtOnce = 4;

}  // namespace

class MovmfReader::File {
 public:
  File(const std::string& path, int threads, TexelCheck check) : reader_(path, threads, check) {
    reader_.guarded([&] {
      header_ = parse_header(reader_.file().header(0), path);
      family_ = &lobe_family(header_.header.representation);
      parts_ = movmf_parts(header_);
      reader_.expect(full_header(header_), {parts_.begin(), parts_.end()});
    });
  }

  const MovmfMipmap& header() const { return header_; }
  int tile_size() const { return reader_.tile_size(); }
  const std::vector<std::string>& changed_rows() const { return reader_.changed_rows(); }

  MovmfFinest read_finest(int first_row, int row_count) {
    MULTUM_CHECK(header_.header.first_level == 0);
    check_rows(0, first_row, row_count);
    MovmfFinest rows{
        header_.width(), row_count, {}, {}, {}, {}, header_.header.representation, header_.header.has_roughness};
    const std::size_t texels = texel_count(rows.width, row_count);
    const std::size_t channels = parts_[0].channels.size();
    values_.resize(texels * channels);
    reader_.read_values(0, 0, first_row, row_count, values_.data());
    rows.normals.resize(texels);
    rows.lobe.resize(texels);
    if (header_.has_colours()) rows.colours.resize(texels);
    rows.weights.resize(texels * weight_count());
    for_each_row_band(row_count, kRowsPerBand, reader_.threads(), [&](int, int row_begin, int row_end) {
      for (int y = row_begin; y < row_end; ++y)
        for (int x = 0; x < rows.width; ++x) decode_texel(x, first_row, y, rows);
    });
    return rows;
  }

  MovmfLevel read_level(int level, int first_row, int row_count) {
    MULTUM_CHECK(level >= header_.header.first_level);
    check_rows(level, first_row, row_count);
    MovmfLevel rows{header_.levels[static_cast<std::size_t>(level)].width, row_count, {}, {}};
    const std::size_t texels = texel_count(rows.width, row_count);
    rows.lobes.assign(static_cast<std::size_t>(header_.lobe_count()), std::vector<glm::vec4>(texels));
    if (header_.has_colours()) rows.colours.assign(rows.lobes.size(), std::vector<glm::vec3>(texels));
    if (weight_count() > 0) rows.weights.assign(rows.lobes.size(), std::vector<float>(texels * weight_count()));
    if (texels == 0) return rows;
    if (level == 0) {
      expand_into(read_finest(first_row, row_count), rows, 0, reader_.threads());
      return rows;
    }
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (parts_[i].kind != MovmfPartKind::kFinest)
        reader_.read_values(i, level, first_row, row_count, parts_[i].values(rows));
    return rows;
  }

 private:
  std::size_t weight_count() const { return static_cast<std::size_t>(header_.header.weight_count); }

  void check_rows(int level, int first_row, int row_count) const {
    MULTUM_CHECK(level >= 0 && level < static_cast<int>(header_.levels.size()));
    const int height = header_.levels[static_cast<std::size_t>(level)].height;
    MULTUM_CHECK(first_row >= 0 && row_count >= 0 && first_row + row_count <= height);
  }

  void decode_texel(int x, int first_row, int y, MovmfFinest& rows) const {
    // Rounded values exceed 1 by at most one step.
    constexpr float kComponentMax = 1.001f;
    const std::size_t i = texel_count(rows.width, y) + static_cast<std::size_t>(x);
    const float* v = values_.data() + i * parts_[0].channels.size();
    if (!rows.colours.empty()) {
      rows.colours[i] = {v[0], v[1], v[2]};
      v += 3;
    }
    const auto lobe_count = static_cast<float>(header_.lobe_count());
    if (!(v[0] >= 0.0f && v[0] < lobe_count && v[0] == std::floor(v[0])))
      refuse_texel(x, first_row + y, fmt::format("lobe {}", v[0]), fmt::format("0 to {}", lobe_count - 1.0f));
    if (!(std::abs(v[1]) <= kComponentMax && std::abs(v[2]) <= kComponentMax))
      refuse_texel(x, first_row + y, fmt::format("a normal ({}, {})", v[1], v[2]), "components of -1 to 1");
    rows.lobe[i] = static_cast<std::uint8_t>(v[0]);
    if (header_.header.has_roughness && !(v[3] >= 0.0f && v[3] <= kComponentMax))
      refuse_texel(x, first_row + y, fmt::format("{} {}", family_->finest_third_name, v[3]), "0 to 1");
    rows.normals[i] = {
        v[1], v[2], header_.header.has_roughness ? v[3] : family_->finest_third(v[1], v[2], header_.header.encoding)};
    v += header_.header.has_roughness ? 4 : 3;
    std::copy_n(v, weight_count(), rows.weights.begin() + static_cast<std::ptrdiff_t>(i * weight_count()));
  }

  [[noreturn]] void refuse_texel(int x, int y, const std::string& found, const std::string& expected) const {
    throw Error(ErrorCode::kInput, fmt::format("{}: level 0, texel ({}, {}): found {}, expected {}", reader_.path(), x,
                                               y, found, expected));
  }

  BakedReader reader_;
  MovmfMipmap header_;
  const LobeFamily* family_ = nullptr;
  std::vector<MovmfPart> parts_;
  std::vector<float> values_;  // values of level 0, in the file's order
};

MovmfReader::MovmfReader(const std::string& path, int threads, TexelCheck check)
    : file_(std::make_unique<File>(path, threads, check)) {}
MovmfReader::~MovmfReader() = default;
const MovmfMipmap& MovmfReader::header() const { return file_->header(); }
const std::vector<std::string>& MovmfReader::changed_rows() const { return file_->changed_rows(); }
int MovmfReader::tile_size() const { return file_->tile_size(); }
MovmfLevel MovmfReader::read_level(int level, int first_row, int row_count) {
  return file_->read_level(level, first_row, row_count);
}
MovmfFinest MovmfReader::read_finest(int first_row, int row_count) { return file_->read_finest(first_row, row_count); }

MovmfMipmap read_movmf_mipmap(const std::string& path, int threads) {
  MovmfReader reader(path, threads);
  MovmfMipmap mipmap = reader.header();
  for (std::size_t l = static_cast<std::size_t>(mipmap.header.first_level); l < mipmap.levels.size(); ++l) {
    MovmfLevel& level = mipmap.levels[l];
    if (l > 0) {
      level = reader.read_level(static_cast<int>(l), 0, level.height);
      continue;
    }
    const std::size_t texels = texel_count(level.width, level.height);
    for (auto& lobe : level.lobes) lobe.resize(texels);
    for (auto& colour : level.colours) colour.resize(texels);
    for (auto& weights : level.weights) weights.resize(texels * static_cast<std::size_t>(mipmap.header.weight_count));
    const int step = reader.tile_size() * kTileRowsAtOnce;
    for (int row = 0; row < level.height; row += step)
      expand_into(reader.read_finest(row, std::min(step, level.height - row)), level, row, threads);
  }
  return mipmap;
}

MovmfMipmap read_movmf_header(const std::string& path) { return MovmfReader(path, 1).header(); }

}  // namespace multum
