// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/average_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "host/bakes/pyramid/feature_planes.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr std::size_t kMapPlanes = std::tuple_size_v<AveragedPlanes::MapPlanes>;

class AveragePass {
 public:
  AveragePass(Device& device, const AverageInputs& inputs, AveragedPlanes& planes)
      : device_(device),
        inputs_(inputs),
        planes_(planes),
        width_(inputs.normals->width()),
        height_(inputs.normals->height()),
        plane_count_(planes.plane_count() + 3 * inputs.features.rgb_plane_count()),
        pyramid_(device, {width_, height_, plane_count_, inputs.first_level}, {inputs.memory_bytes, row_values()}),
        take_features_(device.kernel("mip_box", "mip_features", {1, 1, false})) {
    const std::size_t band = size_of(width_) * sizeof(float) * size_of(pyramid_.band_rows());
    for (DeviceBuffer& plane : normals_) plane = device_.make_buffer(band, "normals");
    rgb_planes_.resize(inputs_.features.rgb_planes.size());
    for (AveragedPlanes::MapPlanes& rgb_plane : rgb_planes_)
      for (DeviceBuffer& plane : rgb_plane) plane = device_.make_buffer(band, "features");
  }

  std::string plan_text() const {
    return fmt::format("{} of {} x {}: one pass in bands of {} rows, with buffers of {:.1f} MiB\n", planes_.name(),
                       width_, height_, pyramid_.band_rows(),
                       static_cast<double>(pyramid_.buffer_bytes()) / (1u << 20));
  }

  void run(Progress* progress) {
    progress_stage(progress, "average");
    for (int row = 0; row < height_; row += pyramid_.band_rows()) {
      const MultumBoxBand band = pyramid_.band(row, std::min(pyramid_.band_rows(), height_ - row));
      read_band(band);
      make_finest(band);
      pyramid_.average(band);
      pyramid_.hand_over(band, [&](const BoxRows& rows) { planes_.add_level(rows); });
      planes_.end_band();
      progress_advance(progress, static_cast<std::uint64_t>(band.row_count) * static_cast<std::uint64_t>(width_));
    }
  }

 private:
  // Returns the number of values per row, for planes of the map and for output rows that wait to be written.
  std::size_t row_values() const {
    const std::size_t map_planes = kMapPlanes * (1 + inputs_.features.rgb_planes.size());
    return (map_planes + 3 * size_of(plane_count_ + 1)) * size_of(width_);
  }

  void read_band(const MultumBoxBand& band) {
    const auto read = [&](const PlaneStore& store, AveragedPlanes::MapPlanes& planes, const auto& see) {
      const std::size_t bytes = size_of(band.row_count) * size_of(width_) * sizeof(float);
      device_.write_ranges(
          {{&planes[0], 0, bytes}, {&planes[1], 0, bytes}, {&planes[2], 0, bytes}}, [&](const Device::Bytes& at) {
            const std::array<float*, 3> values = {reinterpret_cast<float*>(at[0]), reinterpret_cast<float*>(at[1]),
                                                  reinterpret_cast<float*>(at[2])};
            store.read_rows(band.first_row, band.row_count, values);
            see(values);
          });
    };
    read(*inputs_.normals, normals_, [&](const std::array<float*, 3>& values) {
      planes_.see_normals({values[0], values[1], values[2]}, size_of(band.row_count) * size_of(width_));
    });
    for (std::size_t t = 0; t < rgb_planes_.size(); ++t)
      read(*inputs_.features.rgb_planes[t], rgb_planes_[t], [](const std::array<float*, 3>&) {});
  }

  void make_finest(const MultumBoxBand& band) {
    planes_.make_finest(normals_, pyramid_.nodes(), band);
    int first_plane = planes_.plane_count();
    for (const AveragedPlanes::MapPlanes& rgb_plane : rgb_planes_) {
      take_features_.launch({size_of(band.row_count) * size_of(width_), kBoxLocalSize}, rgb_plane[0], rgb_plane[1],
                            rgb_plane[2], pyramid_.nodes(), band, first_plane);
      first_plane += static_cast<int>(kMapPlanes);
    }
  }

  Device& device_;
  const AverageInputs& inputs_;
  AveragedPlanes& planes_;
  const int width_, height_, plane_count_;
  BoxPyramid pyramid_;
  Kernel take_features_;
  AveragedPlanes::MapPlanes normals_;
  std::vector<AveragedPlanes::MapPlanes> rgb_planes_;
};

}  // namespace

AveragedMap::AveragedMap(const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs)
    : normals_(planes_of(map)),
      albedo_(albedo != nullptr ? std::optional<PlaneStore>(planes_of(*albedo)) : std::nullopt),
      inputs_(inputs) {
  inputs_.normals = &normals_;
  if (albedo_) inputs_.features = inputs.features.with_colours(*albedo_);
}

BakedHeader AveragedMap::header(Representation representation) const {
  BakedHeader header;
  header.representation = representation;
  header.encoding = StorageEncoding::kFloat;
  header.width = normals_.width();
  header.height = normals_.height();
  header.first_level = inputs_.first_level;
  header.has_colours = albedo_.has_value();
  header.weight_count = inputs_.features.weight_count;
  header.has_roughness = normals_.is_shortened();
  return header;
}

void average_map(Device& device, const AverageInputs& inputs, AveragedPlanes& planes, AverageReport& report,
                 Progress* progress) {
  const PlaneStore& normals = *inputs.normals;
  validate_box_map(inputs.first_level, normals.width(), normals.height());
  MULTUM_CHECK(inputs.features.all_of_size(normals.width(), normals.height()));
  AveragePass pass(device, inputs, planes);
  report.plan = pass.plan_text();
  pass.run(progress);
}

}  // namespace multum
