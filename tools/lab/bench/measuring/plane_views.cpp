// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/plane_views.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/split_mix.h"

namespace multum::bench {
namespace {

// Distance of the horizon above the picture, in picture heights. Visible points are 0.87 to 6.7 camera heights away.
constexpr double kHorizon = 0.15;
constexpr double kScaleS = 1.6, kScaleT = 0.4;  // number of repetitions of the texture that gives one texel per pixel
                                                // in the foreground
// Interpolation between texels and between levels uses weights of at least this value. Every visible texel then has
// enough weight to be determined in single precision without regularisers, so no texel reaches a bound.
constexpr double kFractionMin = 1.0 / 8;
constexpr double kTurn = 2.3999632;  // angle between cameras in radians, chosen so that all views differ

using Entry = std::pair<std::uint32_t, double>;

void add_bilinear(const MipLevelPlace& level, double s, double t, double share, std::vector<Entry>& entries) {
  const double x = s * level.width - 0.5, y = t * level.height - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const double fx = std::clamp(x - x0, kFractionMin, 1.0 - kFractionMin);
  const double fy = std::clamp(y - y0, kFractionMin, 1.0 - kFractionMin);
  const auto repeated = [](int i, int count) { return ((i % count) + count) % count; };
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double weight = share * (i == 0 ? 1.0 - fx : fx) * (j == 0 ? 1.0 - fy : fy);
      const int texel = level.offset + repeated(y0 + j, level.height) * level.width + repeated(x0 + i, level.width);
      entries.emplace_back(static_cast<std::uint32_t>(texel), weight);
    }
}

// Adds one sub-pixel at (x, y) of the picture, where x and y are from 0 to 1. Computes the sub-pixel's point on the
// plane, and computes its level from the longer side of its footprint.
void add_sample(const PlaneView& view, const MipLayout& layout, double x, double y, int width, int height,
                std::vector<Entry>& entries) {
  const double distance = 1.0 / (kHorizon + y), angle = kTurn * view.camera;
  const double across = kScaleS * (x - 0.5) * distance, ahead = kScaleT * distance;
  const double s = std::cos(angle) * across - std::sin(angle) * ahead + 0.37 + 0.11 * view.camera;
  const double t = std::sin(angle) * across + std::cos(angle) * ahead + 0.23 * view.camera;
  const double footprint =
      view.texture_side * std::max(kScaleS * distance / width, kScaleT * distance * distance / height);
  const double level = std::clamp(std::log2(footprint), 0.0, layout.level_count() - 1.001);
  const auto fine = static_cast<std::size_t>(level);
  const double fraction = level == 0.0 ? 0.0 : std::clamp(level - std::floor(level), kFractionMin, 1.0 - kFractionMin);
  add_bilinear(layout.levels[fine], s, t, 1.0 - fraction, entries);
  if (fraction > 0.0) add_bilinear(layout.levels[fine + 1], s, t, fraction, entries);
}

// Sorts entries by column, and adds the entries of the same texel.
void merge(std::vector<Entry>& entries) {
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.first < b.first; });
  std::size_t kept = 0;
  for (std::size_t i = 1; i < entries.size(); ++i)
    if (entries[i].first == entries[kept].first) entries[kept].second += entries[i].second;
    else entries[++kept] = entries[i];
  entries.resize(kept + 1);
}

}  // namespace

FilterMatrix plane_filter_matrix(const PlaneView& view, int threads) {
  FilterMatrix matrix;
  matrix.width = view.texture_side * 5 / 4;
  matrix.height = view.texture_side * 15 / 16;
  matrix.supersampling = view.sub_pixels;
  matrix.texture_width = matrix.texture_height = view.texture_side;
  matrix.wrap_s = matrix.wrap_t = WrapMode::kPeriodic;
  const MipLayout layout = matrix.layout();
  const int width = matrix.width * view.sub_pixels, height = matrix.height * view.sub_pixels;
  std::vector<std::vector<std::vector<Entry>>> lines(static_cast<std::size_t>(matrix.height));
  for_each_item(matrix.height, threads, [&](int y) {
    auto& line = lines[static_cast<std::size_t>(y)];
    line.resize(static_cast<std::size_t>(matrix.width));
    for (int x = 0; x < matrix.width; ++x) {
      auto& entries = line[static_cast<std::size_t>(x)];
      for (int j = 0; j < view.sub_pixels; ++j)
        for (int i = 0; i < view.sub_pixels; ++i)
          add_sample(view, layout, (x * view.sub_pixels + i + 0.5) / width, (y * view.sub_pixels + j + 0.5) / height,
                     width, height, entries);
      merge(entries);
    }
  });
  matrix.row_begin = {0};
  const double share = 1.0 / (view.sub_pixels * view.sub_pixels);
  for (const auto& line : lines)
    for (const auto& entries : line) {
      matrix.pixels.push_back(static_cast<std::uint32_t>(matrix.pixels.size()));
      matrix.coverage.push_back(1.0f);
      for (const auto& [texel, weight] : entries) {
        matrix.columns.push_back(texel);
        matrix.weights.push_back(static_cast<float>(share * weight));
      }
      matrix.row_begin.push_back(static_cast<std::uint32_t>(matrix.columns.size()));
    }
  return matrix;
}

std::vector<float> plane_texels(const MipLayout& layout, double contrast) {
  std::vector<float> texels;
  SplitMix64 random(3);
  const MipLevelPlace& finest = layout.levels.front();
  for (int i = 0; i < 3 * finest.width * finest.height; ++i)
    texels.push_back(static_cast<float>(0.5 + contrast * (2.0 * random.uniform() - 1.0)));
  for (std::size_t l = 1; l < layout.levels.size(); ++l) {
    const MipLevelPlace &fine = layout.levels[l - 1], &coarse = layout.levels[l];
    for (int y = 0; y < coarse.height; ++y)
      for (int x = 0; x < coarse.width; ++x)
        for (int c = 0; c < 3; ++c) {
          const auto at = static_cast<std::size_t>(3 * (fine.offset + 2 * y * fine.width + 2 * x) + c);
          const auto below = at + 3 * static_cast<std::size_t>(fine.width);
          texels.push_back(0.25f * (texels[at] + texels[at + 3] + texels[below] + texels[below + 3]));
        }
  }
  return texels;
}

}  // namespace multum::bench
