// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of spherical harmonics (host/formats/asset/averages/sh_mipmap.h): of every
// texel the plain average of Y_lm over what it covers of the finest normals (Han et al. 2007, section 5;
// host/bakes/pyramid/average_pass.h).
#pragma once

#include "host/bakes/pyramid/average_pass.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/image/normals/normal_map.h"

namespace multum {

/// Takes rows as they are done: of each level in order from the top, levels in any order.
class ShSink {
 public:
  virtual ~ShSink() = default;
  virtual void add_level(int level, int first_row, ShLevel rows) = 0;
};

/// Throws Error(kUsage) for an order out of its range.
void validate_sh_order(int order);

/// Hands rows to `sink`, exact to float, not yet rounded to what the file stores (quantize_sh). Fills device and plan
/// of `report`. Throws and counts as average_map() does.
void bake_sh(Device& device, int order, const AverageInputs& inputs, ShSink& sink, AverageReport& report,
             Progress* progress);

/// The same as a whole, of maps in memory; `albedo` may be null. The header has sizes alone.
ShMipmap bake_sh(Device& device, int order, const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs,
                 AverageReport& report, Progress* progress);

}  // namespace multum
