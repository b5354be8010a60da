// SPDX-License-Identifier: Apache-2.0
// Inputs of a bake of lobes, where its rows go, and its units of progress: for host/bakes/movmf/movmf_bake.h and all
// that it calls.
#pragma once

#include <cstdint>

#include "host/bakes/movmf/bake_checkpoint.h"
#include "host/bakes/movmf/map_shard.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/bakes/pyramid/row_store.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

/// Texels [x0, x1) x [y0, y1) of a level.
struct TexelRange {
  int x0, y0, x1, y1;
};

/// Takes what a bake makes, exact to float: rows of a level in order from its first, coarse levels first, but rows of
/// level 0 between those of level 1.
class MovmfSink {
 public:
  virtual ~MovmfSink() = default;
  virtual void add_level(int level, int first_row, MovmfLevel rows) = 0;
  virtual void add_finest(int first_row, MovmfFinest rows) = 0;
};

/// A part of a baked map that is fitted again, beside the rest as it is.
class RegionInputs {
 public:
  virtual ~RegionInputs() = default;
  /// The texels of a level that are fitted.
  virtual TexelRange range(int level) const = 0;
  /// The level's lobes as they are, by rows [lobe][column].
  virtual RowStore kept(int level) const = 0;
};

class GatheredShards;
class StartMemory;

/// One process's share of a map (host/bakes/movmf/map_shard.h).
struct ShardInputs {
  MapShard shard;
  ShardWriter* writer = nullptr;  // takes the rows; the sink takes none
  ShardReader* coarse = nullptr;  // of a band: share 0
};

struct MovmfBakeInputs : MapInputs {
  std::uint64_t writer_bytes = 0;              // of memory_bytes, what the sink holds while levels are fitted
  SpillPolicy spill{.memory_bytes = 4 << 20};  // of what does not fit in memory
  BakeCheckpoint* checkpoint = nullptr;        // null: nothing is kept for another process
  bool checkpoint_has_finest = true;           // false: of the finest level that is fitted it keeps nothing
  const RegionInputs* region = nullptr;        // null: the whole map
  const ShardInputs* shard = nullptr;          // null: all of it
  GatheredShards* gathered = nullptr;          // null: levels are fitted
  StartMemory* starts = nullptr;               // of bakes of this map; null: each searches its start
};

/// Units of progress that a bake of lobes advances by.
inline std::uint64_t movmf_bake_units(int width, int height, int first_level = 0) {
  return static_cast<std::uint64_t>(mip_level_count(width, height) - first_level) * static_cast<std::uint64_t>(width) *
         static_cast<std::uint64_t>(height);
}

}  // namespace multum
