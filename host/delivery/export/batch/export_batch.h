// SPDX-License-Identifier: Apache-2.0
// Makes the jobs of exports: from parameters, from several maps or sets (host/foundation/base/files/udim_set.h), from a
// manifest.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/export_job.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// What was given of export_parameters() replaces what the job has.
void apply(const ParameterValues& values, ExportJob& job);

/// One job a map; each is `pattern` with its own paths. Where there is one map and no `<UDIM>`, that is `pattern` with
/// its input. Else pattern.output, and pattern.report if there is one, is a folder that exists, where files are named
/// after the maps (NAME_normal.ktx2; of images a level a folder NAME), or holds `<UDIM>`; in the names of the maps
/// beside it `<UDIM>` is the map's tile. Throws Error(kUsage) for names that do not fit together or that two maps would
/// share, Error(kInput) when a set has no tile.
std::vector<ExportJob> make_export_jobs(const ExportJob& pattern, const std::vector<std::string>& inputs);

}  // namespace multum
