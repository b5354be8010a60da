// SPDX-License-Identifier: Apache-2.0
// Writes jobs in the form of the web interface (docs/reference/openapi.json has their schema).
#pragma once

#include <nlohmann/json.hpp>

#include "host/farm/service/ledger/job.h"
#include "host/farm/service/ledger/slurm_notes.h"

namespace multum {

/// Writes paths as texts (path_text.h), except in `parameters`, where paths stay as submitted.
nlohmann::json job_json(const Job& job);
/// Writes a job on one line, for events.
std::string job_text(const Job& job);
/// Writes a part as stored in the ledger.
nlohmann::json part_json(const SlurmPart& part);
nlohmann::json attempt_json(const JobAttempt& attempt);

}  // namespace multum
