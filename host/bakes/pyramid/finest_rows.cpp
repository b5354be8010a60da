// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/finest_rows.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "host/formats/asset/lobes/lobe_family.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

std::vector<glm::vec3> interleaved(const PlaneStore& store, int first_row, int row_count, int threads) {
  const auto width = static_cast<std::size_t>(store.width());
  std::vector<glm::vec3> values(width * static_cast<std::size_t>(row_count));
  for_each_row_band(row_count, kRowsPerBand, threads, [&](int, int begin, int end) {
    const std::size_t count = width * static_cast<std::size_t>(end - begin);
    std::vector<float> x(count), y(count), z(count);
    store.read_rows(first_row + begin, end - begin, {x.data(), y.data(), z.data()});
    glm::vec3* to = &values[width * static_cast<std::size_t>(begin)];
    for (std::size_t i = 0; i < count; ++i) to[i] = {x[i], y[i], z[i]};
  });
  return values;
}

}  // namespace

MovmfFinest finest_rows(const PlaneStore& normals, const FeaturePlanes& features, Representation representation,
                        int first_row, int row_count, int threads) {
  MovmfFinest rows;
  rows.width = normals.width();
  rows.height = row_count;
  rows.normals = interleaved(normals, first_row, row_count, threads);
  rows.lobe.assign(rows.normals.size(), 0);
  rows.representation = representation;
  const LobeFamily& family = lobe_family(representation);
  for (glm::vec3& n : rows.normals) n = family.finest_of_normal(n, normals.is_shortened());
  rows.has_roughness = normals.is_shortened();
  std::vector<std::vector<glm::vec3>> rgb_planes;
  for (const PlaneStore* rgb_plane : features.rgb_planes)
    rgb_planes.push_back(interleaved(*rgb_plane, first_row, row_count, threads));
  split_features(std::move(rgb_planes), features, rows.colours, rows.weights);
  return rows;
}

}  // namespace multum
