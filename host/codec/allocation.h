// SPDX-License-Identifier: Apache-2.0
// Shares bytes out among what is coded (Hakura et al. 2000, section 4, "Automatic Storage Allocation"; Gersho and Gray
// 1992, pages 606 to 610): of each curve of error over bytes the point where its slope is the common one, the slope
// such that the total is met; no object's mean error above alpha times the mean of all.
#pragma once

#include <cstddef>
#include <vector>

namespace multum {

/// One way to code something.
struct RatePoint {
  double bytes = 0.0, error = 0.0;  // squared errors, summed; both at least 0
};

/// All ways to code one thing, at least one.
struct RateCurve {
  std::vector<RatePoint> points;
  std::size_t object = 0;  // that it belongs to
};

struct Allocation {
  std::vector<std::size_t> points;  // of each curve, the one taken
  double bytes = 0.0, error = 0.0;  // of all
  /// Even the cheapest points of all take more bytes, or the dearest leave more error, than asked for; or an object
  /// stays above alpha.
  bool is_met = true;
};

/// The least error that `bytes` buy.
Allocation allocate_bytes(const std::vector<RateCurve>& curves, double bytes);

/// The fewest bytes that leave at most `error`.
Allocation allocate_error(const std::vector<RateCurve>& curves, double error);

/// As allocate_bytes, with the error per pixel of each object held to `alpha`, above 1, times that of all objects
/// together. Two passes, as in the paper: points that would leave an object more than alpha times the mean of the first
/// pass are not taken in the second. `pixels`: of each object, above 0.
Allocation allocate_bytes_evenly(const std::vector<RateCurve>& curves, const std::vector<double>& pixels, double bytes,
                                 double alpha);

}  // namespace multum
