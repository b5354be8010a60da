// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of spherical harmonics (host/formats/asset/averages/sh_mipmap.h). Each texel is
// the plain average of Y_lm over the finest normals that it covers (Han et al. 2007, section 5;
// host/bakes/pyramid/average_pass.h).
#pragma once

#include "host/bakes/pyramid/average_pass.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/image/normals/normal_map.h"

namespace multum {

/// Receives finished rows. The rows of a level arrive in order from the top. Levels can arrive in any order.
class ShSink {
 public:
  virtual ~ShSink() = default;
  virtual void add_level(int level, int first_row, ShLevel rows) = 0;
};

/// Throws Error(kUsage) if the order is out of range.
void validate_sh_order(int order);

/// Passes rows to `sink` as floats, before they are rounded for storage (quantize_sh). Fills the device and plan of
/// `report`. Errors and progress are the same as for average_map().
void bake_sh(Device& device, int order, const AverageInputs& inputs, ShSink& sink, AverageReport& report,
             Progress* progress);

/// Bakes maps in memory into a whole mipmap. `albedo` may be null. The header contains sizes only.
ShMipmap bake_sh(Device& device, int order, const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs,
                 AverageReport& report, Progress* progress);

}  // namespace multum
