// SPDX-License-Identifier: Apache-2.0
// The error that a bake states of itself: how far pixels of pictures are from what they should show, over the
// footprints of host/bakes/accuracy/footprints.h (docs/contributing/ALGORITHMS.md, "Measured error").
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy_brdf.h"
#include "host/bakes/accuracy/footprints.h"

namespace multum {

/// Differences |model - reference| and references, summed over the directions and colour channels of one footprint or
/// point, or of many.
struct ErrorSum {
  double difference = 0.0;
  double reference = 0.0;
  double count = 0.0;  // of values
  void operator+=(const ErrorSum& other) {
    difference += other.difference;
    reference += other.reference;
    count += other.count;
  }
  ErrorSum times(double weight) const { return {weight * difference, weight * reference, weight * count}; }
};

/// What differences are in parts of: the reference, or where that is next to nothing, since no light and no eye is
/// where the highlight is, a hundredth of what a white diffuse surface reflects, 1/pi. In parts of 1e-40 nothing says
/// anything.
class ErrorBase {
 public:
  explicit ErrorBase(const ErrorSum& all) : is_floor_(all.reference < kFloor * all.count) {}
  double of(const ErrorSum& sum) const { return is_floor_ ? kFloor * sum.count : sum.reference; }

 private:
  static constexpr double kFloor = 0.01 / 3.14159265358979323846;
  const bool is_floor_;
};

/// Relative L1 of one BRDF: 0.1 = 10 %.
struct FootprintError {
  AccuracyBrdf brdf;
  double error = 0.0;  // sum of |model - reference| over the sum of the reference, octaves weighing alike
  // Half width of the 95 % interval: 1.96 standard errors of the combined ratio estimate, the strata being the octaves
  // (Cochran 1977, section 6.11). A footprint is one draw, with all its directions and channels.
  double confidence = 0.0;
  double percentile_95 = 0.0;  // of the errors of single footprints
  int worst_octave = 0;        // k: footprints whose shorter side is 2^k to 2^(k+1) texels
  double worst_octave_error = 0.0;
  std::int64_t sample_count = 0;  // footprints
};

/// `sums` of each footprint, `footprints` as choose_footprints() gives them.
FootprintError footprint_error(AccuracyBrdf brdf, const std::vector<Footprint>& footprints,
                               const std::vector<ErrorSum>& sums);

/// "1 to 2 texels", "16 to 32 texels": of octave k.
std::string octave_text(int octave);

}  // namespace multum
