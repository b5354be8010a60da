// SPDX-License-Identifier: Apache-2.0
#include "host/formats/sampling/void_and_cluster.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr double kSigma = 1.5;           // width, in texels, of the Gaussian by which Ulichney finds voids and clusters
constexpr std::size_t kFirstShare = 10;  // a tenth of all texels are in the first pattern

/// A binary pattern on a torus, with the sum of its points' Gaussians at each texel.
class Pattern {
 public:
  explicit Pattern(std::size_t side) : side_(side), has_(side * side), sums_(side * side), gaussian_(side * side) {
    const auto distance = [side](std::size_t i) { return static_cast<double>(std::min(i, side - i)); };
    for (std::size_t y = 0; y < side; ++y)
      for (std::size_t x = 0; x < side; ++x) {
        const double square = distance(x) * distance(x) + distance(y) * distance(y);
        gaussian_[y * side + x] = std::exp(-square / (2.0 * kSigma * kSigma));
      }
  }

  bool has(std::size_t texel) const { return has_[texel]; }
  void set(std::size_t texel, bool has) {
    has_[texel] = has;
    const double sign = has ? 1.0 : -1.0;
    for (std::size_t y = 0; y < side_; ++y)
      for (std::size_t x = 0; x < side_; ++x) {
        const std::size_t down = (y + side_ - texel / side_) % side_, right = (x + side_ - texel % side_) % side_;
        sums_[y * side_ + x] += sign * gaussian_[down * side_ + right];
      }
  }
  std::size_t tightest_cluster() const {
    return best([&](std::size_t a, std::size_t b) { return has_[a] && (!has_[b] || sums_[a] > sums_[b]); });
  }
  /// Returns the empty texel with the smallest sum. On a torus, the Gaussians of all texels have a constant sum, so the
  /// texel with the fewest points around it also has the most empty texels around it. This search therefore also
  /// implements Ulichney's phase 3.
  std::size_t largest_void() const {
    return best([&](std::size_t a, std::size_t b) { return !has_[a] && (has_[b] || sums_[a] < sums_[b]); });
  }

 private:
  template <typename Better>
  std::size_t best(Better better) const {
    std::size_t found = 0;
    for (std::size_t i = 1; i < has_.size(); ++i)
      if (better(i, found)) found = i;
    return found;
  }

  std::size_t side_;
  std::vector<bool> has_;
  std::vector<double> sums_, gaussian_;
};

}  // namespace

std::vector<int> void_and_cluster(int side, std::uint32_t seed) {
  MULTUM_CHECK(side >= 8 && side <= 256);
  const auto count = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  Pattern pattern(static_cast<std::size_t>(side));
  std::mt19937 random(seed);
  std::size_t first_count = 0;
  while (first_count < count / kFirstShare) {
    const std::size_t texel = random() % count;
    if (pattern.has(texel)) continue;
    pattern.set(texel, true);
    ++first_count;
  }
  // Moves points from clusters to voids until a point returns to its place.
  for (std::size_t step = 0; step < count; ++step) {
    const std::size_t cluster = pattern.tightest_cluster();
    pattern.set(cluster, false);
    const std::size_t place = pattern.largest_void();
    pattern.set(place, true);
    if (place == cluster) break;
  }
  std::vector<int> ranks(count);
  Pattern rest = pattern;
  for (std::size_t rank = first_count; rank-- > 0;) {
    const std::size_t texel = rest.tightest_cluster();
    rest.set(texel, false);
    ranks[texel] = static_cast<int>(rank);
  }
  for (std::size_t rank = first_count; rank < count; ++rank) {
    const std::size_t texel = pattern.largest_void();
    pattern.set(texel, true);
    ranks[texel] = static_cast<int>(rank);
  }
  return ranks;
}

}  // namespace multum
