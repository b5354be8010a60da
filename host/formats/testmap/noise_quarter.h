// SPDX-License-Identifier: Apache-2.0
// Makes the noise quarter of the four-quarter map row by row. It is periodic white noise, filtered by a Gaussian of 0.8
// texels. Slopes are central differences. They are scaled to an rms of 0.45, then multiplied by a factor that grows
// from 0.4 at the left to 1.6 at the right. SplitMix64 and Box-Muller are implemented here, so that a seed gives the
// same map with every standard library. Only the last bits of log, sin and cos can differ. Rounding to 16 bits hides
// these differences, except when a value is close to the midpoint of two codes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace multum {

/// Slopes of one row. Row numbers and y grow downwards.
struct NoiseSlopes {
  std::vector<double> x;
  std::vector<double> y;
};

class NoiseQuarter {
 public:
  /// Computes the whole quarter once, in order to get its rms.
  NoiseQuarter(int size, std::uint64_t seed);
  NoiseQuarter(const NoiseQuarter&) = delete;
  NoiseQuarter& operator=(const NoiseQuarter&) = delete;

  /// Returns any row. Calls from the top to the bottom are fastest.
  NoiseSlopes row(int row);

 private:
  using Row = std::vector<double>;

  // The most recently used rows. Rows beyond the border wrap around.
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
  std::vector<double> weights_;     // weights of the Gaussian
  RecentRows filtered_along_rows_;  // white noise filtered along rows
  RecentRows filtered_;
  double scale_ = 1.0;
};

}  // namespace multum
