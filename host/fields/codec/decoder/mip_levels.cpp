// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/mip_levels.h"

#include <algorithm>
#include <array>

namespace multum {
namespace {

/// The fine texels that a coarse texel covers along an axis. There are at most three.
struct Cover {
  std::size_t first = 0, count = 1;
  std::array<float, 3> weights{1.0f, 0.0f, 0.0f};
};

Cover cover_of(std::size_t fine, std::size_t coarse_index) {
  if (fine == 1) return {};
  if (fine % 2 == 0) return {2 * coarse_index, 2, {0.5f, 0.5f, 0.0f}};
  const auto n = static_cast<float>(fine), m = static_cast<float>(fine / 2), i = static_cast<float>(coarse_index);
  return {2 * coarse_index, 3, {(m - i) / n, m / n, (i + 1.0f) / n}};
}

struct Level {
  std::size_t width, height, offset;
};

std::vector<Level> levels_of(std::size_t width, std::size_t height) {
  std::vector<Level> levels = {{width, height, 0}};
  while (levels.back().width > 1 || levels.back().height > 1) {
    const Level& last = levels.back();
    levels.push_back({std::max<std::size_t>(1, last.width / 2), std::max<std::size_t>(1, last.height / 2),
                      last.offset + last.width * last.height});
  }
  return levels;
}

/// Calls visit(coarse texel, fine texel, weight) for every pair of overlapping texels of two levels.
template <class Visit>
void over_covers(const Level& fine, const Level& coarse, Visit visit) {
  std::vector<Cover> all_columns;
  for (std::size_t x = 0; x < coarse.width; ++x) all_columns.push_back(cover_of(fine.width, x));
  for (std::size_t y = 0; y < coarse.height; ++y) {
    const Cover rows = cover_of(fine.height, y);
    for (std::size_t x = 0; x < coarse.width; ++x) {
      const Cover& columns = all_columns[x];
      for (std::size_t j = 0; j < rows.count; ++j)
        for (std::size_t i = 0; i < columns.count; ++i)
          visit(coarse.offset + y * coarse.width + x, fine.offset + (rows.first + j) * fine.width + columns.first + i,
                rows.weights[j] * columns.weights[i]);
    }
  }
}

/// Computes a level of half the size. Each texel is the mean of four texels. The result equals that of over_covers()
/// bit by bit.
void halve(const Level& fine, const Level& coarse, std::span<float> texels) {
  for (std::size_t y = 0; y < coarse.height; ++y) {
    const float* above = texels.data() + 3 * (fine.offset + 2 * y * fine.width);
    const float* below = above + 3 * fine.width;
    float* mean = texels.data() + 3 * (coarse.offset + y * coarse.width);
    for (std::size_t x = 0; x < coarse.width; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        mean[3 * x + c] = 0.25f * above[6 * x + c] + 0.25f * above[6 * x + 3 + c] + 0.25f * below[6 * x + c] +
                          0.25f * below[6 * x + 3 + c];
  }
}

}  // namespace

std::size_t mip_texel_count(std::size_t width, std::size_t height) {
  const Level last = levels_of(width, height).back();
  return last.offset + 1;
}

std::vector<float> mip_levels(std::size_t width, std::size_t height, std::span<const float> finest) {
  std::vector<float> texels(3 * mip_texel_count(width, height));
  std::copy(finest.begin(), finest.end(), texels.begin());
  const auto levels = levels_of(width, height);
  for (std::size_t l = 0; l + 1 < levels.size(); ++l)
    if (levels[l].width % 2 == 0 && levels[l].height % 2 == 0) halve(levels[l], levels[l + 1], texels);
    else
      over_covers(levels[l], levels[l + 1], [&](std::size_t coarse, std::size_t fine, float weight) {
        for (std::size_t c = 0; c < 3; ++c) texels[3 * coarse + c] += weight * texels[3 * fine + c];
      });
  return texels;
}

std::vector<float> handed_down(std::size_t width, std::size_t height, std::size_t channels, std::vector<float> levels) {
  const auto places = levels_of(width, height);
  for (std::size_t l = places.size(); l-- > 1;)
    over_covers(places[l - 1], places[l], [&](std::size_t coarse, std::size_t fine, float weight) {
      for (std::size_t c = 0; c < channels; ++c) levels[channels * fine + c] += weight * levels[channels * coarse + c];
    });
  levels.resize(channels * width * height);
  return levels;
}

}  // namespace multum
