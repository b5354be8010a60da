// SPDX-License-Identifier: Apache-2.0
// Statistics of a normal map. The sharp one is the agreement of gradients: the slopes p = dh/dx = -x/z and q = dh/dy =
// -y/z of any surface satisfy dp/dy = dq/dx, so over a map with green up the two correlate at +1, with green down (q
// has the wrong sign) at -1, and over colours not at all. It is taken at 1, 2 and 4 texels (2 x 2 means), because lossy
// compression destroys it at 1, and averaged. Measured on 36 real normal maps: 29 lie beyond +-0.31, the others (random
// facets, hard edges, lossy or hand-painted) within 0.15; 19 colour images lie within 0.14, all but one within 0.09.
// (Frankot & Chellappa 1988, "A method for enforcing integrability", states the condition.)
#include "host/image/vector_statistics.h"
#include "host/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace multum {
namespace {

// A band is 64 rows: 16 rows at 4 texels, of which the inner 14 have derivatives.
constexpr int kStatisticsRows = 64;
constexpr int kStatisticsColumns = 1 << 18;  // of a very wide image, so that a band stays below 400 MB
constexpr int kScaleCount = 3;
// Slopes beyond 3 (72 degrees) are mostly compression noise of a small z, and would outweigh all others in a
// correlation.
constexpr double kSlopeMax = 3.0;

struct CorrelationSums {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void add(double x, double y) { n += 1, a += x, b += y, aa += x * x, bb += y * y, ab += x * y; }
  void add(const CorrelationSums& o) { n += o.n, a += o.a, b += o.b, aa += o.aa, bb += o.bb, ab += o.ab; }
  // 0 when either side is constant.
  double correlation() const {
    if (n < 2) return 0.0;
    const double variance_a = aa / n - (a / n) * (a / n);
    const double variance_b = bb / n - (b / n) * (b / n);
    if (variance_a < 1e-12 || variance_b < 1e-12) return 0.0;
    return (ab / n - (a / n) * (b / n)) / std::sqrt(variance_a * variance_b);
  }
};

struct BandSums {
  double n = 0, unit_5 = 0, unit_10 = 0, unit_20 = 0, below = 0, beyond = 0, tilted = 0, negative = 0;
  double x = 0, y = 0, z = 0, rebuilt_z = 0;
  double blue_min = 1e30, blue_max = -1e30;
  CorrelationSums z_and_rebuilt;
  std::array<CorrelationSums, kScaleCount> gradients;

  void add_vector(const glm::dvec3& v) {
    const double xy2 = v.x * v.x + v.y * v.y;
    const double deviation = std::abs(std::sqrt(xy2 + v.z * v.z) - 1.0);
    const double z_of_unit = std::sqrt(std::max(0.0, 1.0 - xy2));
    n += 1;
    unit_5 += deviation <= 0.05 ? 1 : 0;
    unit_10 += deviation <= 0.10 ? 1 : 0;
    unit_20 += deviation <= 0.20 ? 1 : 0;
    below += v.z < 0.0 ? 1 : 0;
    beyond += xy2 > 1.04 ? 1 : 0;
    tilted += std::max(std::abs(v.x), std::abs(v.y)) > 0.02 ? 1 : 0;
    negative += std::min(v.x, v.y) < -0.02 ? 1 : 0;
    x += v.x, y += v.y, z += v.z, rebuilt_z += z_of_unit;
    z_and_rebuilt.add(v.z, z_of_unit);
  }
  void add(const BandSums& o) {
    n += o.n, unit_5 += o.unit_5, unit_10 += o.unit_10, unit_20 += o.unit_20, below += o.below, beyond += o.beyond;
    tilted += o.tilted, negative += o.negative;
    x += o.x, y += o.y, z += o.z, rebuilt_z += o.rebuilt_z;
    blue_min = std::min(blue_min, o.blue_min), blue_max = std::max(blue_max, o.blue_max);
    z_and_rebuilt.add(o.z_and_rebuilt);
    for (std::size_t s = 0; s < gradients.size(); ++s) gradients[s].add(o.gradients[s]);
  }
};

struct VectorBand {
  int width;
  int height;
  std::vector<glm::dvec3> vectors;
  const glm::dvec3& at(int column, int row) const {
    return vectors[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
  }
};

// Decodes the rows and sums what concerns single texels. Texels without a vector are flat for the gradients.
VectorBand decode_band(const RawImage& image, const VectorEncoding& encoding, int row_begin, int row_end,
                       BandSums& sums) {
  VectorBand band{std::min(image.width, kStatisticsColumns), row_end - row_begin, {}};
  band.vectors.reserve(static_cast<std::size_t>(band.height) * static_cast<std::size_t>(band.width));
  for (int row = row_begin; row < row_end; ++row) {
    for (int column = 0; column < band.width; ++column) {
      const std::size_t i =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(column);
      const float r = image.planes[0][i];
      const float g = image.planes[1][i];
      const float b = image.planes.size() > 2 ? image.planes[2][i] : 0.0f;
      glm::dvec3 v(0.0, 0.0, 1.0);
      if (std::isfinite(r) && std::isfinite(g) && std::isfinite(b) && !is_unused(encoding, r, g, b)) {
        v = decode_vector(encoding, r, g, b);
        sums.add_vector(v);
        sums.blue_min = std::min(sums.blue_min, static_cast<double>(b));
        sums.blue_max = std::max(sums.blue_max, static_cast<double>(b));
      }
      band.vectors.push_back(v);
    }
  }
  return band;
}

VectorBand halved(const VectorBand& band) {
  VectorBand half{band.width / 2, band.height / 2, {}};
  half.vectors.reserve(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height));
  for (int row = 0; row < half.height; ++row)
    for (int column = 0; column < half.width; ++column)
      half.vectors.push_back(0.25 * (band.at(2 * column, 2 * row) + band.at(2 * column + 1, 2 * row) +
                                     band.at(2 * column, 2 * row + 1) + band.at(2 * column + 1, 2 * row + 1)));
  return half;
}

double slope(double side, double z) { return std::clamp(-side / std::max(z, 1e-3), -kSlopeMax, kSlopeMax); }

void add_gradients(const VectorBand& band, CorrelationSums& sums) {
  for (int row = 1; row + 1 < band.height; ++row) {
    for (int column = 1; column + 1 < band.width; ++column) {
      const glm::dvec3& up = band.at(column, row - 1);
      const glm::dvec3& down = band.at(column, row + 1);
      const glm::dvec3& left = band.at(column - 1, row);
      const glm::dvec3& right = band.at(column + 1, row);
      sums.add(slope(up.x, up.z) - slope(down.x, down.z), slope(right.y, right.z) - slope(left.y, left.z));
    }
  }
}

BandSums sum_bands(const RawImage& image, const VectorEncoding& encoding, int threads) {
  constexpr std::int64_t kTexelsMax = std::int64_t{1} << 24;
  const int band_count = row_band_count(image.height, kStatisticsRows);
  const auto stride = static_cast<int>(1 + (std::int64_t{image.width} * image.height - 1) / kTexelsMax);
  std::vector<BandSums> bands(static_cast<std::size_t>(band_count));
  for_each_row_band(image.height, kStatisticsRows, threads, [&](int band, int row_begin, int row_end) {
    if (band % stride != 0) return;
    BandSums& sums = bands[static_cast<std::size_t>(band)];
    VectorBand vectors = decode_band(image, encoding, row_begin, row_end, sums);
    for (CorrelationSums& scale : sums.gradients) {
      add_gradients(vectors, scale);
      vectors = halved(vectors);
    }
  });
  BandSums total;
  for (const BandSums& band : bands) total.add(band);
  return total;
}

}  // namespace

VectorStatistics vector_statistics(const RawImage& image, const VectorEncoding& encoding, int threads) {
  const BandSums sums = sum_bands(image, encoding, threads);
  VectorStatistics result;
  result.texel_count = sums.n;
  if (sums.n == 0.0) return result;
  result.unit_share_5 = sums.unit_5 / sums.n;
  result.unit_share_10 = sums.unit_10 / sums.n;
  result.unit_share_20 = sums.unit_20 / sums.n;
  result.below_share = sums.below / sums.n;
  result.beyond_share = sums.beyond / sums.n;
  result.tilted_share = sums.tilted / sums.n;
  result.negative_share = sums.negative / sums.n;
  result.mean_x = sums.x / sums.n;
  result.mean_y = sums.y / sums.n;
  result.mean_z = sums.z / sums.n;
  result.rebuilt_z_mean = sums.rebuilt_z / sums.n;
  result.rebuilt_z_correlation = sums.z_and_rebuilt.correlation();
  result.blue_min = sums.blue_min;
  result.blue_max = sums.blue_max;
  // A scale with fewer samples than this says nothing: the correlation of 64 random pairs is 0.125 from 0 by chance.
  constexpr double kSamplesMin = 64;
  int scale_count = 0;
  for (const CorrelationSums& scale : sums.gradients) {
    if (scale.n < kSamplesMin) continue;
    result.gradient_agreement += scale.correlation();
    ++scale_count;
  }
  if (scale_count > 0) result.gradient_agreement /= scale_count;
  result.gradient_sample_count = sums.gradients[0].n;
  return result;
}

}  // namespace multum
