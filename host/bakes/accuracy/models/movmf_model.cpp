// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/models/movmf_model.h"

#include <algorithm>
#include <array>

#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// Returns the Gaussian that a renderer computes if it knows only the mean normal. E[x^2 + y^2] = 1 - E[z^2] is
// approximated by 1 minus the square of the mean z.
glm::dvec4 as_gaussian(const glm::dvec4& mean) {
  return {mean.x, mean.y, mean.w > 0.0 ? mean.w - mean.z * mean.z / mean.w : 0.0, mean.w};
}

// Workaround "Oclgrind lacks noalias scopes": Oclgrind 21.10 cannot run the code that Clang makes from functions that
// return structs of vectors, so it gets the scalar variant.
int samples_per_item(const Device& device) {
  return device.info().name.starts_with("Oclgrind") ? 1 : device.shape().vector_width;
}

}  // namespace

ProgramChoice MovmfModel::program(const Device& device, Representation representation, int lobe_count,
                                  int first_level) {
  const int lobes = lobe_count + (first_level > 0 ? 1 : 0);  // the averages of the map form one more lobe
  return {"movmf_shade", {lobes, samples_per_item(device), false, lobe_family(representation).is_planar}};
}

MovmfModel::MovmfModel(const MovmfMipmap& mipmap, bool has_colours, const TexelSelection& texels)
    : AccuracyModel(texels, mipmap.header.first_level),
      is_planar_(lobe_family(mipmap.header.representation).is_planar),
      representation_(mipmap.header.representation),
      lobe_count_(static_cast<std::size_t>(mipmap.lobe_count())),
      lobes_(kept().count() * lobe_count_),
      colours_(has_colours ? lobes_.size() : 0) {
  MULTUM_CHECK(mipmap.lobe_count() >= 1 && mipmap.lobe_count() <= kLobeCountMax);
}

ProgramChoice MovmfModel::program(const Device& device) const {
  return program(device, representation_, static_cast<int>(lobe_count_), first_level());
}

void MovmfModel::add_rows(int level, int first_row, const MovmfLevel& rows) {
  MULTUM_CHECK(rows.lobes.size() == lobe_count_);
  kept().take_rows(level, first_row, rows, [&](std::size_t entry, std::size_t texel) {
    const std::size_t first = entry * lobe_count_;
    for (std::size_t j = 0; j < lobe_count_; ++j) lobes_[first + j] = rows.lobes[j][texel];
    for (std::size_t j = 0; j < lobe_count_ && has_colours(); ++j) colours_[first + j] = rows.colours[j][texel];
  });
}

// Adds weight * (a r, a) of each lobe and, for a channel, weight * a y.
void MovmfModel::add_tap(std::size_t slot, double weight, int channel, glm::dvec4* lobes, double* colours) const {
  if (!kept().is_stored(slot)) {  // a texel that is not stored becomes a lobe with amplitude 1, after the other lobes
    const glm::dvec3 normal(map_averages().at(slot, 0), map_averages().at(slot, 1), map_averages().at(slot, 2));
    lobes[lobe_count_] += weight * glm::dvec4(normal, 1.0);
    if (channel >= 0) colours[lobe_count_] += weight * map_averages().at(slot, 3 + static_cast<std::size_t>(channel));
    return;
  }
  const std::size_t first = kept().entry(slot) * lobe_count_;
  for (std::size_t j = 0; j < lobe_count_; ++j) {
    lobes[j] += weight * glm::dvec4(lobes_[first + j]);
    if (channel >= 0) colours[j] += weight * static_cast<double>(colours_[first + j][channel]);
  }
}

// Shading is linear in (a r, a). Let T(x) be the filtered x. A lobe that is multiplied by T(a y) / T(a) therefore
// contributes T(a y) times its shape.
std::vector<glm::vec4> MovmfModel::filtered_lobes(const PointTaps& points, int channel, int threads) const {
  constexpr int kPointsPerBand = 4096;
  MULTUM_CHECK(is_complete());
  const std::size_t count = lobe_count();
  std::vector<glm::vec4> filtered(points.size() * count);
  for_each_row_band(static_cast<int>(points.size()), kPointsPerBand, threads, [&](int, int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      std::array<glm::dvec4, kLobeCountMax + 1> lobes{};
      std::array<double, kLobeCountMax + 1> colours{};
      for (const WeightedSlot& tap : points.of(i)) add_tap(tap.slot, tap.weight, channel, lobes.data(), colours.data());
      if (is_planar_ && count > lobe_count_) lobes[lobe_count_] = as_gaussian(lobes[lobe_count_]);
      for (std::size_t j = 0; j < count; ++j) {
        if (channel >= 0 && lobes[j].w > 0.0) lobes[j] *= colours[j] / lobes[j].w;
        filtered[i * count + j] = glm::vec4(lobes[j]);
      }
    }
  });
  return filtered;
}

namespace {

class MovmfShading : public PointShading {
 public:
  MovmfShading(Device& device, const MovmfModel& model, const ShadingDirections& directions)
      : device_(device),
        model_(model),
        directions_(device, directions),
        width_(static_cast<std::size_t>(samples_per_item(device))),
        kernel_(device.kernel("movmf_shade", "movmf_shade", model.program(device).variant)) {}

  void shade(const PointTaps& points, int, int channel, int threads, std::vector<float>& values) override {
    const std::vector<glm::vec4> lobes = model_.filtered_lobes(points, channel, threads);
    const std::size_t byte_count = points.size() * directions_.value_count() * sizeof(float);
    values.resize(points.size() * directions_.value_count());
    const DeviceBuffer lobe_buffer =
        device_.wrap_buffer(lobes.data(), lobes.size() * sizeof(glm::vec4), "filtered lobes");
    if (value_buffer_.byte_count() < byte_count) value_buffer_ = device_.make_buffer(byte_count, "shaded values");
    kernel_.launch({(points.size() + width_ - 1) / width_}, lobe_buffer, directions_.half_vectors(),
                   directions_.lights(), directions_.highlights(), value_buffer_, static_cast<int>(points.size()),
                   directions_.half_count(), directions_.light_count(), directions_.highlight_count());
    device_.read(value_buffer_, values.data(), byte_count);
  }

 private:
  Device& device_;
  const MovmfModel& model_;
  const DirectionBuffers directions_;
  const std::size_t width_;  // samples per work-item
  Kernel kernel_;
  DeviceBuffer value_buffer_;
};

}  // namespace

const std::vector<std::string>& MovmfModel::shadings() const {
  static const std::vector<std::string> kOne = {""};
  return kOne;
}

std::unique_ptr<PointShading> MovmfModel::make_shading(Device& device, const ShadingDirections& directions) const {
  return std::make_unique<MovmfShading>(device, *this, directions);
}

}  // namespace multum
