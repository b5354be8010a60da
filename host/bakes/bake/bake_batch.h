// SPDX-License-Identifier: Apache-2.0
// Makes the jobs of a run over several maps, which are given as single names and as UDIM sets
// (host/foundation/base/files/udim_set.h).
#pragma once

#include <string>
#include <vector>

#include "host/bakes/bake/bake_job.h"

namespace multum {

/// Returns one job per map, in the given order, with the tiles of a set in the order of their numbers. Each job is a
/// copy of `pattern` with its own paths. For a single map without `<UDIM>`, the result is `pattern` with this map as
/// its input. If there are several maps, pattern.output (and pattern.report, if set) must be an existing folder or
/// contain `<UDIM>`. Files in a folder are named after the maps. If the output contains `<UDIM>`, every input must
/// contain it. `<UDIM>` in the names of material maps is replaced by the map's tile. Throws Error(kUsage) if names
/// contradict each other or if two maps would have the same name. Throws Error(kInput) for a set without tiles.
std::vector<BakeJob> make_bake_jobs(const BakeJob& pattern, const std::vector<std::string>& inputs);

}  // namespace multum
