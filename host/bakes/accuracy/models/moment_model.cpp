// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/models/moment_model.h"

#include <array>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

constexpr int kMomentPointsPerBand = 4096;

// Sums over taps. Stored texels contribute a normal, a share, five moments and a colour. The normal map contributes a
// normal, a share and a colour.
enum MomentSum : std::size_t {
  kNormal = 0,
  kShare = 3,
  kSlopes = 4,
  kColour = 9,
  kMapNormal = 10,
  kMapShare = 13,
  kMapColour = 14,
  kSumCount = 15
};

class MomentShading : public PointShading {
 public:
  MomentShading(Device& device, const MomentModel& model, const ShadingDirections& directions)
      : device_(device),
        model_(model),
        directions_(device, directions),
        kernel_(device.kernel("moment_shade", "moment_shade", {1, 1, false})) {}

  void shade(const PointTaps& points, int shading, int channel, int threads, std::vector<float>& values) override {
    const std::vector<MultumFilteredMoments> moments = model_.filtered(points, channel, threads);
    const std::size_t count = directions_.value_count(), byte_count = points.size() * count * sizeof(float);
    std::vector<float> by_point(points.size() * count);
    const DeviceBuffer moment_buffer =
        device_.wrap_buffer(moments.data(), moments.size() * sizeof(MultumFilteredMoments), "filtered moments");
    if (value_buffer_.byte_count() < byte_count) value_buffer_ = device_.make_buffer(byte_count, "shaded values");
    kernel_.launch({points.size()}, moment_buffer, directions_.half_vectors(), directions_.lights(),
                   directions_.exponents(), value_buffer_, static_cast<int>(points.size()), directions_.half_count(),
                   directions_.light_count(), directions_.highlight_count(), shading);
    device_.read(value_buffer_, by_point.data(), byte_count);
    values.resize(by_point.size());
    order_by_value(by_point, count, 0, points.size(), values);
    directions_.scale_by_totals(values);
  }

 private:
  Device& device_;
  const MomentModel& model_;
  const DirectionBuffers directions_;
  Kernel kernel_;
  DeviceBuffer value_buffer_;
};

}  // namespace

MomentModel::MomentModel(const BakedHeader& header, const TexelSelection& texels)
    : AccuracyModel(texels, header.first_level),
      has_colours_(header.has_colours),
      slopes_(kept().count()),
      normals_(kept().count()),
      colours_(has_colours_ ? kept().count() : 0) {}

void MomentModel::add_rows(int level, int first_row, const MomentLevel& rows) {
  kept().take_rows(level, first_row, rows, [&](std::size_t entry, std::size_t texel) {
    slopes_[entry] = rows.slopes[texel];
    normals_[entry] = rows.normals[texel];
    if (has_colours_) colours_[entry] = rows.colours[texel];
  });
}

const std::vector<std::string>& MomentModel::shadings() const {
  static const std::vector<std::string> kNames = {"toksvig", "lean", "lean-jacobian"};  // MULTUM_SHADE_...
  return kNames;
}

std::unique_ptr<PointShading> MomentModel::make_shading(Device& device, const ShadingDirections& directions) const {
  return std::make_unique<MomentShading>(device, *this, directions);
}

void MomentModel::add_tap(std::size_t slot, double weight, int channel, double* sums) const {
  if (!kept().is_stored(slot)) {
    for (std::size_t c = 0; c < 3; ++c) sums[kMapNormal + c] += weight * map_averages().at(slot, c);
    sums[kMapShare] += weight;
    if (channel >= 0) sums[kMapColour] += weight * map_averages().at(slot, 3 + static_cast<std::size_t>(channel));
    return;
  }
  const std::size_t entry = kept().entry(slot);
  const glm::vec3& n = normals_[entry];
  const SlopeMoments& m = slopes_[entry];
  for (int c = 0; c < 3; ++c) sums[kNormal + static_cast<std::size_t>(c)] += weight * static_cast<double>(n[c]);
  sums[kShare] += weight;
  if (channel >= 0) sums[kColour] += weight * static_cast<double>(colours_[entry][channel]);
  const std::array<float, 5> slopes = {m.s, m.t, m.ss, m.tt, m.st};
  for (std::size_t i = 0; i < slopes.size(); ++i) sums[kSlopes + i] += weight * static_cast<double>(slopes[i]);
}

std::vector<MultumFilteredMoments> MomentModel::filtered(const PointTaps& points, int channel, int threads) const {
  MULTUM_CHECK(is_complete());
  std::vector<MultumFilteredMoments> filtered(points.size());
  for_each_row_band(static_cast<int>(points.size()), kMomentPointsPerBand, threads, [&](int, int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      std::array<double, kSumCount> sums{};
      for (const WeightedSlot& tap : points.of(i)) add_tap(tap.slot, tap.weight, channel, sums.data());
      const auto colour = [&](MomentSum sum, MomentSum share) {
        return channel < 0 || sums[share] == 0.0 ? 1.0 : sums[sum] / sums[share];
      };
      const double stored = colour(kColour, kShare), of_map = colour(kMapColour, kMapShare);
      const auto value = [&](std::size_t number) {
        return static_cast<float>(sums[number] * (number < kMapNormal ? stored : of_map));
      };
      filtered[i] = {
          value(kNormal),     value(kNormal + 1),    value(kNormal + 2),    value(kShare),      value(kSlopes),
          value(kSlopes + 1), value(kSlopes + 2),    value(kSlopes + 3),    value(kSlopes + 4), {},
          value(kMapNormal),  value(kMapNormal + 1), value(kMapNormal + 2), value(kMapShare)};
    }
  });
  return filtered;
}

}  // namespace multum
