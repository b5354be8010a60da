// SPDX-License-Identifier: Apache-2.0
// Makes the jobs of a run over several maps: names given one by one, and UDIM sets
// (host/foundation/base/files/udim_set.h).
#pragma once

#include <string>
#include <vector>

#include "host/bakes/bake/bake_job.h"

namespace multum {

/// One job a map, in the order given, tiles in the order of their numbers; each is `pattern` with its own paths.
/// Where there is one map and no `<UDIM>`, that is `pattern` with its input. Else pattern.output, and pattern.report if
/// there is one, is a folder that exists (files are named after the maps) or holds `<UDIM>` (then every input does);
/// `<UDIM>` in the names of the material's maps is the map's tile. Throws Error(kUsage) for names that do not fit
/// together or that two maps would share, Error(kInput) when a set has no tile.
std::vector<BakeJob> make_bake_jobs(const BakeJob& pattern, const std::vector<std::string>& inputs);

}  // namespace multum
