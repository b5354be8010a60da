// SPDX-License-Identifier: Apache-2.0
#include "host/codec/allocation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "host/base/error.h"

namespace multum {
namespace {

/// The point where error + slope bytes is least; of equal ones the cheapest.
std::size_t point_at(const RateCurve& curve, double slope) {
  MULTUM_CHECK(!curve.points.empty());
  const auto cost = [slope](const RatePoint& point) { return point.error + slope * point.bytes; };
  return static_cast<std::size_t>(std::min_element(curve.points.begin(), curve.points.end(),
                                                   [&](const RatePoint& a, const RatePoint& b) {
                                                     return cost(a) != cost(b) ? cost(a) < cost(b) : a.bytes < b.bytes;
                                                   }) -
                                  curve.points.begin());
}

/// `slopes`: of each object, or one for all.
Allocation at_slopes(const std::vector<RateCurve>& curves, const std::function<double(std::size_t)>& slope_of) {
  Allocation allocation;
  for (const RateCurve& curve : curves) {
    const std::size_t point = point_at(curve, slope_of(curve.object));
    allocation.points.push_back(point);
    allocation.bytes += curve.points[point].bytes;
    allocation.error += curve.points[point].error;
  }
  return allocation;
}

/// Slopes between any two points of any curve: between two of them, no choice changes.
std::vector<double> slopes_of(const std::vector<RateCurve>& curves) {
  std::vector<double> slopes;
  for (const RateCurve& curve : curves)
    for (const RatePoint& a : curve.points)
      for (const RatePoint& b : curve.points)
        if (b.bytes > a.bytes && b.error < a.error) slopes.push_back((a.error - b.error) / (b.bytes - a.bytes));
  std::sort(slopes.begin(), slopes.end());
  slopes.erase(std::unique(slopes.begin(), slopes.end()), slopes.end());
  return slopes;
}

/// Middles between neighbouring slopes, and one beyond each end: every allocation of equal slopes, dearest first.
std::vector<double> slopes_to_try(const std::vector<RateCurve>& curves) {
  const auto slopes = slopes_of(curves);
  std::vector<double> middles = {0.0};
  for (std::size_t i = 0; i + 1 < slopes.size(); ++i) middles.push_back((slopes[i] + slopes[i + 1]) / 2.0);
  if (!slopes.empty()) middles.push_back(2.0 * slopes.back());
  return middles;
}

/// Takes better points while they fit, those first that take away the most error a byte: a slope's steps are coarse.
void spend_rest(const std::vector<RateCurve>& curves, double bytes, Allocation& allocation) {
  for (;;) {
    double best = 0.0;
    std::size_t best_curve = 0, best_point = 0;
    for (std::size_t k = 0; k < curves.size(); ++k) {
      const RatePoint& now = curves[k].points[allocation.points[k]];
      for (std::size_t p = 0; p < curves[k].points.size(); ++p) {
        const RatePoint& other = curves[k].points[p];
        if (other.error >= now.error || allocation.bytes - now.bytes + other.bytes > bytes) continue;
        const double more = other.bytes - now.bytes;
        const double gain = more > 0.0 ? (now.error - other.error) / more : std::numeric_limits<double>::max();
        if (gain <= best) continue;
        best = gain;
        best_curve = k;
        best_point = p;
      }
    }
    if (best == 0.0) return;
    const RatePoint& now = curves[best_curve].points[allocation.points[best_curve]];
    const RatePoint& other = curves[best_curve].points[best_point];
    allocation.bytes += other.bytes - now.bytes;
    allocation.error += other.error - now.error;
    allocation.points[best_curve] = best_point;
  }
}

/// The first of rising slopes at which `holds` is true, where it stays so; the last where it never is.
double first_slope(const std::vector<double>& slopes, const std::function<bool(double)>& holds) {
  const auto found = std::partition_point(slopes.begin(), slopes.end(), [&](double slope) { return !holds(slope); });
  return found == slopes.end() ? slopes.back() : *found;
}

Allocation within_bytes(const std::vector<RateCurve>& curves, double bytes,
                        const std::function<double(std::size_t, double)>& slope_of) {
  const double slope = first_slope(slopes_to_try(curves), [&](double tried) {
    return at_slopes(curves, [&](std::size_t object) { return slope_of(object, tried); }).bytes <= bytes;
  });
  Allocation allocation = at_slopes(curves, [&](std::size_t object) { return slope_of(object, slope); });
  allocation.is_met = allocation.bytes <= bytes;
  if (allocation.is_met) spend_rest(curves, bytes, allocation);
  return allocation;
}

}  // namespace

Allocation allocate_bytes(const std::vector<RateCurve>& curves, double bytes) {
  return within_bytes(curves, bytes, [](std::size_t, double slope) { return slope; });
}

Allocation allocate_error(const std::vector<RateCurve>& curves, double error) {
  auto slopes = slopes_to_try(curves);
  const auto at = [&](double slope) { return at_slopes(curves, [slope](std::size_t) { return slope; }); };
  std::reverse(slopes.begin(), slopes.end());
  Allocation allocation = at(first_slope(slopes, [&](double slope) { return at(slope).error <= error; }));
  allocation.is_met = allocation.error <= error;
  return allocation;
}

Allocation allocate_bytes_evenly(const std::vector<RateCurve>& curves, const std::vector<double>& pixels, double bytes,
                                 double alpha) {
  MULTUM_CHECK(alpha > 1.0);
  double all_pixels = 0.0;
  for (const double count : pixels) all_pixels += count;
  const double mean = allocate_bytes(curves, bytes).error / all_pixels;
  const auto slopes = slopes_to_try(curves);
  // The steepest common slope at which the object's curves leave at most alpha times the mean: it is not taken less
  // steep than that.
  std::vector<double> held(pixels.size(), std::numeric_limits<double>::max());
  bool is_met = true;
  for (std::size_t object = 0; object < pixels.size(); ++object) {
    const auto error_at = [&](double slope) {
      double error = 0.0;
      for (const RateCurve& curve : curves)
        if (curve.object == object) error += curve.points[point_at(curve, slope)].error;
      return error / pixels[object];
    };
    const auto above = std::partition_point(slopes.begin(), slopes.end(),
                                            [&](double slope) { return error_at(slope) <= alpha * mean; });
    if (above == slopes.end()) continue;
    held[object] = above == slopes.begin() ? slopes.front() : *(above - 1);
    is_met &= above != slopes.begin();
  }
  Allocation allocation =
      within_bytes(curves, bytes, [&](std::size_t object, double slope) { return std::min(slope, held[object]); });
  allocation.is_met &= is_met;
  return allocation;
}

}  // namespace multum
