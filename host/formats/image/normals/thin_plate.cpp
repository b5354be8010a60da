// SPDX-License-Identifier: Apache-2.0
// Solves from coarse to fine. The code of a coarser texel is the mean of the 2 x 2 codes of the next finer level. The
// plate of a coarser level is the initial solution of the next finer level. Each level is solved by projected gradients
// with Nesterov's momentum (Beck & Teboulle 2009, "A fast iterative shrinkage-thresholding algorithm", FISTA with
// constant steps). The largest eigenvalue of the energy is 64.
//
// These figures were measured on smooth 8-bit surfaces where a step of one code tilts a texel by 45 degrees. Without
// this method, the mean error of normals is 17 degrees. It is 2.3 degrees with 16 steps of the descent at the finest
// level, 0.8 degrees with 64 steps, and 0.2 degrees with 300 steps. Ramps, which plates represent exactly, have errors
// below 0.1 degrees, or up to 0.6 degrees where a plateau is longer than the map is high. More steps of the descent at
// coarse levels would not help, because the bounds of their means are too wide to determine a plate.
#include "host/formats/image/normals/thin_plate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace multum {
namespace {

constexpr int kFinestSteps = 64, kMostSteps = 250;  // number of steps at the finest level; doubled at each coarser
                                                    // level, up to kMostSteps
constexpr int kCoarsestSide = 8;                    // number of texels of the longer side
constexpr int kLeastSide = 3;                       // fewer rows do not bend and have no slope
constexpr float kCut = 1.5f;                        // in codes
constexpr float kEigenvalueMax = 64.0f;

// A level. A weight is 0 if a cut crosses the second difference; otherwise, it is 1.
struct Plate {
  int width = 0, height = 0;
  std::vector<float> codes;                          // 0 for texels without a code
  std::vector<std::uint8_t> is_whole;                // true if the texel has a code and no cut inside
  std::vector<std::uint8_t> right_link, below_link;  // links to neighbours; 0 means that the link is cut
  std::vector<std::uint8_t> bend_x, bend_y, twist;   // weights of h_xx and h_yy at a texel, and of h_xy at the lower
                                                     // right corner of the texel

  std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
  }
  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

void make_weights(Plate& plate) {
  const auto row_step = static_cast<std::size_t>(plate.width);
  plate.bend_x.assign(plate.size(), 0);
  plate.bend_y.assign(plate.size(), 0);
  plate.twist.assign(plate.size(), 0);
  for (int row = 0; row < plate.height; ++row) {
    for (int column = 0; column < plate.width; ++column) {
      const std::size_t i = plate.at(column, row);
      const bool has_right = plate.right_link[i] != 0, has_below = plate.below_link[i] != 0;
      plate.bend_x[i] = column > 0 && has_right && plate.right_link[i - 1] != 0;
      plate.bend_y[i] = row > 0 && has_below && plate.below_link[i - row_step] != 0;
      plate.twist[i] = has_right && has_below && plate.right_link[i + row_step] != 0 && plate.below_link[i + 1] != 0;
    }
  }
}

Plate finest_plate(const PlateProblem& problem) {
  Plate plate{problem.width, problem.height, problem.codes, {}, {}, {}, {}, {}, {}};
  plate.is_whole.resize(plate.size());
  plate.right_link.assign(plate.size(), 0);
  plate.below_link.assign(plate.size(), 0);
  const auto is_linked = [&](std::size_t a, std::size_t b) {
    return std::abs(problem.codes[a] - problem.codes[b]) <= kCut;  // false for NaN
  };
  for (int row = 0; row < plate.height; ++row) {
    for (int column = 0; column < plate.width; ++column) {
      const std::size_t i = plate.at(column, row);
      plate.is_whole[i] = std::isnan(problem.codes[i]) ? 0 : 1;
      if (plate.is_whole[i] == 0) plate.codes[i] = 0.0f;
      if (column + 1 < plate.width) plate.right_link[i] = is_linked(i, i + 1);
      if (row + 1 < plate.height) plate.below_link[i] = is_linked(i, plate.at(column, row + 1));
    }
  }
  make_weights(plate);
  return plate;
}

// Makes a level whose texels cover 2 x 2 uncut texels each. The codes of the new level are the means of these 2 x 2
// texels. An odd last row or column is dropped, because half a texel would have a wrong position and would bend the
// plate.
Plate coarser_plate(const Plate& fine) {
  Plate plate{fine.width / 2, fine.height / 2, {}, {}, {}, {}, {}, {}, {}};
  plate.codes.assign(plate.size(), 0.0f);
  plate.is_whole.assign(plate.size(), 0);
  plate.right_link.assign(plate.size(), 0);
  plate.below_link.assign(plate.size(), 0);
  for (int row = 0; row < plate.height; ++row) {
    for (int column = 0; column < plate.width; ++column) {
      const std::size_t upper = fine.at(2 * column, 2 * row), lower = fine.at(2 * column, 2 * row + 1);
      const std::size_t i = plate.at(column, row);
      plate.codes[i] = 0.25f * (fine.codes[upper] + fine.codes[upper + 1] + fine.codes[lower] + fine.codes[lower + 1]);
      // Links exist only between texels with codes; a 2 x 2 block has four links.
      plate.is_whole[i] =
          fine.right_link[upper] & fine.right_link[lower] & fine.below_link[upper] & fine.below_link[upper + 1];
      plate.right_link[i] = column + 1 < plate.width ? fine.right_link[upper + 1] & fine.right_link[lower + 1] : 0;
      plate.below_link[i] = row + 1 < plate.height ? fine.below_link[lower] & fine.below_link[lower + 1] : 0;
    }
  }
  for (int row = 0; row < plate.height; ++row) {
    for (int column = 0; column < plate.width; ++column) {
      const std::size_t i = plate.at(column, row);
      if (plate.right_link[i] != 0) plate.right_link[i] = plate.is_whole[i] & plate.is_whole[i + 1];
      if (plate.below_link[i] != 0) plate.below_link[i] = plate.is_whole[i] & plate.is_whole[plate.at(column, row + 1)];
    }
  }
  make_weights(plate);
  return plate;
}

// Returns a quarter of the slope at a texel, from the linked neighbours on either side.
float quarter_slope(float before, float at, float after, bool has_before, bool has_after) {
  if (has_before && has_after) return 0.125f * (after - before);
  if (has_after) return 0.25f * (after - at);
  return has_before ? 0.25f * (at - before) : 0.0f;
}

// Sums the predictions of one texel from several directions.
struct Continuation {
  float sum = 0.0f;
  int count = 0;
};

// Extends known heights by one texel into unknown ones. If there are two linked neighbours, it continues them linearly.
// If there is one neighbour, it repeats the height of this neighbour.
void continue_once(const Plate& plate, std::vector<float>& heights, std::vector<std::uint8_t>& is_known) {
  const std::vector<float> before(heights);
  const std::vector<std::uint8_t> was_known(is_known);
  const auto step = static_cast<std::ptrdiff_t>(plate.width);
  const auto is_linked = [&](std::ptrdiff_t from, std::ptrdiff_t to, const std::vector<std::uint8_t>& links) {
    return links[static_cast<std::size_t>(std::min(from, to))] != 0 && was_known[static_cast<std::size_t>(to)] != 0;
  };
  for (int row = 0; row < plate.height; ++row) {
    for (int column = 0; column < plate.width; ++column) {
      const auto at = static_cast<std::ptrdiff_t>(plate.at(column, row));
      if (was_known[static_cast<std::size_t>(at)] != 0) continue;
      Continuation found;
      const auto look = [&](std::ptrdiff_t offset, int room, const std::vector<std::uint8_t>& links) {
        if (room < 1 || !is_linked(at, at + offset, links)) return;
        const float near = before[static_cast<std::size_t>(at + offset)];
        const bool has_far = room > 1 && is_linked(at + offset, at + 2 * offset, links);
        found.sum += has_far ? 2.0f * near - before[static_cast<std::size_t>(at + 2 * offset)] : near;
        ++found.count;
      };
      look(-1, column, plate.right_link);
      look(1, plate.width - 1 - column, plate.right_link);
      look(-step, row, plate.below_link);
      look(step, plate.height - 1 - row, plate.below_link);
      if (found.count == 0) continue;
      heights[static_cast<std::size_t>(at)] = found.sum / static_cast<float>(found.count);
      is_known[static_cast<std::size_t>(at)] = 1;
    }
  }
}

// Makes the initial heights of the finer level from planes through the coarser texels. Texels that are cut off have no
// plane, so they continue the surrounding heights. If there are no such heights, they start with their codes.
std::vector<float> refined(const Plate& coarse, const std::vector<float>& heights, const Plate& fine) {
  std::vector<float> result(fine.codes);
  std::vector<std::uint8_t> is_known(fine.size(), 0);
  const auto row_step = static_cast<std::size_t>(coarse.width);
  for (int row = 0; row < coarse.height; ++row) {
    for (int column = 0; column < coarse.width; ++column) {
      const std::size_t i = coarse.at(column, row);
      if (coarse.is_whole[i] == 0) continue;
      const bool has_left = column > 0 && coarse.right_link[i - 1] != 0, has_right = coarse.right_link[i] != 0;
      const bool has_above = row > 0 && coarse.below_link[i - row_step] != 0, has_below = coarse.below_link[i] != 0;
      const float dx = quarter_slope(has_left ? heights[i - 1] : 0.0f, heights[i], has_right ? heights[i + 1] : 0.0f,
                                     has_left, has_right);
      const float dy = quarter_slope(has_above ? heights[i - row_step] : 0.0f, heights[i],
                                     has_below ? heights[i + row_step] : 0.0f, has_above, has_below);
      for (int y = 2 * row; y < std::min(fine.height, 2 * row + 2); ++y)
        for (int x = 2 * column; x < std::min(fine.width, 2 * column + 2); ++x) {
          result[fine.at(x, y)] = heights[i] + (x % 2 == 0 ? -dx : dx) + (y % 2 == 0 ? -dy : dy);
          is_known[fine.at(x, y)] = 1;
        }
    }
  }
  constexpr int kContinuations = 2;  // side of a coarser texel, in texels of the finer level
  for (int i = 0; i < kContinuations; ++i)
    if (std::find(is_known.begin(), is_known.end(), 0) != is_known.end()) continue_once(fine, result, is_known);
  return result;
}

// Makes one step of the descent, row by row. A row needs the second differences of its neighbours, so the last rows of
// each kind are kept.
class Descent {
 public:
  Descent(const Plate& plate, std::vector<float>& heights)
      : plate_(plate), heights_(heights), point_(heights), next_(heights.size()) {
    const std::size_t row = static_cast<std::size_t>(plate.width) + 2;
    for (std::vector<float>& bend : bend_y_) bend.resize(row);
    for (std::vector<float>& twist : twist_) twist.resize(row);
    bend_x_.resize(row);
  }

  // `momentum` comes from the previous step.
  void step(float momentum) {
    std::fill(bend_y_[2].begin(), bend_y_[2].end(), 0.0f);  // second differences of the row above the first row
    std::fill(twist_[1].begin(), twist_[1].end(), 0.0f);
    take_bend_y(0);
    for (int row = 0; row < plate_.height; ++row) {
      take_bend_x(row);
      take_twist(row);
      take_bend_y(row + 1);
      move_row(row, momentum);
    }
    std::swap(point_, next_);
  }

 private:
  void take_bend_x(int row) {
    const std::size_t first = plate_.at(0, row);
    for (int i = 1; i + 1 < plate_.width; ++i) {
      const std::size_t at = first + static_cast<std::size_t>(i);
      bend_x_[static_cast<std::size_t>(i) + 1] =
          static_cast<float>(plate_.bend_x[at]) * (point_[at - 1] - 2.0f * point_[at] + point_[at + 1]);
    }
  }
  void take_bend_y(int row) {
    std::vector<float>& bend = bend_y_[static_cast<std::size_t>(row % 3)];
    if (row < 1 || row + 1 >= plate_.height) {
      std::fill(bend.begin(), bend.end(), 0.0f);
      return;
    }
    const auto row_step = static_cast<std::size_t>(plate_.width);
    const std::size_t first = plate_.at(0, row);
    for (std::size_t i = 0; i < row_step; ++i) {
      const std::size_t at = first + i;
      bend[i + 1] =
          static_cast<float>(plate_.bend_y[at]) * (point_[at - row_step] - 2.0f * point_[at] + point_[at + row_step]);
    }
  }
  void take_twist(int row) {
    std::vector<float>& twist = twist_[static_cast<std::size_t>(row % 2)];
    if (row + 1 >= plate_.height) {
      std::fill(twist.begin(), twist.end(), 0.0f);
      return;
    }
    const auto row_step = static_cast<std::size_t>(plate_.width);
    const std::size_t first = plate_.at(0, row);
    for (std::size_t i = 0; i + 1 < row_step; ++i) {
      const std::size_t at = first + i;
      twist[i + 1] = 2.0f * static_cast<float>(plate_.twist[at]) *
                     (point_[at] - point_[at + 1] - point_[at + row_step] + point_[at + row_step + 1]);
    }
  }
  // Moves along the negative gradient, then back into the bounds, then onward by the momentum.
  void move_row(int row, float momentum) {
    const std::vector<float>&above = bend_y_[static_cast<std::size_t>((row + 2) % 3)],
          &own = bend_y_[static_cast<std::size_t>(row % 3)], &below = bend_y_[static_cast<std::size_t>((row + 1) % 3)];
    const std::vector<float>&twist = twist_[static_cast<std::size_t>(row % 2)],
          &twist_above = twist_[static_cast<std::size_t>((row + 1) % 2)];
    const std::size_t first = plate_.at(0, row);
    for (std::size_t i = 0; i < static_cast<std::size_t>(plate_.width); ++i) {
      const std::size_t at = first + i;
      const float gradient = bend_x_[i] - 2.0f * bend_x_[i + 1] + bend_x_[i + 2] +  //
                             above[i + 1] - 2.0f * own[i + 1] + below[i + 1] +      //
                             twist[i + 1] - twist[i] - twist_above[i + 1] + twist_above[i];
      const float code = plate_.codes[at];
      const float moved = std::min(std::max(point_[at] - gradient * (1.0f / kEigenvalueMax), code - 0.5f), code + 0.5f);
      next_[at] = moved + momentum * (moved - heights_[at]);
      heights_[at] = moved;
    }
  }

  const Plate& plate_;
  std::vector<float>& heights_;
  std::vector<float> point_, next_;  // heights at which the gradient is computed
  // Texel i of a row is at i + 1.
  std::array<std::vector<float>, 3> bend_y_;
  std::array<std::vector<float>, 2> twist_;
  std::vector<float> bend_x_;
};

void relax(const Plate& plate, int step_count, std::vector<float>& heights) {
  for (std::size_t i = 0; i < heights.size(); ++i)
    heights[i] = std::clamp(heights[i], plate.codes[i] - 0.5f, plate.codes[i] + 0.5f);
  Descent descent(plate, heights);
  double t = 1.0;
  for (int i = 0; i < step_count; ++i) {
    const double next = 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * t * t));
    descent.step(static_cast<float>((t - 1.0) / next));
    t = next;
  }
}

}  // namespace

std::vector<float> thin_plate(const PlateProblem& problem) {
  std::vector<Plate> plates = {finest_plate(problem)};
  while (std::min(plates.back().width, plates.back().height) >= 2 * kLeastSide &&
         std::max(plates.back().width, plates.back().height) > kCoarsestSide)
    plates.push_back(coarser_plate(plates.back()));
  std::vector<float> heights(plates.back().codes);
  for (std::size_t level = plates.size(); level-- > 0;) {
    if (level + 1 < plates.size()) heights = refined(plates[level + 1], heights, plates[level]);
    relax(plates[level], std::min(kMostSteps, kFinestSteps << std::min<std::size_t>(level, 8)), heights);
  }
  return heights;
}

}  // namespace multum
