// SPDX-License-Identifier: Apache-2.0
#include "host/bake/texture_start.h"

#include <algorithm>

namespace multum {
namespace {

constexpr float kFull = 0.25f;  // of a pixel: a texel that is looked at this much is not blended with the coarser level

}  // namespace

std::vector<float> start_texels(const MipLayout& layout, const std::vector<std::array<float, 4>>& sums,
                                const std::vector<float>& weights) {
  const auto count = static_cast<std::size_t>(layout.texel_count);
  // Pull: a coarse texel also counts what its fine ones have.
  std::vector<std::array<float, 4>> pulled(count);
  for (std::size_t t = 0; t < count; ++t) pulled[t] = {sums[t][0], sums[t][1], sums[t][2], weights[t]};
  for (std::size_t l = 0; l + 1 < layout.levels.size(); ++l) {
    const MipLevelPlace &fine = layout.levels[l], &coarse = layout.levels[l + 1];
    for (int y = 0; y < fine.height; ++y)
      for (int x = 0; x < fine.width; ++x) {
        const int cx = std::min(x / 2, coarse.width - 1), cy = std::min(y / 2, coarse.height - 1);
        auto& to = pulled[static_cast<std::size_t>(coarse.offset + cy * coarse.width + cx)];
        const auto& from = pulled[static_cast<std::size_t>(fine.offset + y * fine.width + x)];
        for (std::size_t c = 0; c < 4; ++c) to[c] += from[c];
      }
  }
  // Push, from the coarsest level down.
  std::vector<float> texels(3 * count, 0.0f);
  for (std::size_t l = layout.levels.size(); l-- > 0;) {
    const MipLevelPlace& level = layout.levels[l];
    const MipLevelPlace* coarse = l + 1 < layout.levels.size() ? &layout.levels[l + 1] : nullptr;
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x) {
        const auto t = static_cast<std::size_t>(level.offset + y * level.width + x);
        const auto& p = pulled[t];
        const float share = coarse == nullptr ? 1.0f : std::min(1.0f, p[3] / kFull);
        const std::size_t parent =
            coarse == nullptr
                ? t
                : static_cast<std::size_t>(coarse->offset + std::min(y / 2, coarse->height - 1) * coarse->width +
                                           std::min(x / 2, coarse->width - 1));
        for (std::size_t c = 0; c < 3; ++c) {
          const float own = p[3] > 0.0f ? p[c] / p[3] : 0.0f;
          texels[3 * t + c] = share * own + (coarse == nullptr ? 0.0f : (1.0f - share) * texels[3 * parent + c]);
        }
      }
  }
  return texels;
}

}  // namespace multum
