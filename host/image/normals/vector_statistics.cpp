// SPDX-License-Identifier: Apache-2.0
// Statistics of a normal map. The sharp one is the agreement of gradients: the slopes p = dh/dx = -x/z and q = dh/dy =
// -y/z of any surface satisfy dp/dy = dq/dx, so over a map with green up the two correlate at +1, with green down (q
// has the wrong sign) at -1, and over colours not at all. It is taken at 1, 2 and 4 texels (2 x 2 means), because lossy
// compression destroys it at 1, and averaged. Measured on 36 real normal maps: 29 lie beyond +-0.31, the others (random
// facets, hard edges, lossy or hand-painted) within 0.15; 19 colour images lie within 0.14, all but one within 0.09.
// (Frankot & Chellappa 1988, "A method for enforcing integrability", states the condition.)
#include "host/image/normals/vector_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/base/processes/parallel.h"

namespace multum {
namespace {

// A band is 64 rows: 16 rows at 4 texels, of which the inner 14 have derivatives.
constexpr int kStatisticsRows = 64;
constexpr int kStatisticsColumns = 1 << 18;  // of a very wide image, so that a row stays below 7 MB
constexpr int kScaleCount = 3;
// Slopes beyond 3 (72 degrees) are mostly compression noise of a small z, and would outweigh all others in a
// correlation.
constexpr double kSlopeCorrelatedMax = 3.0;

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
  double rebuilt_z_min = 1.0, side_max = 0.0;
  double log_length = 0, log_length_squares = 0;
  CorrelationSums z_and_rebuilt;
  std::array<CorrelationSums, kScaleCount> gradients;

  void add_vector(const glm::dvec3& v) {
    const double xy2 = v.x * v.x + v.y * v.y;
    const double length = std::sqrt(xy2 + v.z * v.z);
    const double deviation = std::abs(length - 1.0);
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
    rebuilt_z_min = std::min(rebuilt_z_min, z_of_unit);
    side_max = std::max({side_max, std::abs(v.x), std::abs(v.y)});
    const double log = std::log(std::max(length, 1e-30));
    log_length += log, log_length_squares += log * log;
  }
  void add(const BandSums& o) {
    n += o.n, unit_5 += o.unit_5, unit_10 += o.unit_10, unit_20 += o.unit_20, below += o.below, beyond += o.beyond;
    tilted += o.tilted, negative += o.negative;
    x += o.x, y += o.y, z += o.z, rebuilt_z += o.rebuilt_z;
    blue_min = std::min(blue_min, o.blue_min), blue_max = std::max(blue_max, o.blue_max);
    rebuilt_z_min = std::min(rebuilt_z_min, o.rebuilt_z_min), side_max = std::max(side_max, o.side_max);
    log_length += o.log_length, log_length_squares += o.log_length_squares;
    z_and_rebuilt.add(o.z_and_rebuilt);
    for (std::size_t s = 0; s < gradients.size(); ++s) gradients[s].add(o.gradients[s]);
  }
};

using VectorRow = std::vector<glm::dvec3>;

VectorRow halved(const VectorRow& upper, const VectorRow& lower) {
  VectorRow half(upper.size() / 2);
  for (std::size_t i = 0; i < half.size(); ++i)
    half[i] = 0.25 * (upper[2 * i] + upper[2 * i + 1] + lower[2 * i] + lower[2 * i + 1]);
  return half;
}

double slope(double side, double z) {
  return std::clamp(-side / std::max(z, 1e-3), -kSlopeCorrelatedMax, kSlopeCorrelatedMax);
}

void add_gradients(const VectorRow& above, const VectorRow& row, const VectorRow& below, CorrelationSums& sums) {
  for (std::size_t i = 1; i + 1 < row.size(); ++i)
    sums.add(slope(above[i].x, above[i].z) - slope(below[i].x, below[i].z),
             slope(row[i + 1].y, row[i + 1].z) - slope(row[i - 1].y, row[i - 1].z));
}

// One band: of each scale the last three rows are kept, and every pair of rows becomes one of the next scale.
//   scale 1   0 1 2 3 4 5 6 7
//   scale 2    0   1   2   3
//   scale 4      0       1
class StatisticsBand {
 public:
  StatisticsBand(const RawImageInfo& info, const VectorEncoding& encoding)
      : encoding_(encoding),
        column_count_(static_cast<std::size_t>(std::min(info.width, kStatisticsColumns))),
        channel_count_(static_cast<std::size_t>(info.channel_count)) {}

  void add_row(const float* values) { add_scaled_row(0, decoded(values)); }
  const BandSums& sums() const { return sums_; }

 private:
  struct Scale {
    std::size_t row_count = 0;
    std::array<VectorRow, 3> rows;  // row i is at i % 3
    const VectorRow& row_from_last(std::size_t back) const { return rows[(row_count - 1 - back) % 3]; }
  };

  // Sums what concerns single texels. Texels without a vector are flat for the gradients.
  VectorRow decoded(const float* values) {
    VectorRow row(column_count_, glm::dvec3(0.0, 0.0, 1.0));
    for (std::size_t i = 0; i < column_count_; ++i) {
      const float r = values[i * channel_count_];
      const float g = values[i * channel_count_ + 1];
      const float b = channel_count_ > 2 ? values[i * channel_count_ + 2] : 0.0f;
      if (!is_vector_value(r) || !is_vector_value(g) || !is_vector_value(b) || is_unused(encoding_, r, g, b)) continue;
      row[i] = decode_vector(encoding_, r, g, b);
      sums_.add_vector(row[i]);
      sums_.blue_min = std::min(sums_.blue_min, static_cast<double>(b));
      sums_.blue_max = std::max(sums_.blue_max, static_cast<double>(b));
    }
    return row;
  }
  void add_scaled_row(std::size_t s, VectorRow row) {
    Scale& scale = scales_[s];
    scale.rows[scale.row_count++ % 3] = std::move(row);
    if (scale.row_count >= 3)
      add_gradients(scale.row_from_last(2), scale.row_from_last(1), scale.row_from_last(0), sums_.gradients[s]);
    if (scale.row_count % 2 == 0 && s + 1 < scales_.size())
      add_scaled_row(s + 1, halved(scale.row_from_last(1), scale.row_from_last(0)));
  }

  VectorEncoding encoding_;
  std::size_t column_count_;
  std::size_t channel_count_;
  BandSums sums_;
  std::array<Scale, kScaleCount> scales_;
};

// Every how many bands one is looked at.
int band_stride(const RawImageInfo& info) {
  constexpr std::int64_t kTexelsMax = std::int64_t{1} << 22;
  return static_cast<int>(1 + (std::int64_t{info.width} * info.height - 1) / kTexelsMax);
}

VectorStatistics statistics_of(const BandSums& sums) {
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
  result.rebuilt_z_min = sums.rebuilt_z_min;
  result.side_max = sums.side_max;
  const double log_mean = sums.log_length / sums.n;
  result.length_mean = std::exp(log_mean);
  result.length_spread = std::sqrt(std::max(0.0, sums.log_length_squares / sums.n - log_mean * log_mean));
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

}  // namespace

struct VectorStatisticsSums::State {
  RawImageInfo info;
  VectorEncoding encoding;
  int row = 0;  // the next
  StatisticsBand band;
  BandSums total;  // of the bands before
};

VectorStatisticsSums::VectorStatisticsSums(const RawImageInfo& info, const VectorEncoding& encoding)
    : state_(std::make_unique<State>(State{info, encoding, 0, StatisticsBand(info, encoding), {}})) {}
VectorStatisticsSums::~VectorStatisticsSums() = default;
VectorStatisticsSums::VectorStatisticsSums(VectorStatisticsSums&& other) noexcept = default;

const VectorEncoding& VectorStatisticsSums::encoding() const { return state_->encoding; }

void VectorStatisticsSums::add_row(const float* values) {
  const int row = state_->row++;
  if (row / kStatisticsRows % band_stride(state_->info) != 0) return;
  state_->band.add_row(values);
  if (state_->row % kStatisticsRows != 0) return;
  state_->total.add(state_->band.sums());
  state_->band = StatisticsBand(state_->info, state_->encoding);
}

VectorStatistics VectorStatisticsSums::result() const {
  BandSums sums = state_->total;
  sums.add(state_->band.sums());  // the last, when it is shorter
  return statistics_of(sums);
}

VectorStatistics vector_statistics(const RawImage& image, const VectorEncoding& encoding, int threads) {
  const RawImageInfo& info = image.info();
  std::vector<BandSums> bands(static_cast<std::size_t>(row_band_count(info.height, kStatisticsRows)));
  const int stride = band_stride(info);
  for_each_row_band(info.height, kStatisticsRows, threads, [&](int band, int row_begin, int row_end) {
    if (band % stride != 0) return;
    StatisticsBand sums(info, encoding);
    RawRows rows;
    for (int row = row_begin; row < row_end; ++row) {
      image.read_rows(row, 1, rows);
      sums.add_row(rows.values.data());
    }
    bands[static_cast<std::size_t>(band)] = sums.sums();
  });
  BandSums total;
  for (const BandSums& band : bands) total.add(band);
  return statistics_of(total);
}

}  // namespace multum
