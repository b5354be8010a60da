// SPDX-License-Identifier: Apache-2.0
// The schemas of docs/reference/openapi.json that follow from the fields of jobs and from their types.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace multum {

/// By name: Submission, the parameters of each type, Job and what is more of it in lists and by itself.
nlohmann::ordered_json job_schemas();

}  // namespace multum
