// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/footprint_averages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/split_mix.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

// The number of strips of a row that are summed in parallel, to hide the latency of dependent additions.
constexpr std::size_t kStrips = 4;

// Returns the number of columns of each strip except the last, which has the remaining columns. A strip has slightly
// less than a quarter of the columns. With exactly a quarter, the distance between strips could be a power of two, and
// their addresses would compete for the same cache sets.
std::size_t strip_width(std::size_t width) { return width / 4 - width / 64; }

// Sets to[column][lane] to the value of plane `lane`, times the factor.
MULTUM_VECTOR_CLONES
void interleave(const double* a, const double* b, const double* c, const double* d, const double* factors,
                std::size_t width, double* __restrict to) {
  for (std::size_t i = 0; i < width; ++i) {
    const double factor = factors[i];
    to[4 * i] = a[i] * factor;
    to[4 * i + 1] = b[i] * factor;
    to[4 * i + 2] = c[i] * factor;
    to[4 * i + 3] = d[i] * factor;
  }
}

// Sets before[i] to the sum of the strip's columns before column i, and upto_strip[k] to the sum of the strips before
// strip k. The last entry is the sum of all strips. An Element is the value of one plane or of several planes.
template <typename Element>
inline __attribute__((always_inline)) void sum_up(const Element* __restrict values, std::size_t width,
                                                  Element* __restrict before, Element* __restrict upto_strip) {
  const std::size_t strip = strip_width(width);
  Element sums[kStrips] = {};
  for (std::size_t i = 0; i < strip; ++i)
    for (std::size_t k = 0; k < kStrips; ++k) {
      before[k * strip + i] = sums[k];
      sums[k] += values[k * strip + i];
    }
  for (std::size_t column = kStrips * strip; column < width; ++column) {
    before[column] = sums[kStrips - 1];
    sums[kStrips - 1] += values[column];
  }
  upto_strip[0] = Element{};
  for (std::size_t k = 0; k < kStrips; ++k) upto_strip[k + 1] = upto_strip[k] + sums[k];
}

// Returns the positions where the line at height y enters and leaves a rectangle. If the line misses the rectangle,
// entry >= exit.
std::pair<double, double> crossing(const Footprint& footprint, double y) {
  const glm::dvec2 half_longer = 0.5 * footprint.longer_side, half_shorter = 0.5 * footprint.shorter_side;
  const std::array<glm::dvec2, 4> corners = {
      footprint.centre - half_longer - half_shorter, footprint.centre + half_longer - half_shorter,
      footprint.centre + half_longer + half_shorter, footprint.centre - half_longer + half_shorter};
  double entry = HUGE_VAL, exit = -HUGE_VAL;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec2 a = corners[i], b = corners[(i + 1) % corners.size()];
    if ((a.y <= y) == (b.y <= y)) continue;
    const double x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
    entry = std::min(entry, x);
    exit = std::max(exit, x);
  }
  return {entry, exit};
}

struct HorizontalLine {
  double y, thickness;
};

// Cuts a footprint into thin slices and returns the lines through their middles. Slices end at the borders of rows and
// at corners of the footprint, so that the ends of the lines change linearly within each slice. A tall footprint is
// divided into equal strips, and one row of each strip is chosen at random.
std::vector<HorizontalLine> horizontal_lines(const Footprint& footprint, std::uint64_t seed) {
  const double height = std::abs(footprint.longer_side.y) + std::abs(footprint.shorter_side.y);
  const double top = footprint.centre.y - 0.5 * height, bottom = top + height;
  std::vector<HorizontalLine> lines;
  if (height > FootprintAverages::kRowsMax) {
    SplitMix64 random(seed);
    const double strip = height / FootprintAverages::kRowsMax;
    for (int i = 0; i < FootprintAverages::kRowsMax; ++i)
      lines.push_back({top + (i + 1.0 - random.uniform()) * strip, strip});
    return lines;
  }
  const double inner = 0.5 * std::abs(std::abs(footprint.longer_side.y) - std::abs(footprint.shorter_side.y));
  std::vector<double> cuts = {top, footprint.centre.y - inner, footprint.centre.y + inner, bottom};
  for (double row = std::floor(top) + 1.0; row < bottom; row += 1.0) cuts.push_back(row);
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double between = cuts[i] - cuts[i - 1];
    const int count = std::max(1, static_cast<int>(std::lround(FootprintAverages::kLinesMin * between / height)));
    for (int k = 0; k < count && between > 0.0; ++k)
      lines.push_back({cuts[i - 1] + (k + 0.5) / count * between, between / count});
  }
  return lines;
}

}  // namespace

// C(x) = turns * (sum of the row) + sign * (integral from 0 to texel + part).
struct FootprintAverages::End {
  double turns, sign;
  int texel;
  double part;
};

FootprintAverages::End FootprintAverages::end_at(double x) const {
  const double width = map_width_;
  const auto at = [&](double turns, double sign, double place) {
    const int texel = std::clamp(static_cast<int>(place), 0, map_width_ - 1);
    return End{turns, sign, texel, std::clamp(place - texel, 0.0, 1.0)};
  };
  switch (wrap_s_) {
    case WrapMode::kPeriodic: {
      const double turns = std::floor(x / width);
      return at(turns, 1.0, x - turns * width);
    }
    case WrapMode::kMirror: {
      const double pairs = std::floor(x / (2.0 * width)), place = x - pairs * 2.0 * width;
      return place < width ? at(2.0 * pairs, 1.0, place) : at(2.0 * pairs + 2.0, -1.0, 2.0 * width - place);
    }
    default: return at(0.0, 1.0, std::clamp(x, 0.0, width));
  }
}

void FootprintAverages::append_lines(std::uint32_t number, std::uint64_t seed, std::vector<RowLine>& lines) const {
  const Footprint& footprint = footprints_[number];
  const std::size_t first = lines.size();
  double area = 0.0;
  for (const auto& [y, thickness] : horizontal_lines(footprint, seed)) {
    const auto [entry, exit] = crossing(footprint, y);
    if (!(exit > entry)) continue;
    const End begin = end_at(entry), end = end_at(exit);
    const double in_map = (end.texel + end.part) - (begin.texel + begin.part);
    const auto row = static_cast<std::int64_t>(std::floor(y));
    const bool is_beyond = row < 0 || row >= map_height_;
    // If a map ends at its border, a pixel there averages only the surface under it. If the border is black, the
    // surface beyond it reflects nothing.
    if (is_beyond && wrap_t_ == WrapMode::kClamp) continue;
    area += thickness * (wrap_s_ == WrapMode::kClamp ? in_map : exit - entry);
    if (is_beyond && wrap_t_ == WrapMode::kBlack) continue;
    lines.push_back({wrapped_index(row, map_height_, wrap_t_),
                     {number, begin.texel, end.texel, static_cast<float>(begin.part), static_cast<float>(end.part),
                      thickness * begin.sign, thickness * end.sign, thickness * (end.turns - begin.turns)}});
  }
  for (std::size_t i = first; i < lines.size() && area > 0.0; ++i) {
    lines[i].line.weight_begin /= area;
    lines[i].line.weight_end /= area;
    lines[i].line.weight_turns /= area;
  }
  if (!(area > 0.0)) lines.resize(first);
}

FootprintAverages::FootprintAverages(std::vector<Footprint> footprints, int map_width, int map_height,
                                     const FootprintSettings& settings)
    : footprints_(std::move(footprints)),
      map_width_(map_width),
      map_height_(map_height),
      wrap_s_(settings.wrap_s),
      wrap_t_(settings.wrap_t),
      line_begin_(static_cast<std::size_t>(map_height) + 1) {
  std::vector<RowLine> unsorted;
  for (std::uint32_t i = 0; i < footprints_.size(); ++i)
    append_lines(i, split_mix(settings.seed ^ split_mix(i)), unsorted);
  // Sorts by row and, within a row, by footprint, so that the order is fixed.
  for (const RowLine& one : unsorted) ++line_begin_[static_cast<std::size_t>(one.row) + 1];
  for (std::size_t y = 1; y < line_begin_.size(); ++y) line_begin_[y] += line_begin_[y - 1];
  std::vector<std::size_t> next = line_begin_;
  lines_.resize(unsorted.size());
  for (const RowLine& one : unsorted) lines_[next[static_cast<std::size_t>(one.row)]++] = one.line;
}

namespace {

// Four planes as a vector of GCC.
using FourPlanes = double __attribute__((vector_size(FootprintAverages::kLanes * sizeof(double)), may_alias));

MULTUM_VECTOR_CLONES
void add_plane(const double* values, std::size_t width, double* before, const FootprintAverages::Line* lines,
               std::size_t line_count, double* sums, std::size_t stride) {
  double upto_strip[kStrips + 1];
  sum_up(values, width, before, upto_strip);
  const std::size_t strip = strip_width(width);
  const auto strip_of = [&](std::size_t column) {
    return (column >= strip ? 1u : 0u) + (column >= 2 * strip ? 1u : 0u) + (column >= 3 * strip ? 1u : 0u);
  };
  for (std::size_t i = 0; i < line_count; ++i) {
    const FootprintAverages::Line& line = lines[i];
    const auto begin = static_cast<std::size_t>(line.begin), end = static_cast<std::size_t>(line.end);
    const double to_begin =
        upto_strip[strip_of(begin)] + before[begin] + static_cast<double>(line.begin_part) * values[begin];
    const double to_end = upto_strip[strip_of(end)] + before[end] + static_cast<double>(line.end_part) * values[end];
    sums[line.footprint * stride] +=
        line.weight_turns * upto_strip[kStrips] + line.weight_end * to_end - line.weight_begin * to_begin;
  }
}

// Adds `plane_count` of the four planes.
MULTUM_VECTOR_CLONES
void add_four_planes(const FourPlanes* values, std::size_t width, FourPlanes* before,
                     const FootprintAverages::Line* lines, std::size_t line_count, double* sums, std::size_t stride,
                     std::size_t plane_count) {
  FourPlanes upto_strip[kStrips + 1];
  sum_up(values, width, before, upto_strip);
  // Rows that are added in this way have many lines, so the sums of the strips are added once per column instead of
  // twice per line.
  const std::size_t strip = strip_width(width);
  for (std::size_t k = 1; k < kStrips; ++k) {
    const std::size_t strip_end = k + 1 < kStrips ? (k + 1) * strip : width;
    for (std::size_t column = k * strip; column < strip_end; ++column) before[column] = upto_strip[k] + before[column];
  }
  for (std::size_t i = 0; i < line_count; ++i) {
    const FootprintAverages::Line& line = lines[i];
    const FourPlanes to_begin = before[line.begin] + static_cast<double>(line.begin_part) * values[line.begin];
    const FourPlanes to_end = before[line.end] + static_cast<double>(line.end_part) * values[line.end];
    const FourPlanes added =
        line.weight_turns * upto_strip[kStrips] + line.weight_end * to_end - line.weight_begin * to_begin;
    double* const sum = sums + line.footprint * stride;
    if (plane_count == FootprintAverages::kLanes) {
      for (std::size_t lane = 0; lane < FootprintAverages::kLanes; ++lane) sum[lane] += added[lane];
    } else {
      for (std::size_t lane = 0; lane < plane_count; ++lane) sum[lane] += added[lane];
    }
  }
}

MULTUM_VECTOR_CLONES
void multiply(const double* __restrict values, const double* __restrict factors, std::size_t width,
              double* __restrict products) {
  for (std::size_t i = 0; i < width; ++i) products[i] = values[i] * factors[i];
}

}  // namespace

void FootprintAverages::add_rows(int y, const std::vector<const double*>& values, const double* factors,
                                 AlignedRow& scratch, double* sums, std::size_t stride) const {
  const auto width = static_cast<std::size_t>(map_width_);
  const std::size_t first_line = line_begin_[static_cast<std::size_t>(y)],
                    line_count = line_begin_[static_cast<std::size_t>(y) + 1] - first_line;
  const Line* const lines = lines_.data() + first_line;
  double* const products = scratch.data();
  double* const before = products + kLanes * width;
  // Planes that are added together share the work per line. In rows of many columns and few lines, sorting the columns
  // of four planes would take longer than this saves.
  const bool adds_together = factors != nullptr && 4 * line_count > width;
  const std::size_t lanes = adds_together ? kLanes : 1;
  for (std::size_t first = 0; first < values.size(); first += lanes) {
    const std::size_t count = std::min(lanes, values.size() - first);
    if (count > 1) {
      // Lanes without a plane repeat the last one, and are not added.
      const auto plane = [&](std::size_t lane) { return values[first + std::min(lane, count - 1)]; };
      interleave(plane(0), plane(1), plane(2), plane(3), factors, width, products);
      add_four_planes(reinterpret_cast<const FourPlanes*>(products), width, reinterpret_cast<FourPlanes*>(before),
                      lines, line_count, sums + first, stride, count);
    } else {
      if (factors != nullptr) multiply(values[first], factors, width, products);
      add_plane(factors != nullptr ? products : values[first], width, before, lines, line_count, sums + first, stride);
    }
  }
}

}  // namespace multum
