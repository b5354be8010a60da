// SPDX-License-Identifier: Apache-2.0
// Jobs as the web interface shows them (docs/reference/openapi.json has their schema).
#pragma once

#include <nlohmann/json.hpp>

#include "host/farm/service/ledger/job.h"
#include "host/farm/service/ledger/slurm_notes.h"

namespace multum {

/// Paths are texts (path_text.h), in `parameters` too, as they were submitted.
nlohmann::json job_json(const Job& job);
/// A job as events have it, in one line.
std::string job_text(const Job& job);
/// A part as the ledger has it.
nlohmann::json part_json(const SlurmPart& part);
nlohmann::json attempt_json(const JobAttempt& attempt);

}  // namespace multum
