// SPDX-License-Identifier: Apache-2.0
#include "host/lab/field_cases/texture_inference.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/foundation/base/split_mix.h"

namespace multum::reference {
namespace {

struct Tap {
  int index;
  double weight;
};

// Returns the two texels on either side of a position along one axis, with their weights.
std::vector<Tap> taps(double at, int count, WrapMode wrap) {
  if (wrap == WrapMode::kClamp) at = std::clamp(at, 0.0, count - 1.0);
  const int first = static_cast<int>(std::floor(at));
  std::vector<Tap> result;
  for (int k = 0; k < 2; ++k) {
    int index = first + k;
    index = wrap == WrapMode::kPeriodic ? ((index % count) + count) % count : std::min(index, count - 1);
    result.push_back({index, k == 0 ? 1.0 - (at - first) : at - first});
  }
  return result;
}

double range_value(double x) {
  const double d = 1.0 / 512;
  return 1.0 / ((x + d) * (1.0 + d - x));
}

}  // namespace

std::vector<InterpolationEntry> interpolation(const FilterMatrix& matrix) {
  std::vector<InterpolationEntry> entries;
  const MipLayout layout = matrix.layout();
  for (std::size_t l = 0; l + 1 < layout.levels.size(); ++l) {
    const MipLevelPlace &fine = layout.levels[l], &coarse = layout.levels[l + 1];
    for (int y = 0; y < fine.height; ++y)
      for (int x = 0; x < fine.width; ++x)
        for (const Tap& ty : taps((y + 0.5) * coarse.height / fine.height - 0.5, coarse.height, matrix.wrap_t))
          for (const Tap& tx : taps((x + 0.5) * coarse.width / fine.width - 0.5, coarse.width, matrix.wrap_s))
            entries.push_back({fine.offset + y * fine.width + x, coarse.offset + ty.index * coarse.width + tx.index,
                               tx.weight * ty.weight});
  }
  return entries;
}

double objective(const InferenceProblem& problem, const std::vector<double>& texels) {
  double fit = 0.0, row_count = 0.0;
  std::size_t pixel = 0;
  for (std::size_t v = 0; v < problem.matrices.size(); ++v) {
    const FilterMatrix& m = *problem.matrices[v];
    for (std::size_t r = 0; r < m.row_count(); ++r, ++pixel) {
      const double weight = static_cast<double>(problem.row_weights[v][r]);
      if (weight == 0.0) continue;
      double value = 0.0;
      for (std::uint32_t i = m.row_begin[r]; i < m.row_begin[r + 1]; ++i)
        value += static_cast<double>(m.weights[i]) * texels[m.columns[i]];
      fit += weight * (value - problem.pixels[pixel]) * (value - problem.pixels[pixel]);
      row_count += 1.0;
    }
  }
  const FilterMatrix& first = *problem.matrices.front();
  const MipLayout layout = first.layout();
  std::vector<double> residual(texels);
  for (const InterpolationEntry& entry : interpolation(first))
    residual[static_cast<std::size_t>(entry.fine)] -= entry.weight * texels[static_cast<std::size_t>(entry.coarse)];
  double pyramid = 0.0, range = 0.0;
  for (int t = 0; t < layout.levels.back().offset; ++t)
    pyramid += residual[static_cast<std::size_t>(t)] * residual[static_cast<std::size_t>(t)];
  for (const double x : texels) range += range_value(x);
  const double ratio = row_count / static_cast<double>(layout.texel_count);
  return fit + problem.pyramid_weight * ratio * pyramid +
         problem.range_weight * ratio / (range_value(0.0) - range_value(0.5)) * range;
}

FilterMatrix random_matrix(int texture_width, int texture_height, WrapMode wrap, int rows, unsigned seed) {
  SplitMix64 random(seed);
  FilterMatrix m;
  m.width = rows;
  m.height = 1;
  m.texture_width = texture_width;
  m.texture_height = texture_height;
  m.wrap_s = m.wrap_t = wrap;
  m.row_begin = {0};
  const MipLayout layout = m.layout();
  for (int r = 0; r < rows; ++r) {
    const double s = random.uniform(), t = random.uniform();
    const double lod = random.uniform() * 0.999 * std::min(3, layout.level_count() - 1);
    std::map<std::uint32_t, double> row;
    for (int k = 0; k < 2; ++k) {
      const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(static_cast<int>(lod) + k)];
      const double share = k == 0 ? 1.0 - (lod - std::floor(lod)) : lod - std::floor(lod);
      for (const Tap& ty : taps(t * level.height - 0.5, level.height, wrap))
        for (const Tap& tx : taps(s * level.width - 0.5, level.width, wrap))
          row[static_cast<std::uint32_t>(level.offset + ty.index * level.width + tx.index)] +=
              share * tx.weight * ty.weight;
    }
    m.pixels.push_back(static_cast<std::uint32_t>(r));
    m.coverage.push_back(1.0f);
    for (const auto& [texel, weight] : row) {
      m.columns.push_back(texel);
      m.weights.push_back(static_cast<float>(weight));
    }
    m.row_begin.push_back(static_cast<std::uint32_t>(m.columns.size()));
  }
  return m;
}

}  // namespace multum::reference
