// SPDX-License-Identifier: Apache-2.0
// Predicts the processor time of the shares of one map (host/bakes/movmf/map_shard.h) by a model with few constants. A
// farm's time limits and the useful number of shares follow from this prediction.
#pragma once

#include <vector>

#include "host/bakes/movmf/map_shard.h"
#include "host/bakes/scene/bake_cost.h"

namespace multum {

struct ShareCost {
  int coarse_from = 0;                 // share 0 fits this level and the coarser ones
  double coarse_seconds = 0.0;         // processor time of share 0
  std::vector<double> band_seconds{};  // processor time of shares 1 to N
  double merge_seconds = 0.0;

  double total_seconds() const;
  double band_seconds_max() const;
};

/// Returns the processor time of a bake by one process, for any representation.
double bake_processor_seconds(const BakeShape& shape);

/// Throws Error(kUsage), as plan_shard() does, for too many bands or for a fit that cannot be divided.
ShareCost share_cost(const BakeShape& shape, const MovmfSettings& settings, int count);

/// Returns the number of bands into which a map should be divided if each band may take about `share_seconds`. Returns
/// 0 if one process should bake the map, because the bake is short or its fit cannot be divided.
int share_count_of(const BakeShape& shape, const MovmfSettings& settings, double share_seconds);

}  // namespace multum
