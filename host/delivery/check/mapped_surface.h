// SPDX-License-Identifier: Apache-2.0
// Makes the surfaces whose gain is measured: a mosaic of a map, and of the textures of each material of a model.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/delivery/check/gain_meter.h"
#include "host/delivery/gltf/gltf_asset.h"
#include "host/formats/image/plane_mosaic.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Returns the surface of a map whose longer side covers `tile_metres`. If the lengths of normals include roughness,
/// they become its material.
GainSurface surface_of_mosaic(const MapMosaic& mosaic, double tile_metres);

struct ModelSurface {
  std::string material;  // name of the first material with these textures
  std::string kept;      // reason why the material is not measured; empty if `surface` is set
  std::optional<GainSurface> surface;
  double roughness = 1.0;  // roughness factor
};

/// Returns the surfaces of a model, one per set of textures. Images are stored in `folder`. Blocks of the mosaic are
/// taken where triangles are. The model is drawn from `distances`, in metres. Throws Error(kInput).
std::vector<ModelSurface> surfaces_of_model(const GltfAsset& asset, const std::string& folder,
                                            const std::vector<double>& distances, int threads, Progress* progress);

}  // namespace multum
