// SPDX-License-Identifier: Apache-2.0
// Lists the types of jobs that the farm of multum runs. There is one row for each command that a service accepts.
#pragma once

#include <vector>

#include "host/farm/service/workers/job_types.h"

namespace multum {

/// Returns the types bake, scene, infer, pack and export, for register_job_types().
std::vector<JobType> multum_job_types();

/// infer, pack.
std::vector<JobType> field_job_types();

}  // namespace multum
