// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/solver/texture_start.h"

#include <algorithm>

namespace multum {
namespace {

// Texels with at least this much weight, in pixels, are not blended with the coarser level.
constexpr float kFull = 0.25f;

}  // namespace

std::vector<float> start_texels(const MipLayout& layout, const std::vector<std::array<float, 4>>& sums,
                                const std::vector<float>& weights) {
  const auto count = static_cast<std::size_t>(layout.texel_count);
  // In the pull phase, each coarse texel also gets the sums of its fine texels.
  std::vector<std::array<float, 4>> pulled(count);
  for (std::size_t t = 0; t < count; ++t) pulled[t] = {sums[t][0], sums[t][1], sums[t][2], weights[t]};
  for (std::size_t l = 0; l + 1 < layout.levels.size(); ++l)
    layout.for_each_child(l, [&](std::size_t parent, std::size_t texel) {
      for (std::size_t c = 0; c < 4; ++c) pulled[parent][c] += pulled[texel][c];
    });
  // The push phase runs from the coarsest level, which is a single texel, down to the finest.
  std::vector<float> texels(3 * count, 0.0f);
  const auto own = [&](std::size_t texel, std::size_t c) {
    return pulled[texel][3] > 0.0f ? pulled[texel][c] / pulled[texel][3] : 0.0f;
  };
  for (std::size_t c = 0; c < 3; ++c) texels[3 * (count - 1) + c] = own(count - 1, c);
  for (std::size_t l = layout.levels.size() - 1; l-- > 0;)
    layout.for_each_child(l, [&](std::size_t parent, std::size_t texel) {
      const float share = std::min(1.0f, pulled[texel][3] / kFull);
      for (std::size_t c = 0; c < 3; ++c)
        texels[3 * texel + c] = share * own(texel, c) + (1.0f - share) * texels[3 * parent + c];
    });
  return texels;
}

}  // namespace multum
