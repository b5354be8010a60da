// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/movmf_mipmap.h"

#include "host/foundation/base/error.h"

namespace multum {

MovmfLevel rows_of(const MovmfLevel& level, int first_row, int row_count) {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && first_row + row_count <= level.height);
  const std::size_t width = static_cast<std::size_t>(level.width);
  const std::size_t first = static_cast<std::size_t>(first_row) * width;
  const std::size_t end = first + static_cast<std::size_t>(row_count) * width;
  const std::size_t all = static_cast<std::size_t>(level.height) * width;
  MovmfLevel rows{level.width, row_count, {}, {}};
  for (const auto& lobe : level.lobes) rows.lobes.push_back(texels_of(lobe, all, first, end));
  for (const auto& colour : level.colours) rows.colours.push_back(texels_of(colour, all, first, end));
  for (const auto& weights : level.weights) rows.weights.push_back(texels_of(weights, all, first, end));
  return rows;
}

BakedHeader full_header(const MovmfMipmap& mipmap) {
  BakedHeader header = mipmap.header;
  header.width = mipmap.width();
  header.height = mipmap.height();
  header.has_colours = mipmap.has_colours();
  return header;
}

MovmfMipmap empty_movmf_mipmap(const BakedHeader& header, int lobe_count) {
  MovmfMipmap mipmap{header};
  for (int l = 0; l < header.level_count(); ++l) {
    MovmfLevel& level = mipmap.levels.emplace_back();
    level.width = mip_level_size(header.width, l);
    level.height = mip_level_size(header.height, l);
    level.lobes.resize(static_cast<std::size_t>(lobe_count));
    if (header.has_colours) level.colours.resize(level.lobes.size());
    if (header.weight_count > 0) level.weights.resize(level.lobes.size());
  }
  return mipmap;
}

void drop_finer_levels(MovmfMipmap& mipmap, int first_level) {
  MULTUM_CHECK(first_level >= mipmap.header.first_level && first_level < static_cast<int>(mipmap.levels.size()));
  for (int l = 0; l < first_level; ++l) {
    MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    for (auto& lobe : level.lobes) lobe = std::vector<glm::vec4>();  // `= {}` would keep the memory
    for (auto& colour : level.colours) colour = std::vector<glm::vec3>();
    for (auto& weights : level.weights) weights = std::vector<float>();
  }
  mipmap.header.first_level = first_level;
}

}  // namespace multum
