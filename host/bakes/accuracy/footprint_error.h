// SPDX-License-Identifier: Apache-2.0
// Computes the error that a bake states: the difference between rendered pixels and their reference, summed over the
// footprints of host/bakes/accuracy/footprints.h (docs/contributing/ALGORITHMS.md, "Measured error").
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy_brdf.h"
#include "host/bakes/accuracy/footprints.h"

namespace multum {

/// Sums of |model - reference| and of the reference, over the directions and colour channels of one or more footprints
/// or points.
struct ErrorSum {
  double difference = 0.0;
  double reference = 0.0;
  double count = 0.0;  // number of values
  void operator+=(const ErrorSum& other) {
    difference += other.difference;
    reference += other.reference;
    count += other.count;
  }
  ErrorSum times(double weight) const { return {weight * difference, weight * reference, weight * count}; }
};

/// The denominator of relative errors is the reference, but at least 1 % of 1/pi, the value that a white diffuse
/// surface reflects. If no light or view is near the highlight, the reference is almost 0, and errors relative to such
/// a value have no meaning.
class ErrorBase {
 public:
  explicit ErrorBase(const ErrorSum& all) : is_floor_(all.reference < kFloor * all.count) {}
  double of(const ErrorSum& sum) const { return is_floor_ ? kFloor * sum.count : sum.reference; }

 private:
  static constexpr double kFloor = 0.01 / 3.14159265358979323846;
  const bool is_floor_;
};

/// Relative L1 error of one BRDF (0.1 is 10 %).
struct FootprintError {
  AccuracyBrdf brdf;
  double error = 0.0;  // sum of |model - reference| / sum of the reference, with equal weights for octaves
  // Half width of the 95 % interval: 1.96 standard errors of the combined ratio estimate, with octaves as strata
  // (Cochran 1977, section 6.11). Each footprint, with all its directions and channels, counts as one draw.
  double confidence = 0.0;
  double percentile_95 = 0.0;  // 95th percentile of the errors of single footprints
  int worst_octave = 0;        // octave k of footprints whose shorter side is 2^k to 2^(k+1) texels
  double worst_octave_error = 0.0;
  std::int64_t sample_count = 0;  // number of footprints
};

/// `sums` has one entry per footprint. The order of `footprints` is that of choose_footprints().
FootprintError footprint_error(AccuracyBrdf brdf, const std::vector<Footprint>& footprints,
                               const std::vector<ErrorSum>& sums);

/// Formats the sizes of octave k, as in "1 to 2 texels" or "16 to 32 texels".
std::string octave_text(int octave);

}  // namespace multum
