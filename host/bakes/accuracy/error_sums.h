// SPDX-License-Identifier: Apache-2.0
// Adds up errors over sampled texels, and states their confidence intervals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/accuracy/accuracy_points.h"
#include "host/bakes/accuracy/footprint_error.h"

namespace multum {

/// Adds up the errors of each level, kind of point and BRDF. Each sample represents all texels of its cell. For sampled
/// levels, the errors of each point are also kept, because the confidence interval follows from their spread.
///
/// The error of a level is R = sum_i w_i d_i / sum_i w_i t_i. For the sample of cell i, d_i is the difference, t_i is
/// the reference, and w_i is the number of texels in the cell. Both sums are Horvitz-Thompson estimates (Cochran 1977,
/// section 9A.7). With e_i = d_i - R t_i, the variance of R is the variance of sum_i w_i e_i, divided by the squared
/// sum of the reference (the delta method, Cochran section 6.4). For a texel without a point of this kind, e_i is 0
/// (section 5A.14).
///
///   v = n / (n - 1) sum_i (1 - 1 / w_i) (w_i e_i - mean)^2
///
/// (1 - 1 / w_i) is the finite population correction of a cell. A single sample per cell gives no variance within the
/// cell, so the spread among all cells is used instead. The spread among all cells is larger if neighbours are similar
/// (section 5A.12).
class ErrorSums {
 public:
  ErrorSums(const AccuracyPoints& points, std::size_t brdf_count);

  void count(const SamplePoint& point);
  void add(const SamplePoint& point, std::size_t brdf, const ErrorSum& sum);
  /// Returns the ratio of sums and the half width of its 95 % interval.
  AccuracyRow row(int level, AccuracyPoint kind, std::size_t brdf, AccuracyBrdf what) const;

 private:
  bool is_sampled(int level) const;

  // Returns the variance v (see above) of the sum of residual(sample) over all texels of a sampled level.
  template <typename Residual>
  double total_variance(int level, const Residual& residual) const;

  std::size_t group(int level, AccuracyPoint kind) const;
  std::size_t chosen_index(std::size_t sample, AccuracyPoint kind, std::size_t brdf) const;

  const AccuracyPoints& points_;
  std::size_t brdf_count_;
  std::vector<ErrorSum> totals_;      // [level][kind][brdf]
  std::vector<std::int64_t> counts_;  // [level][kind]
  std::vector<ErrorSum> chosen_;      // [sample][kind][brdf]
};

}  // namespace multum
