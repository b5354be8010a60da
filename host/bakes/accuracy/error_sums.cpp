// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/error_sums.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace multum {

ErrorSums::ErrorSums(const AccuracyPoints& points, std::size_t brdf_count)
    : points_(points),
      brdf_count_(brdf_count),
      totals_(points.texels().sizes().size() * kAccuracyPointKinds * brdf_count),
      counts_(points.texels().sizes().size() * kAccuracyPointKinds),
      chosen_(points.chosen_count() * kAccuracyPointKinds * brdf_count) {}

void ErrorSums::count(const SamplePoint& point) {
  const AccuracySample& sample = points_.samples()[point.sample];
  ++counts_[group(sample.level, point.kind)];
}

void ErrorSums::add(const SamplePoint& point, std::size_t brdf, const ErrorSum& sum) {
  const AccuracySample& sample = points_.samples()[point.sample];
  totals_[group(sample.level, point.kind) * brdf_count_ + brdf] += sum.times(sample.cell_texels);
  if (point.sample < points_.chosen_count()) chosen_[chosen_index(point.sample, point.kind, brdf)] += sum;
}

AccuracyRow ErrorSums::row(int level, AccuracyPoint kind, std::size_t brdf, AccuracyBrdf what) const {
  AccuracyRow row{level, kind, std::move(what), 0.0, 0.0, counts_[group(level, kind)]};
  const ErrorSum& total = totals_[group(level, kind) * brdf_count_ + brdf];
  if (!(total.count > 0.0)) return row;
  const ErrorBase base(total);
  row.error = total.difference / base.of(total);
  if (!is_sampled(level)) return row;
  const double variance = total_variance(level, [&](std::size_t sample) {
    const ErrorSum& sum = chosen_[chosen_index(sample, kind, brdf)];
    return sum.difference - row.error * base.of(sum);
  });
  row.confidence = std::max(kIntervalMin, 1.96 * std::sqrt(variance) / base.of(total));
  return row;
}

bool ErrorSums::is_sampled(int level) const {
  return points_.chosen_count() > 0 && level <= points_.samples()[points_.chosen_count() - 1].level;
}

template <typename Residual>
double ErrorSums::total_variance(int level, const Residual& residual) const {
  double sum = 0.0, n = 0.0;
  const auto for_each_sample = [&](const auto& body) {
    for (std::size_t i = 0; i < points_.chosen_count(); ++i) {
      const AccuracySample& sample = points_.samples()[i];
      if (sample.level == level) body(static_cast<double>(sample.cell_texels), residual(i));
    }
  };
  for_each_sample([&](double weight, double value) {
    sum += weight * value;
    n += 1.0;
  });
  double squares = 0.0;
  for_each_sample([&](double weight, double value) {
    const double off = weight * value - sum / n;
    squares += (1.0 - 1.0 / weight) * off * off;
  });
  return squares * n / (n - 1.0);  // AccuracyPoints takes at least two samples per sampled level
}

std::size_t ErrorSums::group(int level, AccuracyPoint kind) const {
  return static_cast<std::size_t>(level) * kAccuracyPointKinds + static_cast<std::size_t>(kind);
}

std::size_t ErrorSums::chosen_index(std::size_t sample, AccuracyPoint kind, std::size_t brdf) const {
  return (sample * kAccuracyPointKinds + static_cast<std::size_t>(kind)) * brdf_count_ + brdf;
}

}  // namespace multum
