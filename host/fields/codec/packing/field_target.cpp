// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/packing/field_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr int kRoundsMax = 12;
constexpr double kNearEnough = 0.985;  // share of the target that is near enough
constexpr double kLambdaMin = FieldCoder::kLambdaMin, kLambdaMax = FieldCoder::kLambdaMax;
// log(bytes) and log(error) are nearly linear in log(lambda). The slopes were measured on a field of 64 samples.
constexpr double kBytesSlope = -0.56, kErrorSlope = 0.6;
/// The added error must stay below 3 times the inferred textures' error. The limit for the estimated error is only 2
/// times that error, because the estimate can be too low for two reasons, by up to 20 % each, and 2 * 1.2 * 1.2 < 3.
/// First, the estimated coding error is 2 to 20 % below the error in drawn frames. This difference is larger for fields
/// with fewer samples. Second, the estimate uses gamma 2.2, but the inferred textures' error uses sRGB units, which
/// give dark pixels more weight. The error of a room with a dark quarter is 19 % higher in sRGB units.
constexpr double kEstimateShare = 2.0 / 3.0;
/// The least error that `--mse-max` accepts. Exact textures can be packed without any error only by chance.
constexpr double kErrorLimitMin = 1e-3;

/// Searches for the largest file within a byte limit, or the smallest file within an error limit.
struct SearchGoal {
  double limit = 0.0;
  bool is_error = false;

  /// Returns the logarithm of value / limit. If the result is above 0, the goal is not met.
  double excess(const FieldRound& round) const {
    const double value = is_error ? round.mse : static_cast<double>(round.file.size());
    return std::log(std::max(value, 1e-12) / limit);
  }
};

struct SearchResult {
  FieldRound round;  // the best round that meets the goal, or else the round nearest to it
  bool is_met = false;
};

SearchResult search(const SearchGoal& goal, double lambda, FieldCoder& coder) {
  const double slope = goal.is_error ? kErrorSlope : kBytesSlope, aim = 0.5 * std::log(kNearEnough);
  SearchResult best;
  double best_excess = 0.0;
  struct Side {
    double x = 0.0, excess = 0.0;
    bool is_there = false;
  } met, missed;  // the nearest rounds that met and missed the goal
  double x = std::log(lambda);
  for (int i = 0; i < kRoundsMax; ++i) {
    FieldRound round = coder.code(std::exp(x));
    const double excess = goal.excess(round);
    const bool is_met = excess <= 0.0;
    (is_met ? met : missed) = {x, excess, true};
    // Keeps the nearest round that meets the goal, or else the round with the least excess.
    if (i == 0 || (is_met && (!best.is_met || excess > best_excess)) ||
        (!is_met && !best.is_met && excess < best_excess)) {
      best = {std::move(round), is_met};
      best_excess = excess;
    }
    if (is_met && excess >= 2.0 * aim) break;
    const double edge = std::log((!is_met == goal.is_error) ? kLambdaMin : kLambdaMax);
    if (!(met.is_there && missed.is_there) && x == edge) break;
    double next = x + (aim - excess) / slope;
    if (met.is_there && missed.is_there) {
      const double share = std::clamp((aim - met.excess) / (missed.excess - met.excess), 0.1, 0.9);
      next = met.x + share * (missed.x - met.x);
      if (std::abs(met.x - missed.x) < 1e-3) break;
    }
    x = std::clamp(next, std::log(kLambdaMin), std::log(kLambdaMax));
  }
  return best;
}

FieldRound found_by_error(double mse, double lambda, FieldCoder& coder) {
  SearchResult found = search({mse, true}, lambda, coder);
  if (!found.is_met)
    throw Error(
        ErrorCode::kUsage,
        fmt::format("an error of {:g} cannot be reached: the lowest error found is {:.4g}; use a larger --mse-max", mse,
                    found.round.mse));
  return std::move(found.round);
}

/// If `bytes` was computed from a ratio, `ratio` is this ratio.
FieldRound found_by_bytes(double bytes, std::optional<double> ratio, double raw_bytes, double lambda,
                          FieldCoder& coder) {
  SearchResult found = search({bytes, false}, lambda, coder);
  if (found.is_met) return std::move(found.round);
  const auto least = static_cast<double>(found.round.file.size());
  if (ratio)
    throw Error(ErrorCode::kUsage, fmt::format("a ratio of {:g} ({:.0f} bytes) cannot be reached: the smallest file "
                                               "found has {:.0f} bytes; use --ratio {:.0f} or less, or --mse-max",
                                               *ratio, bytes, least, std::max(1.0, std::floor(raw_bytes / least))));
  throw Error(ErrorCode::kUsage, fmt::format("{:.0f} bytes cannot be reached: the smallest file found has {:.0f} "
                                             "bytes; use --bytes {:.0f} or more, or --mse-max",
                                             bytes, least, least));
}

/// Uses the default ratio unless its error is too large. Searches first for the limit that is more likely to decide,
/// because the other search is then usually unnecessary.
FieldRound found_by_default(double bytes, double mse, double lambda, FieldCoder& coder) {
  const SearchGoal size{bytes, false}, error{mse, true};
  const FieldRound first = coder.code(lambda);  // a search that starts at this lambda reuses the round
  std::optional<FieldRound> by_error;
  if (error.excess(first) / kErrorSlope > size.excess(first) / kBytesSlope) {
    by_error = search(error, lambda, coder).round;
    if (size.excess(*by_error) >= std::log(kNearEnough)) return std::move(*by_error);
    lambda = by_error->lambda;
  }
  SearchResult by_size = search(size, lambda, coder);
  if (by_size.is_met && error.excess(by_size.round) <= 0.0) return std::move(by_size.round);
  return by_error ? std::move(*by_error) : search(error, by_size.round.lambda, coder).round;
}

}  // namespace

double error_limit(double inferred_mse) {
  return std::max(kErrorLimitMin, kEstimateShare * kAddedErrorMax * inferred_mse);
}

FieldRound coded_for(const FieldTarget& target, const FieldMeasure& measure, double lambda, FieldCoder& coder) {
  if (target.lambda) return coder.code(*target.lambda);
  if (target.mse) return found_by_error(*target.mse, lambda, coder);
  if (target.bytes) return found_by_bytes(*target.bytes, {}, measure.raw_bytes, lambda, coder);
  const double ratio = target.ratio.value_or(kDefaultRatio), bytes = measure.raw_bytes / ratio;
  if (target.ratio || !measure.mse_max) return found_by_bytes(bytes, ratio, measure.raw_bytes, lambda, coder);
  return found_by_default(bytes, *measure.mse_max, lambda, coder);
}

}  // namespace multum
