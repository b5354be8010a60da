// SPDX-License-Identifier: Apache-2.0
// A job of the bake service, as the queue has it. docs/reference/service.md draws its states.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/log/wall_clock.h"

namespace multum {

enum class JobState {
  kWaiting,     // for jobs that it needs
  kQueued,      // may be started, at once or after its back-off
  kRunning,     // a worker has a lease on it
  kPublishing,  // done; its result is being given its name
  kSucceeded,   // its result is in place
  kDead,        // failed for good; `retry` queues it again
  kCancelled,
};

constexpr bool is_final(JobState state) { return state >= JobState::kSucceeded; }

/// "waiting" ... "cancelled".
const char* job_state_name(JobState state);
std::optional<JobState> parse_job_state(const std::string& name);

/// What clients say of a job. Each member of it and of Job has a row in job_fields.cpp.
struct JobSubmission {
  std::string type;               // of job_types.h
  std::string parameters = "{}";  // JSON object, checked against the type
  std::string queue = "default";
  std::string label;                // free text
  int priority = 0;                 // -1000..1000, higher first
  std::vector<std::int64_t> needs;  // jobs that must succeed before
  int attempt_max = 5;              // 1..100
  std::optional<TimeMs> deadline;   // not to be finished after it
  std::int64_t memory_bytes = 0;    // what it may take
  std::string device;               // "" or the device's name in the settings
  std::string output;               // absolute path of the result; "": none
  std::string key;                  // idempotency key; "": none
  std::string inputs;               // input_identity() of what the key was made of
};

struct Job : JobSubmission {
  std::int64_t id = 0;
  JobState state = JobState::kQueued;
  int attempt = 0;     // that runs or ran last, from 1
  std::string owner;   // of the lease
  int needs_left = 0;  // of `needs`, not yet succeeded
  TimeMs created = 0;
  std::optional<TimeMs> not_before, started, finished;
  std::optional<int> exit_code;             // of the last attempt
  std::string message;                      // why it is where it is, for people
  std::optional<std::int64_t> reused_from;  // the job whose result was taken instead of making it again
  int attempts_counted = 0;                 // against attempt_max
  std::string result_identity;              // of what was published last; "": nothing was
  std::string stop_asked;  // why it is to be cancelled as soon as its attempt ends without a result; "": it is not
};

enum class AttemptOutcome {
  kRunning,
  kSucceeded,
  kFailed,     // exit code that trying again may mend
  kRefused,    // usage or input error: trying again is of no use
  kLost,       // the worker died, or hung, or the daemon did
  kCancelled,  // by a person or a deadline
  kReturned,   // handed back by a daemon that was asked to end; does not count
};

const char* attempt_outcome_name(AttemptOutcome outcome);

/// Name under which a daemon holds the leases of jobs that it has sent to Slurm: they outlive it.
std::string slurm_owner(const std::string& instance);
bool is_slurm_owner(const std::string& owner);

struct JobAttempt {
  int number = 0;
  std::string owner;
  AttemptOutcome outcome = AttemptOutcome::kRunning;
  TimeMs started = 0;
  std::optional<TimeMs> ended;
  std::optional<int> exit_code;
  std::string message;
};

}  // namespace multum
