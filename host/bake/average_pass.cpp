// SPDX-License-Identifier: Apache-2.0
#include "host/bake/average_pass.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.h"

namespace multum {
namespace {

constexpr std::size_t kMapPlanes = std::tuple_size_v<AveragedPlanes::MapPlanes>;

std::size_t size_of(int count) { return static_cast<std::size_t>(count); }

class AveragePass {
 public:
  AveragePass(Device& device, const AverageInputs& inputs, AveragedPlanes& planes)
      : device_(device),
        inputs_(inputs),
        planes_(planes),
        width_(inputs.normals->width()),
        height_(inputs.normals->height()),
        plane_count_(planes.plane_count() + (has_colours() ? 3 : 0)),
        pyramid_(device, {width_, height_, plane_count_, inputs.first_level}, {inputs.memory_bytes, row_values()}) {
    const std::size_t band = size_of(width_) * sizeof(float) * size_of(pyramid_.band_rows());
    for (DeviceBuffer& plane : normals_) plane = device_.make_buffer(band, "normals");
    if (has_colours())
      for (DeviceBuffer& plane : colours_) plane = device_.make_buffer(band, "colours");
  }

  std::string plan_text() const {
    return fmt::format("{} of {} x {}: one pass in bands of {} rows, {:.1f} MiB of buffers\n", planes_.name(), width_,
                       height_, pyramid_.band_rows(), static_cast<double>(pyramid_.buffer_bytes()) / (1u << 20));
  }

  void run(Progress* progress) {
    progress_stage(progress, "average");
    for (int row = 0; row < height_; row += pyramid_.band_rows()) {
      const MultumBoxBand band = pyramid_.band(row, std::min(pyramid_.band_rows(), height_ - row));
      read_band(band);
      planes_.make_finest(normals_, has_colours() ? colours_ : normals_, pyramid_.nodes(), band);
      pyramid_.average(band);
      pyramid_.hand_over(band, [&](const BoxRows& rows) { planes_.add_level(rows); });
      progress_advance(progress, static_cast<std::uint64_t>(band.row_count) * static_cast<std::uint64_t>(width_));
    }
  }

 private:
  bool has_colours() const { return inputs_.albedo != nullptr; }

  // Of a row: map planes, and what comes of it, as it waits to be written.
  std::size_t row_values() const {
    const std::size_t map_planes = kMapPlanes * (has_colours() ? 2 : 1);
    return (map_planes + 3 * size_of(plane_count_ + 1)) * size_of(width_);
  }

  void read_band(const MultumBoxBand& band) {
    const auto read = [&](const PlaneStore& store, AveragedPlanes::MapPlanes& planes) {
      for (int p = 0; p < static_cast<int>(kMapPlanes); ++p)
        device_.visit(planes[size_of(p)], [&](void* bytes) {
          auto* const values = static_cast<float*>(bytes);
          store.read_rows(p, band.first_row, band.row_count, values);
          if (&planes == &normals_ && p == 2) planes_.see_z(values, size_of(band.row_count) * size_of(width_));
        });
    };
    read(*inputs_.normals, normals_);
    if (has_colours()) read(*inputs_.albedo, colours_);
  }

  Device& device_;
  const AverageInputs& inputs_;
  AveragedPlanes& planes_;
  const int width_, height_, plane_count_;
  BoxPyramid pyramid_;
  AveragedPlanes::MapPlanes normals_, colours_;
};

}  // namespace

void average_map(Device& device, const AverageInputs& inputs, AveragedPlanes& planes, BakeReport& report,
                 Progress* progress) {
  const PlaneStore& normals = *inputs.normals;
  validate_box_map(inputs.first_level, normals.width(), normals.height());
  MULTUM_CHECK(inputs.albedo == nullptr ||
               (inputs.albedo->width() == normals.width() && inputs.albedo->height() == normals.height()));
  AveragePass pass(device, inputs, planes);
  report.plan = pass.plan_text();
  report.device = device.info().name;
  pass.run(progress);
}

std::uint64_t waiting_bytes_beyond_usual(const BakedHeader& header, int tile_size, int values, int part_values) {
  constexpr std::uint64_t kUsual = std::uint64_t{32} << 20;
  std::uint64_t bytes = 0;
  for (int l = header.first_level; l < header.level_count(); ++l) {
    const std::uint64_t texels = static_cast<std::uint64_t>(mip_level_size(header.width, l)) *
                                 static_cast<std::uint64_t>(std::min(tile_size, mip_level_size(header.height, l)));
    bytes += texels * static_cast<std::uint64_t>(values) * sizeof(float);
    if (l == header.first_level) bytes += texels * static_cast<std::uint64_t>(part_values) * sizeof(std::uint16_t);
  }
  return bytes > kUsual ? bytes - kUsual : 0;
}

}  // namespace multum
