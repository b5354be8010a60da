// SPDX-License-Identifier: Apache-2.0
// Averages a plane over footprints (host/bakes/accuracy/footprints.h). These averages are the reference of pixels. The
// rows of the plane are added one by one, and only one sum per footprint is kept. Each texel of level 0 is a square of
// constant value, as with "nearest" filtering.
//
// A footprint is cut into horizontal lines. The average along a line is exact. It is computed from the integrals of the
// row up to each end of the line:
//
//      ..|..____:::     the part of a line inside the footprint is whole texels and a fraction of a texel at each end
//      ..|:::::/..      sum = C(x1) - C(x0); C(x) is the integral of the row from its border to x, for any wrap mode
//
// There are at least kLinesMin lines, and at least as many as the footprint has rows. A footprint of more than kRowsMax
// rows has one line, at a random place, in each of kRowsMax equal strips.
#pragma once

#include <cstdint>
#include <vector>

#include "host/bakes/accuracy/footprints.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {

class FootprintAverages {
 public:
  static constexpr int kLinesMin = 64, kRowsMax = 512;

  FootprintAverages(std::vector<Footprint> footprints, int map_width, int map_height,
                    const FootprintSettings& settings);

  const std::vector<Footprint>& footprints() const { return footprints_; }
  int map_width() const { return map_width_; }
  /// Returns the number of doubles that add_rows() needs as scratch memory.
  std::size_t scratch_length() const { return 2 * kLanes * static_cast<std::size_t>(map_width_); }
  bool needs_row(int y) const {
    return line_begin_[static_cast<std::size_t>(y)] < line_begin_[static_cast<std::size_t>(y) + 1];
  }
  /// Adds row y of each plane p, values[p][0..map_width()), to sums[footprint * stride + p]. Values are multiplied by
  /// `factors` unless it is null. Sums start at 0 and become averages after the last row. `scratch` holds
  /// scratch_length() doubles. Up to kLanes planes take little more time than one.
  void add_rows(int y, const std::vector<const double*>& values, const double* factors, AlignedRow& scratch,
                double* sums, std::size_t stride) const;

  static constexpr std::size_t kLanes = 4;  // planes that are added together

  // The integral of a part of a line within a row. Its first term is weight_turns times the sum of the row. The second
  // term is weight_end times the integral over the texels before `end` and over the fraction end_part of texel `end`.
  // The corresponding integral up to the beginning of the line is subtracted. The signs of the weights account for
  // mirrored rows.
  struct Line {
    std::uint32_t footprint;
    std::int32_t begin, end;
    float begin_part, end_part;
    double weight_begin, weight_end, weight_turns;
  };

 private:
  struct RowLine {
    int row;
    Line line;
  };
  struct End;
  End end_at(double x) const;
  void append_lines(std::uint32_t footprint, std::uint64_t seed, std::vector<RowLine>& lines) const;

  const std::vector<Footprint> footprints_;
  const int map_width_, map_height_;
  const WrapMode wrap_s_, wrap_t_;
  std::vector<Line> lines_;
  std::vector<std::size_t> line_begin_;  // [row]; the last entry is the end of the last range
};

}  // namespace multum
