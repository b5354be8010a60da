// SPDX-License-Identifier: Apache-2.0
#include "host/bake/accuracy_model.h"

#include <algorithm>
#include <array>

#include "host/base/error.h"
#include "host/base/parallel.h"

namespace multum {

AccuracyModel::AccuracyModel(const MovmfMipmap& mipmap, bool has_colours, const TexelSelection& texels)
    : texels_(texels),
      lobe_count_(static_cast<std::size_t>(mipmap.lobe_count())),
      first_level_(mipmap.first_level),
      first_slot_(texels.level_begin(mipmap.first_level)),
      missing_count_(texels.slot_count() - first_slot_),
      lobes_(missing_count_ * lobe_count_),
      colours_(has_colours ? lobes_.size() : 0) {
  MULTUM_CHECK(mipmap.lobe_count() >= 1 && mipmap.lobe_count() <= kLobeCountMax);
}

void AccuracyModel::add_rows(int level, int first_row, const MovmfLevel& rows) {
  const PlaneSize size = texels_.sizes()[static_cast<std::size_t>(level)];
  MULTUM_CHECK(level >= first_level_ && rows.width == size.width && rows.lobes.size() == lobe_count_);
  MULTUM_CHECK(first_row >= 0 && first_row + rows.height <= size.height);
  for (int y = 0; y < rows.height; ++y) {
    const std::size_t end = texels_.row_end(level, first_row + y);
    for (std::size_t slot = texels_.row_begin(level, first_row + y); slot < end; ++slot) {
      const std::size_t texel = static_cast<std::size_t>(y) * static_cast<std::size_t>(rows.width) +
                                static_cast<std::size_t>(texels_.column(slot));
      const std::size_t kept = (slot - first_slot_) * lobe_count_;
      for (std::size_t j = 0; j < lobe_count_; ++j) lobes_[kept + j] = rows.lobes[j][texel];
      for (std::size_t j = 0; j < lobe_count_ && has_colours(); ++j) colours_[kept + j] = rows.colours[j][texel];
      MULTUM_CHECK(missing_count_ > 0);
      --missing_count_;
    }
  }
}

// Adds weight * (a r, a) of each lobe, and, with a channel, weight * a y.
void AccuracyModel::add_tap(std::size_t slot, double weight, int channel, glm::dvec4* lobes, double* colours) const {
  if (slot < first_slot_) {  // not stored: a lobe of amplitude 1 behind the others
    const glm::dvec3 normal(map_averages_->at(slot, 0), map_averages_->at(slot, 1), map_averages_->at(slot, 2));
    lobes[lobe_count_] += weight * glm::dvec4(normal, 1.0);
    if (channel >= 0) colours[lobe_count_] += weight * map_averages_->at(slot, 3 + static_cast<std::size_t>(channel));
    return;
  }
  const std::size_t kept = (slot - first_slot_) * lobe_count_;
  for (std::size_t j = 0; j < lobe_count_; ++j) {
    lobes[j] += weight * glm::dvec4(lobes_[kept + j]);
    if (channel >= 0) colours[j] += weight * static_cast<double>(colours_[kept + j][channel]);
  }
}

// Shading is linear in (a r, a), so T(a y) / T(a) times the lobe shades to T(a y) times its shape.
std::vector<glm::vec4> AccuracyModel::filtered_lobes(const std::vector<SamplePoint>& points, int channel,
                                                     int threads) const {
  constexpr int kPointsPerBand = 4096;
  MULTUM_CHECK(is_complete() && (first_level_ == 0 || map_averages_ != nullptr));
  const std::size_t count = lobe_count();
  std::vector<glm::vec4> filtered(points.size() * count);
  for_each_row_band(static_cast<int>(points.size()), kPointsPerBand, threads, [&](int, int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      std::array<glm::dvec4, kLobeCountMax + 1> lobes{};
      std::array<double, kLobeCountMax + 1> colours{};
      for (std::size_t t = 0; t < static_cast<std::size_t>(points[i].tap_count); ++t)
        add_tap(points[i].slots[t], points[i].weights[t], channel, lobes.data(), colours.data());
      for (std::size_t j = 0; j < count; ++j) {
        if (channel >= 0 && lobes[j].w > 0.0) lobes[j] *= colours[j] / lobes[j].w;
        filtered[i * count + j] = glm::vec4(lobes[j]);
      }
    }
  });
  return filtered;
}

namespace {

// Never empty: a buffer is not.
std::vector<glm::vec4> padded(const std::vector<glm::dvec3>& directions) {
  std::vector<glm::vec4> result;
  for (const glm::dvec3& direction : directions) result.emplace_back(glm::vec3(direction), 0.0f);
  if (result.empty()) result.emplace_back(0.0f);
  return result;
}

}  // namespace

PointShading::PointShading(Device& device, const AccuracyModel& model, const ShadingDirections& directions)
    : device_(device),
      model_(model),
      half_vectors_(padded(directions.half_vectors)),
      lights_(padded(directions.lights)),
      exponents_(directions.exponents.begin(), directions.exponents.end()),
      half_count_(static_cast<int>(directions.half_vectors.size())),
      light_count_(static_cast<int>(directions.lights.size())),
      exponent_count_(static_cast<int>(directions.exponents.size())),
      value_count_(directions.half_vectors.size() * exponents_.size() + directions.lights.size()) {
  if (exponents_.empty()) exponents_.push_back(1.0f);
  half_buffer_ = device.wrap_buffer(half_vectors_.data(), half_vectors_.size() * sizeof(glm::vec4), "half vectors");
  light_buffer_ = device.wrap_buffer(lights_.data(), lights_.size() * sizeof(glm::vec4), "lights");
  exponent_buffer_ = device.wrap_buffer(exponents_.data(), exponents_.size() * sizeof(float), "exponents");
  kernel_ = device.kernel("movmf_shade", "movmf_shade", {static_cast<int>(model.lobe_count()), 1, false});
}

void PointShading::shade(const std::vector<SamplePoint>& points, int channel, int threads, std::vector<float>& values) {
  const std::vector<glm::vec4> lobes = model_.filtered_lobes(points, channel, threads);
  const std::size_t byte_count = points.size() * value_count_ * sizeof(float);
  values.resize(points.size() * value_count_);
  const DeviceBuffer lobe_buffer =
      device_.wrap_buffer(lobes.data(), lobes.size() * sizeof(glm::vec4), "filtered lobes");
  if (value_buffer_.byte_count() < byte_count) value_buffer_ = device_.make_buffer(byte_count, "shaded values");
  kernel_.launch({points.size()}, lobe_buffer, half_buffer_, light_buffer_, exponent_buffer_, value_buffer_,
                 static_cast<int>(points.size()), half_count_, light_count_, exponent_count_);
  device_.read(value_buffer_, values.data(), byte_count);
}

}  // namespace multum
