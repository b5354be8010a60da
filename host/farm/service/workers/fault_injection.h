// SPDX-License-Identifier: Apache-2.0
// Jobs that do nothing, or fail as asked (docs/SERVICE.md, "Drills").
#pragma once

#include "host/farm/service/workers/job_types.h"

namespace multum {

/// "drill".
JobType drill_job_type();

}  // namespace multum
