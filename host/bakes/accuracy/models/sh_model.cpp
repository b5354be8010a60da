// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/models/sh_model.h"

#include <algorithm>
#include <array>

#include "host/formats/brdf/facet_distribution.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// The coefficients take about 14 MiB at order 20.
constexpr std::size_t kPointsPerLaunch = 8192;
constexpr int kShPointsPerBand = 1024;

ZonalCoefficients zonal_of(const Brdf& brdf, int order) {
  if (brdf.kind == BrdfKind::kBlinnPhong) return zonal_blinn_phong(order, static_cast<double>(brdf.exponent));
  ZonalCoefficients grey;
  for (const glm::dvec3& a : zonal_coefficients(brdf, order)) grey.push_back(mean_channel(a));
  return grey;
}

class ShShading : public PointShading {
 public:
  ShShading(Device& device, const ShModel& model, const ShadingDirections& directions)
      : device_(device),
        model_(model),
        directions_(device, directions),
        steps_(sh_recurrence(model.order())),
        step_buffer_(device.wrap_buffer(steps_.data(), steps_.size() * sizeof(ShStep), "recurrence")),
        kernel_(device.kernel("sh_shade", "sh_shade", {1, 1, false, false, model.order()})) {
    for (const Highlight& highlight : directions.highlights) append(zonal_of(highlight.brdf, model.order()));
    append(directions.mean_cosine > 0.0f
               ? zonal_lambert_of_rough(model.order(), static_cast<double>(directions.mean_cosine))
               : zonal_lambert(model.order()));
    zonal_buffer_ = device.wrap_buffer(zonal_.data(), zonal_.size() * sizeof(float), "zonal coefficients");
    value_buffer_ = device.make_buffer(kPointsPerLaunch * directions_.value_count() * sizeof(float), "shaded values");
  }

  void shade(const PointTaps& points, int, int channel, int threads, std::vector<float>& values) override {
    const std::size_t value_count = directions_.value_count();
    values.resize(points.size() * value_count);
    for (std::size_t begin = 0; begin < points.size(); begin += kPointsPerLaunch) {
      const std::size_t end = std::min(points.size(), begin + kPointsPerLaunch);
      const ShModel::Filtered filtered = model_.filtered(points, begin, end, channel, threads);
      const DeviceBuffer coefficients = device_.wrap_buffer(
          filtered.coefficients.data(), filtered.coefficients.size() * sizeof(float), "filtered coefficients");
      const DeviceBuffer shares = device_.wrap_buffer(
          filtered.points.data(), filtered.points.size() * sizeof(MultumFilteredSh), "filtered points");
      kernel_.launch({end - begin}, coefficients, shares, step_buffer_, zonal_buffer_, directions_.half_vectors(),
                     directions_.lights(), directions_.highlights(), value_buffer_, static_cast<int>(end - begin),
                     directions_.half_count(), directions_.light_count(), directions_.highlight_count());
      std::vector<float> of_launch((end - begin) * value_count);
      device_.read(value_buffer_, of_launch.data(), of_launch.size() * sizeof(float));
      order_by_value(of_launch, value_count, begin, points.size(), values);
    }
  }

 private:
  void append(const ZonalCoefficients& a) { zonal_.insert(zonal_.end(), a.begin(), a.end()); }

  Device& device_;
  const ShModel& model_;
  const DirectionBuffers directions_;
  const std::vector<ShStep> steps_;
  const DeviceBuffer step_buffer_;
  std::vector<float> zonal_;  // [highlights, then Lambert][l]
  DeviceBuffer zonal_buffer_, value_buffer_;
  Kernel kernel_;
};

}  // namespace

ShModel::ShModel(const ShMipmap& mipmap, const TexelSelection& texels)
    : AccuracyModel(texels, mipmap.header.first_level),
      order_(mipmap.order),
      count_(static_cast<std::size_t>(sh_coefficient_count(mipmap.order))),
      has_colours_(mipmap.header.has_colours),
      coefficients_(kept().count() * count_),
      colours_(has_colours_ ? kept().count() : 0) {}

void ShModel::add_rows(int level, int first_row, const ShLevel& rows) {
  kept().take_rows(level, first_row, rows, [&](std::size_t entry, std::size_t texel) {
    for (std::size_t i = 0; i < count_; ++i) coefficients_[entry * count_ + i] = rows.value(static_cast<int>(i), texel);
    if (has_colours_) colours_[entry] = rows.colours[texel];
  });
}

const std::vector<std::string>& ShModel::shadings() const {
  static const std::vector<std::string> kOne = {""};
  return kOne;
}

std::unique_ptr<PointShading> ShModel::make_shading(Device& device, const ShadingDirections& directions) const {
  return std::make_unique<ShShading>(device, *this, directions);
}

// Sums over taps. Stored texels contribute coefficients, a share and a colour. The normal map contributes a normal, a
// share and a colour.
void ShModel::add_tap(std::size_t slot, double weight, int channel, double* coefficients, double* map, double* share,
                      Colour& colour) const {
  if (!kept().is_stored(slot)) {
    for (std::size_t c = 0; c < 3; ++c) map[c] += weight * map_averages().at(slot, c);
    map[3] += weight;
    if (channel >= 0) colour.of_map += weight * map_averages().at(slot, 3 + static_cast<std::size_t>(channel));
    return;
  }
  const std::size_t entry = kept().entry(slot);
  for (std::size_t i = 0; i < count_; ++i)
    coefficients[i] += weight * static_cast<double>(coefficients_[entry * count_ + i]);
  *share += weight;
  if (channel >= 0) colour.stored += weight * static_cast<double>(colours_[entry][channel]);
}

ShModel::Filtered ShModel::filtered(const PointTaps& points, std::size_t begin, std::size_t end, int channel,
                                    int threads) const {
  MULTUM_CHECK(is_complete());
  Filtered filtered{std::vector<float>((end - begin) * count_), std::vector<MultumFilteredSh>(end - begin)};
  for_each_row_band(static_cast<int>(end - begin), kShPointsPerBand, threads, [&](int, int band_begin, int band_end) {
    std::vector<double> sums(count_);
    for (auto i = static_cast<std::size_t>(band_begin); i < static_cast<std::size_t>(band_end); ++i) {
      std::fill(sums.begin(), sums.end(), 0.0);
      std::array<double, 4> map{};
      double share = 0.0;
      Colour colour;
      for (const WeightedSlot& tap : points.of(begin + i))
        add_tap(tap.slot, tap.weight, channel, sums.data(), map.data(), &share, colour);
      const auto factor = [&](double sum, double weight) { return channel < 0 || weight == 0.0 ? 1.0 : sum / weight; };
      const double stored = factor(colour.stored, share), of_map = factor(colour.of_map, map[3]);
      for (std::size_t k = 0; k < count_; ++k)
        filtered.coefficients[i * count_ + k] = static_cast<float>(sums[k] * stored);
      const auto map_value = [&](std::size_t c) { return static_cast<float>(map[c] * of_map); };
      filtered.points[i] = {
          map_value(0), map_value(1), map_value(2), map_value(3), static_cast<float>(share * stored), {}};
    }
  });
  return filtered;
}

}  // namespace multum
