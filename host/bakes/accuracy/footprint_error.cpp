// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/footprint_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

// Returns the variance of the sum of e over n independent draws, where e = |model - reference| - R reference. The
// variance is n / (n - 1) times the sum over footprints of the squared deviations of e from its mean.
double residual_variance(const std::vector<ErrorSum>& sums, const ErrorBase& base, double error) {
  const auto n = static_cast<double>(sums.size());
  if (n < 2.0) return 0.0;
  const auto residual = [&](const ErrorSum& sum) { return sum.difference - error * base.of(sum); };
  double mean = 0.0, squares = 0.0;
  for (const ErrorSum& sum : sums) mean += residual(sum) / n;
  for (const ErrorSum& sum : sums) squares += std::pow(residual(sum) - mean, 2.0);
  return squares * n / (n - 1.0);
}

}  // namespace

namespace {

// Returns the number of footprints of each octave.
std::map<int, double> octave_counts(const std::vector<Footprint>& footprints) {
  std::map<int, double> counts;
  for (const Footprint& one : footprints) counts[one.octave] += 1.0;
  return counts;
}

struct WeightedError {
  double error, weight;
};

// Returns the smallest error such that the errors up to it have 95 % of the weight.
double percentile_95(std::vector<WeightedError> errors) {
  std::sort(errors.begin(), errors.end(), [](const auto& a, const auto& b) { return a.error < b.error; });
  double total = 0.0, weight = 0.0;
  for (const WeightedError& one : errors) total += one.weight;
  for (const WeightedError& one : errors)
    if ((weight += one.weight) >= 0.95 * total) return one.error;
  return errors.back().error;
}

}  // namespace

FootprintError footprint_error(AccuracyBrdf brdf, const std::vector<Footprint>& footprints,
                               const std::vector<ErrorSum>& sums) {
  MULTUM_CHECK(footprints.size() == sums.size());
  FootprintError result;
  result.brdf = std::move(brdf);
  result.sample_count = static_cast<std::int64_t>(sums.size());
  // Octaves have equal weights, so the footprints of an octave with fewer of them weigh more.
  const std::map<int, double> counts = octave_counts(footprints);
  double largest = 0.0;
  for (const auto& [octave, count] : counts) largest = std::max(largest, count);
  ErrorSum all;
  std::map<int, std::vector<ErrorSum>> octaves;
  std::vector<WeightedError> errors;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double weight = largest / counts.at(footprints[i].octave);
    octaves[footprints[i].octave].push_back(sums[i].times(weight));
    errors.push_back({sums[i].difference / ErrorBase(sums[i]).of(sums[i]), weight});
    all += octaves[footprints[i].octave].back();
  }
  if (!(all.count > 0.0)) return result;
  const ErrorBase base(all);
  result.error = all.difference / base.of(all);
  double variance = 0.0;
  result.worst_octave_error = -1.0;
  for (const auto& [octave, of_octave] : octaves) {
    variance += residual_variance(of_octave, base, result.error);
    ErrorSum sum;
    for (const ErrorSum& one : of_octave) sum += one;
    const double octave_error = sum.difference / ErrorBase(sum).of(sum);
    if (!(octave_error > result.worst_octave_error)) continue;
    result.worst_octave = octave;
    result.worst_octave_error = octave_error;
  }
  result.confidence = 1.96 * std::sqrt(variance) / base.of(all);
  result.percentile_95 = percentile_95(std::move(errors));
  return result;
}

std::string octave_text(int octave) { return fmt::format("{} to {} texels", 1LL << octave, 2LL << octave); }

}  // namespace multum
