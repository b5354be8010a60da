// SPDX-License-Identifier: Apache-2.0
// The noise quarter of the four-quarter map, row by row: white noise filtered by a Gaussian of 0.8 texels, periodic;
// slopes of central differences, scaled to rms 0.45, then by 0.4 .. 1.6 from left to right. SplitMix64 and Box-Muller,
// written out, so that a seed means the same map under every standard library (up to the last bits of log, sin and cos,
// which rounding to 16 bits hides but for ties).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace multum {

/// Of one row; rows grow downwards, and so does y.
struct NoiseSlopes {
  std::vector<double> x;
  std::vector<double> y;
};

class NoiseQuarter {
 public:
  /// Goes through the whole quarter once, for its rms.
  NoiseQuarter(int size, std::uint64_t seed);
  NoiseQuarter(const NoiseQuarter&) = delete;
  NoiseQuarter& operator=(const NoiseQuarter&) = delete;

  /// Any row; quickest from the top to the bottom.
  NoiseSlopes row(int row);

 private:
  using Row = std::vector<double>;

  // The last few rows that were asked for; rows beyond the border are those of the other side.
  class RecentRows {
   public:
    RecentRows(int height, std::size_t kept_count, std::function<Row(int row)> make)
        : height_(height), kept_(kept_count), make_(std::move(make)) {}
    std::shared_ptr<const Row> row(int row);

   private:
    struct Kept {
      int row = -1;
      std::shared_ptr<const Row> values;
    };
    int height_;
    std::vector<Kept> kept_;
    std::function<Row(int row)> make_;
  };

  Row differences_x(int row);

  int size_;
  std::vector<double> weights_;     // of the Gaussian
  RecentRows filtered_along_rows_;  // white noise, filtered to left and right
  RecentRows filtered_;
  double scale_ = 1.0;
};

}  // namespace multum
