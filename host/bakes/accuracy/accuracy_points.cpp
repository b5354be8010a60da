// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/accuracy_points.h"

#include <algorithm>
#include <cmath>

#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

bool is_whole(PlaneSize size, std::int64_t wanted) {
  return wanted <= 0 || std::int64_t{size.width} * size.height <= kWholeLevelFactor * wanted;
}

// Returns the side of a cell such that the grid has about `wanted` cells, but at least two.
int cell_side(PlaneSize size, std::int64_t wanted) {
  if (is_whole(size, wanted)) return 1;
  const auto count = static_cast<double>(std::int64_t{size.width} * size.height);
  const int side = static_cast<int>(std::ceil(std::sqrt(count / static_cast<double>(wanted))));
  return std::min(side, (std::max(size.width, size.height) + 1) / 2);
}

// Chooses one texel at random in each cell of a regular grid, so that samples are spread evenly and never repeat.
// If there are few texels, all of them are taken. Cells at the right and lower borders are smaller, so their texels are
// more likely to be drawn:
//
//      7 rows, cells of 4 x 4:   | 16 | 16 | .. | 4 |      the number of texels that a sample counts for; without it
//                                | 12 | 12 | .. | 3 |      the lower rows of a thin level would weigh too much
void append_samples(int level, PlaneSize size, std::int64_t wanted, SplitMix64& random,
                    std::vector<AccuracySample>& samples) {
  const int side = cell_side(size, wanted);
  for (int y = 0; y < size.height; y += side)
    for (int x = 0; x < size.width; x += side) {
      const int cell_width = std::min(side, size.width - x), cell_height = std::min(side, size.height - y);
      const int dx = static_cast<int>(random.next() % static_cast<unsigned>(cell_width));
      const int dy = static_cast<int>(random.next() % static_cast<unsigned>(cell_height));
      samples.push_back({level, (y + dy) * size.width + x + dx, cell_width * cell_height});
    }
}

// Relates two levels along one axis. The coarse level has `size` texels, and the fine level has `fine_size` texels.
// Returns the two coarse texels on either side of the centre of fine texel i, clamped to the borders.
struct AxisTaps {
  int first, second;
  double second_weight;
};
AxisTaps bilinear_axis(int i, int fine_size, int size) {
  const double position = (i + 0.5) / fine_size * size - 0.5;
  const int low = static_cast<int>(std::floor(position));
  return {std::clamp(low, 0, size - 1), std::clamp(low + 1, 0, size - 1), position - low};
}

// Calls body(kind, {{level, texel, weight}...}) for each point of a sample.
struct WeightedTexel {
  int level;
  int texel;
  double weight;
};
template <typename Body>
void for_each_point(const std::vector<PlaneSize>& levels, const AccuracySample& sample, const Body& body) {
  const int l = sample.level, texel = sample.texel;
  const PlaneSize fine = levels[static_cast<std::size_t>(l)];
  const int x = texel % fine.width, y = texel / fine.width;
  std::array<WeightedTexel, 5> taps{WeightedTexel{l, texel, 1.0}};
  body(AccuracyPoint::kCentre, taps, 1);
  taps[0].weight = 0.5;
  taps[1] = {l, texel + 1, 0.5};
  if (x + 1 < fine.width) body(AccuracyPoint::kMidX, taps, 2);
  taps[1] = {l, texel + fine.width, 0.5};
  if (y + 1 < fine.height) body(AccuracyPoint::kMidY, taps, 2);
  if (static_cast<std::size_t>(l) + 1 == levels.size()) return;
  const PlaneSize coarse = levels[static_cast<std::size_t>(l) + 1];
  const AxisTaps h = bilinear_axis(x, fine.width, coarse.width), v = bilinear_axis(y, fine.height, coarse.height);
  taps[1] = {l + 1, v.first * coarse.width + h.first, 0.5 * (1 - h.second_weight) * (1 - v.second_weight)};
  taps[2] = {l + 1, v.first * coarse.width + h.second, 0.5 * h.second_weight * (1 - v.second_weight)};
  taps[3] = {l + 1, v.second * coarse.width + h.first, 0.5 * (1 - h.second_weight) * v.second_weight};
  taps[4] = {l + 1, v.second * coarse.width + h.second, 0.5 * h.second_weight * v.second_weight};
  body(AccuracyPoint::kBetween, taps, 5);
}

std::vector<AccuracySample> choose_samples(const std::vector<PlaneSize>& levels, const SampleSettings& settings) {
  std::vector<AccuracySample> samples;
  SplitMix64 random(settings.seed);
  for (int l = settings.first_level; l < static_cast<int>(levels.size()); ++l)
    append_samples(l, levels[static_cast<std::size_t>(l)], settings.samples_per_level, random, samples);
  return samples;
}

// If every texel of a level is a sample, the points read only sampled texels of this level. The same is true for every
// coarser level.
TexelSelection needed_texels(const std::vector<PlaneSize>& levels, const std::vector<AccuracySample>& samples,
                             std::int64_t wanted) {
  std::vector<std::vector<int>> texels(levels.size());
  for (const AccuracySample& sample : samples) {
    if (is_whole(levels[static_cast<std::size_t>(sample.level)], wanted)) {
      texels[static_cast<std::size_t>(sample.level)].push_back(sample.texel);
      continue;
    }
    for_each_point(levels, sample, [&](AccuracyPoint, const std::array<WeightedTexel, 5>& taps, int tap_count) {
      for (int t = 0; t < tap_count; ++t) {
        const auto level = static_cast<std::size_t>(taps[static_cast<std::size_t>(t)].level);
        if (static_cast<int>(level) == sample.level || !is_whole(levels[level], wanted))
          texels[level].push_back(taps[static_cast<std::size_t>(t)].texel);
      }
    });
  }
  return {levels, std::move(texels)};
}

}  // namespace

const char* accuracy_point_name(AccuracyPoint point) {
  switch (point) {
    case AccuracyPoint::kCentre: return "centre";
    case AccuracyPoint::kMidX: return "midway-x";
    case AccuracyPoint::kMidY: return "midway-y";
    case AccuracyPoint::kBetween: return "between-levels";
  }
  return "?";
}

AccuracyPoints::AccuracyPoints(const std::vector<PlaneSize>& levels, const SampleSettings& settings)
    : samples_(choose_samples(levels, settings)), texels_(needed_texels(levels, samples_, settings.samples_per_level)) {
  for (const AccuracySample& sample : samples_)
    if (!is_whole(levels[static_cast<std::size_t>(sample.level)], settings.samples_per_level)) ++chosen_count_;
}

void AccuracyPoints::append_points(std::size_t sample, std::vector<SamplePoint>& points) const {
  for_each_point(texels_.sizes(), samples_[sample],
                 [&](AccuracyPoint kind, const std::array<WeightedTexel, 5>& taps, int tap_count) {
                   SamplePoint point{kind, sample, {}, {}, tap_count};
                   for (std::size_t t = 0; t < static_cast<std::size_t>(tap_count); ++t) {
                     point.slots[t] = texels_.slot(taps[t].level, taps[t].texel);
                     point.weights[t] = taps[t].weight;
                   }
                   points.push_back(point);
                 });
}

}  // namespace multum
