// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/mapping/forward_mapping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "host/fields/inference/solver/pyramid_tables.h"
#include "host/formats/asset/mip_layout.h"

namespace multum {
namespace {

using TexelSum = std::array<double, 4>;  // three colours and the weight

// Returns the map of texture coordinates across a triangle, with perspective. The map is [s q, t q, q] = map * (x, y,
// 1), where x and y are clip coordinates divided by w.
std::optional<glm::dmat3> texture_map(const ObjectMesh& mesh, const std::vector<glm::vec2>& corners,
                                      const glm::dmat4& object_to_clip, std::size_t triangle) {
  glm::dmat3 clip, texture;
  for (glm::length_t k = 0; k < 3; ++k) {
    const std::size_t corner = 3 * triangle + static_cast<std::size_t>(k);
    const glm::dvec4 p = object_to_clip * glm::dvec4(glm::dvec3(mesh.positions[mesh.indices[corner]]), 1.0);
    clip[k] = {p.x, p.y, p.w};
    texture[k] = {static_cast<double>(corners[corner].x), static_cast<double>(corners[corner].y), 1.0};
  }
  if (!(std::abs(glm::determinant(clip)) > 1e-300)) return std::nullopt;
  return texture * glm::inverse(clip);
}

int place(int i, int count, WrapMode wrap) {
  return wrap == WrapMode::kPeriodic ? ((i % count) + count) % count : std::clamp(i, 0, count - 1);
}

class Splatter {
 public:
  Splatter(const ObjectMesh& mesh, const TextureMapping& mapping)
      : mesh_(mesh),
        mapping_(mapping),
        corners_(mapped_corners(mesh.uvs, mesh.indices, mapping)),
        layout_(mapping.width, mapping.height),
        sums_(static_cast<std::size_t>(layout_.texel_count), TexelSum{}) {}

  void add(const ForwardView& view) {
    const ItemBuffer& items = *view.items;
    std::vector<std::optional<glm::dmat3>> maps(mesh_.indices.size() / 3);
    std::vector<bool> is_known(maps.size(), false);
    for (int y = 0, i = 0; y < items.height; ++y)
      for (int x = 0; x < items.width; ++x, ++i) {
        const auto pixel = static_cast<std::size_t>(i);
        if (items.object[pixel] != view.object || !(view.layer->coverage[pixel] > 0.0f)) continue;
        const auto triangle = static_cast<std::size_t>(items.triangle[pixel]);
        if (!is_known[triangle]) {
          maps[triangle] = texture_map(mesh_, corners_, view.object_to_clip, triangle);
          is_known[triangle] = true;
        }
        if (!maps[triangle]) continue;
        const glm::dvec3 at = *maps[triangle] * glm::dvec3(2.0 * (x + 0.5) / items.width - 1.0,
                                                           1.0 - 2.0 * (y + 0.5) / items.height, 1.0);
        splat(at.x / at.z, 1.0 - at.y / at.z, &view.layer->rgb[3 * pixel],
              static_cast<double>(view.layer->coverage[pixel]));
      }
  }

  std::vector<float> texels() {
    fill_holes();
    std::vector<float> texels(3 * sums_.size());
    for (std::size_t t = 0; t < sums_.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) texels[3 * t + c] = static_cast<float>(sums_[t][c]);
    return texels;
  }

 private:
  void splat(double s, double t, const float* colour, double weight) {
    const MipLevelPlace& level = layout_.levels[0];
    const double x = s * level.width - 0.5, y = t * level.height - 0.5;
    if (!std::isfinite(x) || !std::isfinite(y)) return;
    const double x0 = std::floor(x), y0 = std::floor(y);
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx) {
        const double share = weight * (dx == 0 ? 1.0 - (x - x0) : x - x0) * (dy == 0 ? 1.0 - (y - y0) : y - y0);
        const int tx = place(static_cast<int>(x0) + dx, level.width, mapping_.wrap_s);
        const int ty = place(static_cast<int>(y0) + dy, level.height, mapping_.wrap_t);
        TexelSum& sum = sums_[static_cast<std::size_t>(ty * level.width + tx)];
        for (std::size_t c = 0; c < 3; ++c) sum[c] += share * static_cast<double>(colour[c]);
        sum[3] += share;
      }
  }

  // In the pull phase, coarse texels sum the known texels. In the push phase, unknown texels are interpolated from the
  // coarser level. Then the coarse levels are computed again as box averages of the filled finest level.
  void fill_holes() {
    for (std::size_t l = 0; l + 1 < layout_.levels.size(); ++l)
      layout_.for_each_child(l, [&](std::size_t parent, std::size_t texel) {
        for (std::size_t c = 0; c < 4; ++c) sums_[parent][c] += sums_[texel][c];
      });
    const PyramidTables tables =
        make_pyramid_tables(layout_, mapping_.wrap_s == WrapMode::kPeriodic, mapping_.wrap_t == WrapMode::kPeriodic, 1);
    for (std::size_t l = layout_.levels.size(); l-- > 0;) push(l, tables);
    for (std::size_t l = 0; l + 1 < layout_.levels.size(); ++l) {
      const MipLevelPlace& coarse = layout_.levels[l + 1];
      for (int t = coarse.offset; t < coarse.offset + coarse.width * coarse.height; ++t)
        sums_[static_cast<std::size_t>(t)] = TexelSum{};
      layout_.for_each_child(l, [&](std::size_t parent, std::size_t texel) {
        for (std::size_t c = 0; c < 3; ++c) sums_[parent][c] += sums_[texel][c];
        sums_[parent][3] += 1.0;
      });
      for (int t = coarse.offset; t < coarse.offset + coarse.width * coarse.height; ++t) {
        TexelSum& sum = sums_[static_cast<std::size_t>(t)];
        for (std::size_t c = 0; c < 3; ++c) sum[c] /= sum[3];
      }
    }
  }

  void push(std::size_t l, const PyramidTables& tables) {
    constexpr double kKnown = 1e-6;  // least weight of a known texel, in pixels
    const MipLevelPlace& level = layout_.levels[l];
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x) {
        TexelSum& sum = sums_[static_cast<std::size_t>(level.offset + y * level.width + x)];
        if (sum[3] > kKnown) {
          for (std::size_t c = 0; c < 3; ++c) sum[c] /= sum[3];
          continue;
        }
        sum = TexelSum{};
        if (l + 1 == layout_.levels.size()) continue;
        const MipLevelPlace& coarse = layout_.levels[l + 1];
        const MultumTap across = tables.taps[static_cast<std::size_t>(tables.levels[l].taps_x + x)];
        const MultumTap down = tables.taps[static_cast<std::size_t>(tables.levels[l].taps_y + y)];
        for (const auto& [ty, wy] : {std::pair(down.first, 1.0 - static_cast<double>(down.fraction)),
                                     std::pair(down.second, static_cast<double>(down.fraction))})
          for (const auto& [tx, wx] : {std::pair(across.first, 1.0 - static_cast<double>(across.fraction)),
                                       std::pair(across.second, static_cast<double>(across.fraction))})
            for (std::size_t c = 0; c < 3; ++c)
              sum[c] += wx * wy * sums_[static_cast<std::size_t>(coarse.offset + ty * coarse.width + tx)][c];
      }
  }

  const ObjectMesh& mesh_;
  const TextureMapping& mapping_;
  const std::vector<glm::vec2> corners_;
  const MipLayout layout_;
  std::vector<TexelSum> sums_;
};

}  // namespace

std::vector<float> forward_mapped(const ObjectMesh& mesh, const TextureMapping& mapping,
                                  const std::vector<ForwardView>& views) {
  Splatter splatter(mesh, mapping);
  for (const ForwardView& view : views) splatter.add(view);
  return splatter.texels();
}

}  // namespace multum
