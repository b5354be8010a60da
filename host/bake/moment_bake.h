// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of moments (host/asset/moment_mipmap.h): every texel of every level is the
// plain average of what it covers of the finest. The map is read once, by bands of rows, whatever its size;
// kernels/moments.cl makes all levels of a band at once, and nothing but a sum a column stays from band to band.
#pragma once

#include <cstdint>

#include "host/asset/moment_mipmap.h"
#include "host/bake/bake_report.h"
#include "host/base/progress.h"
#include "host/image/material_maps.h"
#include "host/image/normal_map.h"
#include "host/image/plane_store.h"
#include "host/opencl/device.h"

namespace multum {

/// Takes rows as they are done: of each level in order from the top, levels in any order.
class MomentSink {
 public:
  virtual ~MomentSink() = default;
  virtual void add_level(int level, int first_row, MomentLevel rows) = 0;
};

struct MomentBakeInputs {
  const PlaneStore* normals = nullptr;
  const PlaneStore* albedo = nullptr;                   // of the same size; null: no colours
  const WeightMap* weights = nullptr;                   // of the same size; null: none
  bool has_roughness = false;                           // normals are shortened (host/image/material_maps.h)
  int first_level = 0;                                  // the finest to make
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // for buffers; changes no byte of the result
  int threads = 1;                                      // of the host's own loops
};

/// Throws Error(kInput) for a map that is too large, Error(kUsage) for a first level that the map has not.
void validate_moments(int first_level, int map_width, int map_height);

/// Hands rows to `sink`, exact to float, not yet rounded to what the file stores (quantize_moments). Fills device, plan
/// and counts of `report`. Throws Error(kUsage) for too little memory, Error(kEnvironment) when disk or device refuse,
/// Cancelled. Progress: a unit a texel of the map.
void bake_moments(Device& device, const MomentBakeInputs& inputs, MomentSink& sink, BakeReport& report,
                  Progress* progress);

/// The same as a whole, of maps in memory; `albedo` may be null. The header has sizes alone.
MomentMipmap bake_moments(Device& device, const NormalMap& map, const ColourMap* albedo, const MomentBakeInputs& inputs,
                          BakeReport& report, Progress* progress);

}  // namespace multum
