// SPDX-License-Identifier: Apache-2.0
// Predicts the processor time of the shares of one map (host/bakes/movmf/map_shard.h), by a model of few constants: how
// many shares are worth it, and what a farm's time limits should be, follow from it.
#pragma once

#include <vector>

#include "host/bakes/movmf/map_shard.h"
#include "host/bakes/scene/bake_cost.h"

namespace multum {

struct ShareCost {
  int coarse_from = 0;                 // share 0 fits this level and the coarser ones
  double coarse_seconds = 0.0;         // of processor time, of share 0
  std::vector<double> band_seconds{};  // of shares 1 to N
  double merge_seconds = 0.0;

  double total_seconds() const;
  double band_seconds_max() const;
};

/// The same of a bake by one process, of any representation.
double bake_processor_seconds(const BakeShape& shape);

/// Throws Error(kUsage) as plan_shard() does: too many bands, or a fit that is not divided.
ShareCost share_cost(const BakeShape& shape, const MovmfSettings& settings, int count);

/// How many bands of at most about so many seconds a map is worth; 0: it is one process's, by its time or because its
/// fit is not divided.
int share_count_of(const BakeShape& shape, const MovmfSettings& settings, double share_seconds);

}  // namespace multum
