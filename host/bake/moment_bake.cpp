// SPDX-License-Identifier: Apache-2.0
#include "host/bake/moment_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "host/bake/box_pyramid.h"
#include "host/base/error.h"
#include "host/base/parallel.h"
#include "kernels/shared/moments.h"

namespace multum {
namespace {

constexpr std::size_t kMapPlanes = 3;

// Work-items are small: PoCL takes as long to begin a group of them as to run one.
constexpr std::size_t kLocalSize = 64;

std::size_t size_of(int count) { return static_cast<std::size_t>(count); }

MomentLevel gather(const BoxRows& from, bool has_colours, int threads) {
  const int width = from.width, height = from.height;
  MomentLevel rows{width, height, {}, {}, {}};
  const std::size_t texels = size_of(width) * size_of(height);
  rows.slopes.resize(texels);
  rows.normals.resize(texels);
  if (has_colours) rows.colours.resize(texels);
  for_each_row_band(height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    for (int y = row_begin; y < row_end; ++y) {
      const auto value = [&](int plane, std::size_t x) { return from.row(plane, y)[x]; };
      for (std::size_t x = 0; x < size_of(width); ++x) {
        const std::size_t i = size_of(y) * size_of(width) + x;
        rows.slopes[i] = {kNoHeight,
                          value(MULTUM_MOMENT_S, x),
                          value(MULTUM_MOMENT_T, x),
                          value(MULTUM_MOMENT_SS, x),
                          value(MULTUM_MOMENT_TT, x),
                          value(MULTUM_MOMENT_ST, x)};
        constexpr int kNormal = MULTUM_MOMENT_NORMAL, kColour = MULTUM_MOMENT_COLOUR;
        rows.normals[i] = {value(kNormal, x), value(kNormal + 1, x), value(kNormal + 2, x)};
        if (has_colours) rows.colours[i] = {value(kColour, x), value(kColour + 1, x), value(kColour + 2, x)};
      }
    }
  });
  return rows;
}

class MomentPass {
 public:
  MomentPass(Device& device, const MomentBakeInputs& inputs, MomentSink& sink)
      : device_(device),
        inputs_(inputs),
        sink_(sink),
        width_(inputs.normals->width()),
        height_(inputs.normals->height()),
        plane_count_(MULTUM_MOMENT_PLANES + (inputs.albedo != nullptr ? 3 : 0)),
        pyramid_(device, {width_, height_, plane_count_, inputs.first_level}, {inputs.memory_bytes, row_values()}) {
    const std::size_t band = size_of(width_) * sizeof(float) * size_of(pyramid_.band_rows());
    for (DeviceBuffer& plane : normals_) plane = device_.make_buffer(band, "normals");
    if (has_colours())
      for (DeviceBuffer& plane : colours_) plane = device_.make_buffer(band, "colours");
    finest_ = device.kernel("moments", "moment_finest", {1, 1, false});
  }

  std::string plan_text() const {
    return fmt::format("moments of {} x {}: one pass in bands of {} rows, {:.1f} MiB of buffers\n", width_, height_,
                       pyramid_.band_rows(), static_cast<double>(pyramid_.buffer_bytes()) / (1u << 20));
  }

  /// Returns how many normals are nearer to the horizon than slopes go.
  std::uint64_t run(Progress* progress) {
    progress_stage(progress, "average");
    for (int row = 0; row < height_; row += pyramid_.band_rows()) {
      const MultumBoxBand band = pyramid_.band(row, std::min(pyramid_.band_rows(), height_ - row));
      read_band(band);
      const std::array<DeviceBuffer, kMapPlanes>& colours = has_colours() ? colours_ : normals_;  // or anything
      finest_.launch({size_of(band.row_count) * size_of(width_), kLocalSize}, normals_[0], normals_[1], normals_[2],
                     colours[0], colours[1], colours[2], pyramid_.nodes(), band, kSlopeZMin);
      pyramid_.average(band);
      pyramid_.hand_over(band, [&](const BoxRows& rows) {
        sink_.add_level(rows.level, rows.first_row, gather(rows, has_colours(), inputs_.threads));
      });
      progress_advance(progress, static_cast<std::uint64_t>(band.row_count) * static_cast<std::uint64_t>(width_));
    }
    return clamped_;
  }

 private:
  bool has_colours() const { return inputs_.albedo != nullptr; }

  // Of a row: map planes, and what comes of it, as it waits to be written.
  std::size_t row_values() const {
    const std::size_t map_planes = kMapPlanes * (has_colours() ? 2 : 1);
    return (map_planes + 3 * size_of(plane_count_ + 1)) * size_of(width_);
  }

  void read_band(const MultumBoxBand& band) {
    const auto read = [&](const PlaneStore& store, std::array<DeviceBuffer, kMapPlanes>& planes) {
      for (int p = 0; p < static_cast<int>(kMapPlanes); ++p)
        device_.visit(planes[size_of(p)], [&](void* bytes) {
          auto* const values = static_cast<float*>(bytes);
          store.read_rows(p, band.first_row, band.row_count, values);
          if (&planes == &normals_ && p == 2)
            clamped_ += static_cast<std::uint64_t>(std::count_if(
                values, values + size_of(band.row_count) * size_of(width_), [](float z) { return z < kSlopeZMin; }));
        });
    };
    read(*inputs_.normals, normals_);
    if (has_colours()) read(*inputs_.albedo, colours_);
  }

  Device& device_;
  const MomentBakeInputs& inputs_;
  MomentSink& sink_;
  const int width_, height_, plane_count_;
  BoxPyramid pyramid_;
  std::uint64_t clamped_ = 0;
  std::array<DeviceBuffer, kMapPlanes> normals_, colours_;
  Kernel finest_;
};

// Gathers what a bake hands over into a whole mipmap.
class MipmapSink : public MomentSink {
 public:
  explicit MipmapSink(std::vector<MomentLevel>& levels) : levels_(levels) {}
  void add_level(int level, int, MomentLevel rows) override {
    MomentLevel& to = levels_[size_of(level)];
    to.slopes.insert(to.slopes.end(), rows.slopes.begin(), rows.slopes.end());
    to.normals.insert(to.normals.end(), rows.normals.begin(), rows.normals.end());
    to.colours.insert(to.colours.end(), rows.colours.begin(), rows.colours.end());
  }

 private:
  std::vector<MomentLevel>& levels_;
};

}  // namespace

void bake_moments(Device& device, const MomentBakeInputs& inputs, MomentSink& sink, BakeReport& report,
                  Progress* progress) {
  const PlaneStore& normals = *inputs.normals;
  validate_box_map(inputs.first_level, normals.width(), normals.height());
  MULTUM_CHECK(inputs.albedo == nullptr ||
               (inputs.albedo->width() == normals.width() && inputs.albedo->height() == normals.height()));
  MomentPass pass(device, inputs, sink);
  report.plan = pass.plan_text();
  report.device = device.info().name;
  report.slopes_limited = pass.run(progress);
}

MomentMipmap bake_moments(Device& device, const NormalMap& map, const ColourMap* albedo, const MomentBakeInputs& inputs,
                          BakeReport& report, Progress* progress) {
  const PlaneStore normals = planes_of(map);
  std::optional<PlaneStore> colours;
  if (albedo != nullptr) colours = planes_of(*albedo);
  MomentBakeInputs all = inputs;
  all.normals = &normals;
  all.albedo = colours ? &*colours : nullptr;
  MomentMipmap mipmap;
  mipmap.header.representation = Representation::kMoments;
  mipmap.header.encoding = StorageEncoding::kFloat;
  mipmap.header.width = map.width;
  mipmap.header.height = map.height;
  mipmap.header.first_level = inputs.first_level;
  mipmap.header.has_colours = albedo != nullptr;
  mipmap.levels = empty_moment_levels(map.width, map.height);
  MipmapSink sink(mipmap.levels);
  bake_moments(device, all, sink, report, progress);
  return mipmap;
}

}  // namespace multum
