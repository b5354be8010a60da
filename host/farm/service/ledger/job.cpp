// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/job.h"

#include <array>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr std::array kStateNames = {"waiting", "queued", "running", "publishing", "succeeded", "dead", "cancelled"};
constexpr const char* kSlurmSuffix = ":slurm";  // worker names end in a number
constexpr std::array kOutcomeNames = {"running", "succeeded", "failed", "refused", "lost", "cancelled", "returned"};

}  // namespace

const char* job_state_name(JobState state) { return kStateNames.at(static_cast<std::size_t>(state)); }

std::optional<JobState> parse_job_state(const std::string& name) {
  for (std::size_t i = 0; i < kStateNames.size(); ++i)
    if (name == kStateNames[i]) return static_cast<JobState>(i);
  return std::nullopt;
}

std::string slurm_owner(const std::string& instance) { return instance + kSlurmSuffix; }
bool is_slurm_owner(const std::string& owner) { return owner.ends_with(kSlurmSuffix); }

const char* attempt_outcome_name(AttemptOutcome outcome) { return kOutcomeNames.at(static_cast<std::size_t>(outcome)); }

}  // namespace multum
