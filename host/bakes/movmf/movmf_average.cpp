// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/movmf_average.h"

#include <array>
#include <utility>
#include <vector>

#include "host/bakes/movmf/lobe_rows.h"
#include "host/bakes/movmf/movmf_bake.h"
#include "host/bakes/pyramid/average_pass.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

// Reads rows of three planes, starting with `plane`.
std::vector<glm::vec3> vectors_of(const BoxRows& from, int plane, int threads) {
  const std::size_t width = size_of(from.width);
  std::vector<glm::vec3> vectors(width * size_of(from.height));
  for_each_item(from.height, threads, [&](int y) {
    const float *const x = from.row(plane, y), *const y_row = from.row(plane + 1, y), *const z = from.row(plane + 2, y);
    glm::vec3* const to = &vectors[size_of(y) * width];
    for (std::size_t i = 0; i < width; ++i) to[i] = {x[i], y_row[i], z[i]};
  });
  return vectors;
}

class NormalPlanes : public AveragedPlanes {
 public:
  NormalPlanes(Device& device, const AverageInputs& inputs, const MovmfSettings& settings, MovmfSink& sink,
               FitReport& report)
      : inputs_(inputs),
        kappa_cap_(settings.kappa_cap),
        sink_(sink),
        report_(report),
        take_normals_(device.kernel("mip_box", "mip_features", {1, 1, false})) {}

  std::string name() const override { return "one lobe per texel, averaged,"; }
  int plane_count() const override { return kNormalPlanes; }
  void make_finest(const MapPlanes& normals, const DeviceBuffer& nodes, const MultumBoxBand& band) override {
    take_normals_.launch({size_of(band.row_count) * size_of(band.map_width), kBoxLocalSize}, normals[0], normals[1],
                         normals[2], nodes, band, 0);
  }
  void add_level(const BoxRows& rows) override {
    std::vector<std::vector<glm::vec3>> rgb_planes;
    for (int t = 0; t < inputs_.features.rgb_plane_count(); ++t)
      rgb_planes.push_back(vectors_of(rows, kNormalPlanes + 3 * t, inputs_.threads));
    std::vector<glm::vec3> normals = vectors_of(rows, 0, inputs_.threads);
    if (rows.level == 0) add_finest(rows, std::move(normals), std::move(rgb_planes));
    else add_coarser(rows, normals, rgb_planes);
  }

 private:
  static constexpr int kNormalPlanes = 3;

  void add_finest(const BoxRows& rows, std::vector<glm::vec3> normals, std::vector<std::vector<glm::vec3>> rgb_planes) {
    MovmfFinest out;
    out.width = rows.width;
    out.height = rows.height;
    out.lobe.assign(normals.size(), 0);
    out.normals = std::move(normals);
    out.has_roughness = inputs_.normals->is_shortened();
    split_features(std::move(rgb_planes), inputs_.features, out.colours, out.weights);
    report_.lobe_count_total += out.lobe.size();
    sink_.add_finest(rows.first_row, std::move(out));
  }

  void add_coarser(const BoxRows& rows, const std::vector<glm::vec3>& normals,
                   const std::vector<std::vector<glm::vec3>>& rgb_planes) {
    const LobeRowsSize size{rows.width,
                            rows.height,
                            1,
                            Representation::kMovmf,
                            inputs_.features.has_colours,
                            inputs_.features.weight_count};
    const std::size_t width = size_of(rows.width);
    std::vector<MultumVmfLobe> lobes(normals.size());
    for (std::size_t i = 0; i < normals.size(); ++i) lobes[i] = {normals[i].x, normals[i].y, normals[i].z, 1.0f};
    std::vector<glm::vec3> features;  // [row][rgb_plane][column]
    features.reserve(rgb_planes.size() * normals.size());
    for (std::size_t row = 0; row < normals.size(); row += width)
      for (const std::vector<glm::vec3>& rgb_plane : rgb_planes)
        features.insert(features.end(), rgb_plane.begin() + static_cast<std::ptrdiff_t>(row),
                        rgb_plane.begin() + static_cast<std::ptrdiff_t>(row + width));
    sink_.add_level(rows.level, rows.first_row,
                    stored_rows(size, lobes.data(), features, kappa_cap_, inputs_.threads, report_));
  }

  const AverageInputs& inputs_;
  const float kappa_cap_;
  MovmfSink& sink_;
  FitReport& report_;
  Kernel take_normals_;
};

}  // namespace

bool averages_suffice(const RowOrigin& rows, const MovmfSettings& settings) {
  return settings.lobe_count == 1 && lobe_family(settings.representation).one_lobe_is_mean && !rows.range(0);
}

void average_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, MovmfSink& sink,
                   FitReport& report, Progress* progress) {
  const AverageInputs averages{map, settings.first_level};
  NormalPlanes planes(device, averages, settings, sink, report);
  AverageReport averaged;
  average_map(device, averages, planes, averaged, progress);
  report.plan = averaged.plan;
  // The pass counts as one level of progress.
  const int width = map.normals->width(), height = map.normals->height();
  progress_advance(progress, movmf_bake_units(width, height, settings.first_level) -
                                 static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height));
}

}  // namespace multum
