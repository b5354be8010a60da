// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/averages/sh_bake.h"

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "host/bakes/pyramid/feature_planes.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

ShLevel gather(const BoxRows& from, int order, const FeaturePlanes& features, int threads) {
  ShLevel rows{from.width, from.height, {}, {}, {}};
  const std::size_t texels = size_of(from.width) * size_of(from.height);
  const int count = sh_coefficient_count(order);
  rows.parts.assign(size_of(sh_part_count(order)), std::vector<glm::vec4>(texels, glm::vec4(0.0f)));
  std::vector<std::vector<glm::vec3>> rgb_planes(features.rgb_planes.size(), std::vector<glm::vec3>(texels));
  for_each_row_band(from.height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    for (int y = row_begin; y < row_end; ++y) {
      const std::size_t first = size_of(y) * size_of(from.width);
      for (int i = 0; i < count; ++i) {
        const float* const in = from.row(i, y);
        glm::vec4* const out = rows.parts[size_of(i / 4)].data() + first;
        for (std::size_t x = 0; x < size_of(from.width); ++x) out[x][i % 4] = in[x];
      }
      for (int k = 0; k < 3 * features.rgb_plane_count(); ++k) {
        const float* const in = from.row(count + k, y);
        for (std::size_t x = 0; x < size_of(from.width); ++x) rgb_planes[size_of(k / 3)][first + x][k % 3] = in[x];
      }
    }
  });
  split_features(std::move(rgb_planes), features, rows.colours, rows.weights);
  return rows;
}

class ShPlanes : public AveragedPlanes {
 public:
  ShPlanes(Device& device, int order, const AverageInputs& inputs, ShSink& sink)
      : order_(order),
        inputs_(inputs),
        sink_(sink),
        steps_(sh_recurrence(order)),
        step_buffer_(device.wrap_buffer(steps_.data(), steps_.size() * sizeof(ShStep), "recurrence")),
        project_(device.kernel("sh_project", "sh_project", {1, 1, false, false, order})) {}

  std::string name() const override { return fmt::format("spherical harmonics to order {}", order_); }
  int plane_count() const override { return sh_coefficient_count(order_); }
  void make_finest(const MapPlanes& normals, const DeviceBuffer& nodes, const MultumBoxBand& band) override {
    project_.launch({size_of(band.row_count) * size_of(band.map_width), kBoxLocalSize}, normals[0], normals[1],
                    normals[2], step_buffer_, nodes, band, inputs_.normals->is_shortened() ? 1 : 0);
  }
  void add_level(const BoxRows& rows) override {
    sink_.add_level(rows.level, rows.first_row, gather(rows, order_, inputs_.features, inputs_.threads));
  }

 private:
  const int order_;
  const AverageInputs& inputs_;
  ShSink& sink_;
  const std::vector<ShStep> steps_;
  const DeviceBuffer step_buffer_;
  Kernel project_;
};

// Collects the rows of a bake in a whole mipmap.
class ShMipmapSink : public ShSink {
 public:
  ShMipmapSink(int order, std::vector<ShLevel>& levels) : order_(order), levels_(levels) {}
  void add_level(int level, int, ShLevel rows) override {
    ShLevel& to = levels_[size_of(level)];
    to.parts.resize(size_of(sh_part_count(order_)));
    for (std::size_t p = 0; p < to.parts.size(); ++p)
      to.parts[p].insert(to.parts[p].end(), rows.parts[p].begin(), rows.parts[p].end());
    to.colours.insert(to.colours.end(), rows.colours.begin(), rows.colours.end());
    to.weights.insert(to.weights.end(), rows.weights.begin(), rows.weights.end());
  }

 private:
  const int order_;
  std::vector<ShLevel>& levels_;
};

}  // namespace

void validate_sh_order(int order) {
  if (order < kShOrderMin || order > kShOrderMax)
    throw Error(ErrorCode::kUsage, fmt::format("--sh-order is {}, expected {} to {}", order, kShOrderMin, kShOrderMax));
}

void bake_sh(Device& device, int order, const AverageInputs& inputs, ShSink& sink, AverageReport& report,
             Progress* progress) {
  validate_sh_order(order);
  ShPlanes planes(device, order, inputs, sink);
  average_map(device, inputs, planes, report, progress);
}

ShMipmap bake_sh(Device& device, int order, const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs,
                 AverageReport& report, Progress* progress) {
  const AveragedMap averaged(map, albedo, inputs);
  ShMipmap mipmap;
  mipmap.header = averaged.header(Representation::kSh);
  mipmap.order = order;
  mipmap.levels = empty_sh_levels(map.width, map.height);
  ShMipmapSink sink(order, mipmap.levels);
  bake_sh(device, order, averaged.inputs(), sink, report, progress);
  return mipmap;
}

}  // namespace multum
