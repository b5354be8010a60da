// SPDX-License-Identifier: Apache-2.0
// In the place of field_job_types.cpp where fields are not built.
#include "tools/multum/farm/multum_job_types.h"

namespace multum {

std::vector<JobType> field_job_types() { return {}; }

}  // namespace multum
