// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/averages/moment_bake.h"

#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "host/bakes/pyramid/feature_planes.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"
#include "kernels/shared/moments.h"

namespace multum {
namespace {

MomentLevel gather(const BoxRows& from, const FeaturePlanes& features, int threads) {
  const int width = from.width, height = from.height;
  MomentLevel rows{width, height, {}, {}, {}};
  const std::size_t texels = size_of(width) * size_of(height);
  rows.slopes.resize(texels);
  rows.normals.resize(texels);
  std::vector<std::vector<glm::vec3>> rgb_planes(features.rgb_planes.size(), std::vector<glm::vec3>(texels));
  for_each_row_band(height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    for (int y = row_begin; y < row_end; ++y) {
      const auto value = [&](int plane, std::size_t x) { return from.row(plane, y)[x]; };
      const auto vector = [&](int plane, std::size_t x) {
        return glm::vec3(value(plane, x), value(plane + 1, x), value(plane + 2, x));
      };
      for (std::size_t x = 0; x < size_of(width); ++x) {
        const std::size_t i = size_of(y) * size_of(width) + x;
        rows.slopes[i] = {kNoHeight,
                          value(MULTUM_MOMENT_S, x),
                          value(MULTUM_MOMENT_T, x),
                          value(MULTUM_MOMENT_SS, x),
                          value(MULTUM_MOMENT_TT, x),
                          value(MULTUM_MOMENT_ST, x)};
        rows.normals[i] = vector(MULTUM_MOMENT_NORMAL, x);
        for (std::size_t t = 0; t < rgb_planes.size(); ++t)
          rgb_planes[t][i] = vector(MULTUM_MOMENT_PLANES + 3 * static_cast<int>(t), x);
      }
    }
  });
  split_features(std::move(rgb_planes), features, rows.colours, rows.weights);
  return rows;
}

class MomentPlanes : public AveragedPlanes {
 public:
  MomentPlanes(Device& device, const AverageInputs& inputs, MomentSink& sink)
      : inputs_(inputs), sink_(sink), finest_(device.kernel("moments", "moment_finest", {1, 1, false})) {}

  /// Number of normals that are too close to the horizon for slopes.
  std::uint64_t limited() const { return limited_; }

  std::string name() const override { return "moments"; }
  int plane_count() const override { return MULTUM_MOMENT_PLANES; }
  void make_finest(const MapPlanes& normals, const DeviceBuffer& nodes, const MultumBoxBand& band) override {
    finest_.launch({size_of(band.row_count) * size_of(band.map_width), kBoxLocalSize}, normals[0], normals[1],
                   normals[2], nodes, band, kSlopeZMin, inputs_.normals->is_shortened() ? 1 : 0);
  }
  void see_normals(const std::array<const float*, 3>& n, std::size_t count) override {
    for (std::size_t i = 0; i < count; ++i) {
      // Normals may have any length.
      const float length =
          inputs_.normals->is_shortened() ? std::sqrt(n[0][i] * n[0][i] + n[1][i] * n[1][i] + n[2][i] * n[2][i]) : 1.0f;
      limited_ += n[2][i] < kSlopeZMin * length ? 1u : 0u;
    }
  }
  void add_level(const BoxRows& rows) override {
    sink_.add_level(rows.level, rows.first_row, gather(rows, inputs_.features, inputs_.threads));
  }

 private:
  const AverageInputs& inputs_;
  MomentSink& sink_;
  Kernel finest_;
  std::uint64_t limited_ = 0;
};

// Collects the rows of a bake in a whole mipmap.
class MomentMipmapSink : public MomentSink {
 public:
  explicit MomentMipmapSink(std::vector<MomentLevel>& levels) : levels_(levels) {}
  void add_level(int level, int, MomentLevel rows) override {
    MomentLevel& to = levels_[size_of(level)];
    to.slopes.insert(to.slopes.end(), rows.slopes.begin(), rows.slopes.end());
    to.normals.insert(to.normals.end(), rows.normals.begin(), rows.normals.end());
    to.colours.insert(to.colours.end(), rows.colours.begin(), rows.colours.end());
    to.weights.insert(to.weights.end(), rows.weights.begin(), rows.weights.end());
  }

 private:
  std::vector<MomentLevel>& levels_;
};

}  // namespace

void bake_moments(Device& device, const AverageInputs& inputs, MomentSink& sink, AverageReport& report,
                  Progress* progress) {
  MomentPlanes planes(device, inputs, sink);
  average_map(device, inputs, planes, report, progress);
  report.slopes_limited = planes.limited();
}

MomentMipmap bake_moments(Device& device, const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs,
                          AverageReport& report, Progress* progress) {
  const AveragedMap averaged(map, albedo, inputs);
  MomentMipmap mipmap;
  mipmap.header = averaged.header(Representation::kMoments);
  mipmap.levels = empty_moment_levels(map.width, map.height);
  MomentMipmapSink sink(mipmap.levels);
  bake_moments(device, averaged.inputs(), sink, report, progress);
  return mipmap;
}

}  // namespace multum
