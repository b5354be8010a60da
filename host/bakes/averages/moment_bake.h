// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of moments (host/formats/asset/averages/moment_mipmap.h): every texel of every
// level is the plain average of what it covers of the finest (host/bakes/pyramid/average_pass.h).
#pragma once

#include "host/bakes/pyramid/average_pass.h"
#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Takes rows as they are done: of each level in order from the top, levels in any order.
class MomentSink {
 public:
  virtual ~MomentSink() = default;
  virtual void add_level(int level, int first_row, MomentLevel rows) = 0;
};

/// Hands rows to `sink`, exact to float, not yet rounded to what the file stores (quantize_moments). Fills device, plan
/// and counts of `report`. Throws and counts as average_map() does.
void bake_moments(Device& device, const AverageInputs& inputs, MomentSink& sink, AverageReport& report,
                  Progress* progress);

/// The same as a whole, of maps in memory; `albedo` may be null. The header has sizes alone.
MomentMipmap bake_moments(Device& device, const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs,
                          AverageReport& report, Progress* progress);

}  // namespace multum
