// SPDX-License-Identifier: Apache-2.0
// Defines "drill", a type of job for tests of the farm. Such a job does nothing, or it ends in the way that its
// parameters specify.
#pragma once

#include "host/farm/service/workers/job_types.h"

namespace multum {

/// For register_job_types().
JobType drill_job_type();

}  // namespace multum
