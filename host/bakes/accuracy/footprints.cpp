// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/footprints.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

// Returns one random number in each of `count` equal parts of [0, 1), in random order.
std::vector<double> stratified(int count, SplitMix64& random) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back((i + 1.0 - random.uniform()) / count);
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[random.next() % i]);
  return values;
}

// Returns one random point in each of `count` cells of equal area. Cells are approximately square and form rows. Some
// rows have one more cell than the others. The height of a row is proportional to its number of cells.
std::vector<glm::dvec2> spread_points(int count, double width, double height, SplitMix64& random) {
  const int rows = std::clamp(static_cast<int>(std::lround(std::sqrt(count * height / width))), 1, count);
  std::vector<glm::dvec2> points;
  for (int row = 0; row < rows; ++row) {
    const int first = static_cast<int>(std::int64_t{count} * row / rows),
              end = static_cast<int>(std::int64_t{count} * (row + 1) / rows);
    for (int i = first; i < end; ++i) {
      const double x = (i - first + 1.0 - random.uniform()) / (end - first) * width;
      const double y = (first + (end - first) * (1.0 - random.uniform())) / count * height;
      points.emplace_back(x, y);
    }
  }
  return points;
}

// The two texels around a position along one axis, and the weight of the second texel. Positions are in texels of the
// level.
struct BilinearPair {
  int first, second;  // -1 if there is none
  double second_weight;
};
BilinearPair bilinear_pair(double place, int count, WrapMode mode) {
  const double low = std::floor(place - 0.5);
  const auto i = static_cast<std::int64_t>(low);
  return {wrapped_index(i, count, mode), wrapped_index(i + 1, count, mode), place - 0.5 - low};
}

}  // namespace

int wrapped_index(std::int64_t i, int count, WrapMode mode) {
  const std::int64_t n = count;
  switch (mode) {
    case WrapMode::kPeriodic: return static_cast<int>((i % n + n) % n);
    case WrapMode::kClamp: return static_cast<int>(std::clamp<std::int64_t>(i, 0, n - 1));
    case WrapMode::kMirror: {
      const std::int64_t twice = (i % (2 * n) + 2 * n) % (2 * n);
      return static_cast<int>(twice < n ? twice : 2 * n - 1 - twice);
    }
    case WrapMode::kBlack: return i >= 0 && i < n ? static_cast<int>(i) : -1;
  }
  return -1;
}

int footprint_octave_count(int map_width, int map_height) {
  return std::max(1, static_cast<int>(std::log2(std::max(map_width, map_height))));
}

int footprint_count(int octave, int map_width, int map_height, int per_octave) {
  const double texels = std::exp2(2 * octave + 2);  // of a footprint of average size
  const double wanted = 16.0 * map_width * map_height / texels;
  return static_cast<int>(
      std::min(std::max(wanted, static_cast<double>(kFootprintsMin)), static_cast<double>(per_octave)));
}

std::vector<Footprint> choose_footprints(int map_width, int map_height, const FootprintSettings& settings) {
  MULTUM_CHECK(settings.per_octave >= 0 && settings.first_octave >= 0 && settings.elongation_max >= 1.0);
  std::vector<Footprint> footprints;
  if (settings.per_octave == 0) return footprints;
  SplitMix64 random(settings.seed);
  const int octaves = footprint_octave_count(map_width, map_height);
  for (int octave = std::min(settings.first_octave, octaves - 1); octave < octaves; ++octave) {
    const int count = footprint_count(octave, map_width, map_height, settings.per_octave);
    const std::vector<glm::dvec2> centres = spread_points(count, map_width, map_height, random);
    const std::vector<double> sizes = stratified(count, random), elongations = stratified(count, random);
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const double shorter = std::exp2(octave + sizes[i]);
      const double longer = shorter * std::pow(settings.elongation_max, elongations[i]);
      const double angle = std::numbers::pi * random.uniform();
      const glm::dvec2 along(std::cos(angle), std::sin(angle));
      footprints.push_back({octave, centres[i], longer * along, shorter * glm::dvec2(-along.y, along.x)});
    }
  }
  return footprints;
}

int append_filter_taps(const Footprint& footprint, const std::vector<PlaneSize>& levels,
                       const FootprintSettings& settings, std::vector<FilterTap>& taps) {
  const double longer = glm::length(footprint.longer_side), shorter = glm::length(footprint.shorter_side);
  const int count = settings.filter.tap_count(longer, shorter);
  const int point_count = settings.filter.shades_taps ? count : 1;
  const auto coarsest = static_cast<double>(levels.size() - 1);
  // Levels finer than the first stored level are not used, as in a renderer that draws only stored levels.
  const double finest = std::min(static_cast<double>(settings.first_octave), coarsest);
  const double lambda = std::clamp(settings.filter.level(longer, shorter), finest, coarsest);
  const double map_width = levels.front().width, map_height = levels.front().height;
  for (int i = 0; i < count; ++i) {
    const glm::dvec2 place = footprint.centre + TapFilter::place(i, count) * footprint.longer_side;
    for (const bool is_coarser : {false, true}) {
      const double share = is_coarser ? lambda - std::floor(lambda) : 1.0 - (lambda - std::floor(lambda));
      if (share == 0.0) continue;
      const int level = static_cast<int>(lambda) + (is_coarser ? 1 : 0);
      const PlaneSize size = levels[static_cast<std::size_t>(level)];
      const BilinearPair x = bilinear_pair(place.x / map_width * size.width, size.width, settings.wrap_s);
      const BilinearPair y = bilinear_pair(place.y / map_height * size.height, size.height, settings.wrap_t);
      const auto add = [&](int column, int row, double weight) {
        if (column >= 0 && row >= 0 && weight > 0.0)
          taps.push_back({i % point_count, level, row * size.width + column, weight * share * point_count / count});
      };
      add(x.first, y.first, (1.0 - x.second_weight) * (1.0 - y.second_weight));
      add(x.second, y.first, x.second_weight * (1.0 - y.second_weight));
      add(x.first, y.second, (1.0 - x.second_weight) * y.second_weight);
      add(x.second, y.second, x.second_weight * y.second_weight);
    }
  }
  return point_count;
}

}  // namespace multum
