// SPDX-License-Identifier: Apache-2.0
// Makes the schemas of docs/reference/openapi.json that follow from the fields and types of jobs.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace multum {

/// Returns schemas by name. These are Submission, the parameters of each type, Job, and its extra fields in lists and
/// in single answers.
nlohmann::ordered_json job_schemas();

}  // namespace multum
