// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/sh_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/formats/asset/averages/sh_parts.h"
#include "host/formats/asset/baked_reader.h"
#include "host/formats/asset/exr/exr_rows.h"

namespace multum {

class ShReader::File {
 public:
  File(const std::string& path, int threads, TexelCheck check) : reader_(path, threads, check) {
    reader_.guarded([&] {
      const Imf::Header& first = reader_.file().header(0);
      header_ = parse_baked_header(first, Representation::kSh, path);
      order_ = int_attribute(first, kShOrderAttribute, path);
      if (order_ < kShOrderMin || order_ > kShOrderMax)
        refuse_file(path, fmt::format("an order of {}", order_), fmt::format("{} to {}", kShOrderMin, kShOrderMax));
      reader_.expect(header_, sh_parts(header_, order_));
    });
    hash_ = std::make_unique<BakedRowHash>(sh_parts(header_, order_));
  }

  const BakedHeader& header() const { return header_; }
  int order() const { return order_; }
  int tile_size() const { return reader_.tile_size(); }
  BakedRowHash& hash() { return *hash_; }
  const std::vector<std::string>& changed_rows() const { return reader_.changed_rows(); }

  ShLevel read_level(int level, int first_row, int row_count) {
    ShLevel rows{mip_level_size(header_.width, level), row_count, {}, {}, {}};
    const std::size_t texels = texel_count(rows.width, row_count);
    rows.parts.assign(static_cast<std::size_t>(sh_part_count(order_)), std::vector<glm::vec4>(texels));
    if (header_.has_colours) rows.colours.resize(texels);
    rows.weights.resize(texels * static_cast<std::size_t>(header_.weight_count));
    if (texels == 0) return rows;
    for (std::size_t part = 0; part < rows.parts.size(); ++part) {
      const int channels = std::min(4, sh_coefficient_count(order_) - 4 * static_cast<int>(part));
      std::vector<glm::vec4>& values = rows.parts[part];
      float* const first = &values[0].x;
      read_part(part, level, first_row, row_count, first, static_cast<std::size_t>(channels) * texels);
      if (channels == 4) continue;
      // Moves the values to their final places, beginning with the last texel. The final place of each texel is at or
      // after the present place of its values.
      for (std::size_t i = texels; i-- > 0;) {
        glm::vec4 texel(0.0f);
        std::copy_n(first + i * static_cast<std::size_t>(channels), channels, &texel.x);
        values[i] = texel;
      }
    }
    std::size_t part = rows.parts.size();
    if (header_.has_colours) read_part(part++, level, first_row, row_count, &rows.colours[0].x, 3 * texels);
    if (header_.weight_count > 0)
      read_part(part, level, first_row, row_count, rows.weights.data(), rows.weights.size());
    return rows;
  }

 private:
  void read_part(std::size_t part, int level, int first_row, int row_count, float* values, std::size_t value_count) {
    reader_.read_values(part, level, first_row, row_count, values);
    hash_->add(part, level, values, value_count);
  }

  BakedReader reader_;
  BakedHeader header_;
  int order_ = 0;
  std::unique_ptr<BakedRowHash> hash_;
};

ShReader::ShReader(const std::string& path, int threads, TexelCheck check)
    : file_(std::make_unique<File>(path, threads, check)) {}
ShReader::~ShReader() = default;
const BakedHeader& ShReader::header() const { return file_->header(); }
int ShReader::order() const { return file_->order(); }
int ShReader::tile_size() const { return file_->tile_size(); }
ShLevel ShReader::read_level(int level, int first_row, int row_count) {
  return file_->read_level(level, first_row, row_count);
}
const std::vector<std::string>& ShReader::changed_rows() const { return file_->changed_rows(); }
std::string ShReader::finish_hash() { return file_->hash().finish(); }

ShMipmap read_sh_mipmap(const std::string& path, int threads) {
  ShReader reader(path, threads);
  const BakedHeader& header = reader.header();
  ShMipmap mipmap{header, reader.order(), empty_sh_levels(header.width, header.height)};
  for (int l = header.first_level; l < header.level_count(); ++l) {
    ShLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    level = reader.read_level(l, 0, level.height);
  }
  return mipmap;
}

ShMipmap read_sh_header(const std::string& path) {
  const ShReader reader(path, 1);
  return {reader.header(), reader.order(), empty_sh_levels(reader.header().width, reader.header().height)};
}

}  // namespace multum
