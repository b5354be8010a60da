// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/map_mosaic.h"

namespace multum {

BakeSource make_mosaic(const BakeSource& source, const MosaicSettings& settings) {
  const PlaneStore& normals = source.map.normals;
  const MosaicCuts cuts = mosaic_cuts(normals.width(), normals.height(), settings);
  BakeSource mosaic{{cut_planes(normals, cuts), source.map.report}, std::nullopt, std::nullopt};
  if (source.albedo) mosaic.albedo.emplace(cut_planes(*source.albedo, cuts));
  if (source.weights) {
    mosaic.weights.emplace();
    mosaic.weights->count = source.weights->count;
    for (const PlaneStore& rgb_plane : source.weights->rgb_planes)
      mosaic.weights->rgb_planes.push_back(cut_planes(rgb_plane, cuts));
  }
  mosaic.mean_cosine = source.mean_cosine;
  return mosaic;
}

}  // namespace multum
