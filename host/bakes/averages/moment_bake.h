// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of moments (host/formats/asset/averages/moment_mipmap.h). Every texel of every
// level is the plain average of the finest texels that it covers (host/bakes/pyramid/average_pass.h).
#pragma once

#include "host/bakes/pyramid/average_pass.h"
#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Receives finished rows. The rows of a level arrive in order from the top. Levels can arrive in any order.
class MomentSink {
 public:
  virtual ~MomentSink() = default;
  virtual void add_level(int level, int first_row, MomentLevel rows) = 0;
};

/// Passes rows to `sink` as floats, before they are rounded for storage (quantize_moments). Fills the device, plan and
/// counts of `report`. Errors and progress are the same as for average_map().
void bake_moments(Device& device, const AverageInputs& inputs, MomentSink& sink, AverageReport& report,
                  Progress* progress);

/// Bakes maps in memory into a whole mipmap. `albedo` may be null. The header contains sizes only.
MomentMipmap bake_moments(Device& device, const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs,
                          AverageReport& report, Progress* progress);

}  // namespace multum
