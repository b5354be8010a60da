// SPDX-License-Identifier: Apache-2.0
// Makes the jobs of a run over several maps: single names and UDIM sets (host/foundation/base/files/udim_set.h).
#pragma once

#include <string>
#include <vector>

#include "host/bakes/bake/bake_job.h"

namespace multum {

/// Returns one job per map, in the given order, with the tiles of a set in the order of their numbers. Each job is a
/// copy of `pattern` with its own paths. A single map without `<UDIM>` gives `pattern` with this map as its input. With
/// several maps, pattern.output (and pattern.report, if set) is either an existing folder or contains `<UDIM>`. Files
/// in a folder are named after the maps. If the output contains `<UDIM>`, every input must contain it. `<UDIM>` in the
/// names of material maps is replaced by the map's tile. Throws Error(kUsage) for names that contradict each other or
/// that two maps would share, and Error(kInput) for a set without tiles.
std::vector<BakeJob> make_bake_jobs(const BakeJob& pattern, const std::vector<std::string>& inputs);

}  // namespace multum
