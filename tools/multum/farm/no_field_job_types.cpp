// SPDX-License-Identifier: Apache-2.0
// Replaces field_job_types.cpp in a build without fields.
#include "tools/multum/farm/multum_job_types.h"

namespace multum {

std::vector<JobType> field_job_types() { return {}; }

}  // namespace multum
