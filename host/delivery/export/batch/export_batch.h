// SPDX-License-Identifier: Apache-2.0
// Makes export jobs from parameters, from several maps or sets (host/foundation/base/files/udim_set.h), or from a
// manifest.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/export_job.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Replaces the job's values with the given values of export_parameters().
void apply(const ParameterValues& values, ExportJob& job);

/// Makes one job per map. Each job is `pattern` with its own paths. A single map without `<UDIM>` keeps the pattern's
/// output and report names. Otherwise pattern.output, and pattern.report if it is set, must be an existing folder or
/// contain `<UDIM>`. Files in a folder are named after the maps: NAME_normal.ktx2, or a folder NAME if each level is an
/// image. In the names of the other maps, `<UDIM>` is replaced by the map's tile. Throws Error(kUsage) if names
/// contradict each other or if two maps would have the same name. Throws Error(kInput) if a set has no tiles.
std::vector<ExportJob> make_export_jobs(const ExportJob& pattern, const std::vector<std::string>& inputs);

/// Returns how many of the jobs can run at the same time with the threads and the memory of the first job, and divides
/// this memory among so many jobs. `jobs` is not empty.
int share_memory(const std::vector<ExportJob*>& jobs);

}  // namespace multum
