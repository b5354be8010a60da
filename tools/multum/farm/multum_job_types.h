// SPDX-License-Identifier: Apache-2.0
// The types of jobs that multum's farm runs: a row for each of its commands that a service takes.
#pragma once

#include <vector>

#include "host/farm/service/workers/job_types.h"

namespace multum {

/// bake, scene, infer, pack, export: for register_job_types().
std::vector<JobType> multum_job_types();

/// infer, pack.
std::vector<JobType> field_job_types();

}  // namespace multum
