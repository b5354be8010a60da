// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/mip_coverage.h"

#include <algorithm>
#include <cstdint>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

struct AxisTap {
  int index;
  double weight;
};

// For each texel along an axis, returns the finest texels that it overlaps, with weights that sum to 1. The axis has
// `from` finest texels.
std::vector<std::vector<AxisTap>> axis_taps(std::int64_t from, std::int64_t to) {
  std::vector<std::vector<AxisTap>> taps(static_cast<std::size_t>(to));
  for (std::int64_t x = 0; x < to; ++x) {
    const std::int64_t begin = x * from, end = (x + 1) * from;  // in units of 1/to of a texel of the finest level
    for (std::int64_t i = begin / to; i * to < end; ++i) {
      const std::int64_t overlap = std::min((i + 1) * to, end) - std::max(i * to, begin);
      taps[static_cast<std::size_t>(x)].push_back(
          {static_cast<int>(i), static_cast<double>(overlap) / static_cast<double>(from)});
    }
  }
  return taps;
}

}  // namespace

std::vector<double> average_over_texels(const std::vector<double>& plane, PlaneSize from, PlaneSize to, int threads) {
  MULTUM_CHECK(to.width >= 1 && to.width <= from.width && to.height >= 1 && to.height <= from.height);
  const auto columns = axis_taps(from.width, to.width);
  const auto rows = axis_taps(from.height, to.height);
  const auto from_width = static_cast<std::size_t>(from.width), to_width = static_cast<std::size_t>(to.width);
  std::vector<double> result(to_width * static_cast<std::size_t>(to.height));
  for_each_item(to.height, threads, [&](int y) {
    std::vector<double> row(from_width, 0.0);
    for (const AxisTap& tap : rows[static_cast<std::size_t>(y)]) {
      const double* source = &plane[static_cast<std::size_t>(tap.index) * from_width];
      for (std::size_t x = 0; x < from_width; ++x) row[x] += tap.weight * source[x];
    }
    double* out = &result[static_cast<std::size_t>(y) * to_width];
    for (std::size_t x = 0; x < to_width; ++x) {
      double sum = 0.0;
      for (const AxisTap& tap : columns[x]) sum += tap.weight * row[static_cast<std::size_t>(tap.index)];
      out[x] = sum;
    }
  });
  return result;
}

}  // namespace multum
