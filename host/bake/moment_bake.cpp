// SPDX-License-Identifier: Apache-2.0
#include "host/bake/moment_bake.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "host/base/parallel.h"
#include "kernels/shared/moments.h"

namespace multum {
namespace {

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

class MomentPlanes : public AveragedPlanes {
 public:
  MomentPlanes(Device& device, const AverageInputs& inputs, MomentSink& sink)
      : inputs_(inputs), sink_(sink), finest_(device.kernel("moments", "moment_finest", {1, 1, false})) {}

  /// Normals nearer to the horizon than slopes go.
  std::uint64_t limited() const { return limited_; }

  std::string name() const override { return "moments"; }
  int plane_count() const override { return MULTUM_MOMENT_PLANES; }
  void make_finest(const MapPlanes& normals, const MapPlanes& colours, const DeviceBuffer& nodes,
                   const MultumBoxBand& band) override {
    finest_.launch({size_of(band.row_count) * size_of(band.map_width), kBoxLocalSize}, normals[0], normals[1],
                   normals[2], colours[0], colours[1], colours[2], nodes, band, kSlopeZMin);
  }
  void see_z(const float* z, std::size_t count) override {
    limited_ += static_cast<std::uint64_t>(std::count_if(z, z + count, [](float one) { return one < kSlopeZMin; }));
  }
  void add_level(const BoxRows& rows) override {
    sink_.add_level(rows.level, rows.first_row, gather(rows, inputs_.albedo != nullptr, inputs_.threads));
  }

 private:
  const AverageInputs& inputs_;
  MomentSink& sink_;
  Kernel finest_;
  std::uint64_t limited_ = 0;
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

void bake_moments(Device& device, const AverageInputs& inputs, MomentSink& sink, BakeReport& report,
                  Progress* progress) {
  MomentPlanes planes(device, inputs, sink);
  average_map(device, inputs, planes, report, progress);
  report.slopes_limited = planes.limited();
}

MomentMipmap bake_moments(Device& device, const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs,
                          BakeReport& report, Progress* progress) {
  const PlaneStore normals = planes_of(map);
  std::optional<PlaneStore> colours;
  if (albedo != nullptr) colours = planes_of(*albedo);
  AverageInputs all = inputs;
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
