// SPDX-License-Identifier: Apache-2.0
// A job of the bake service, as stored in the queue. docs/reference/service.md draws its states.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/log/wall_clock.h"

namespace multum {

enum class JobState {
  kWaiting,     // waits for the jobs that it needs
  kQueued,      // may start, at once or after its back-off
  kRunning,     // a worker holds a lease on it
  kPublishing,  // done; its result is about to get its final name
  kSucceeded,   // the result is in its place
  kDead,        // failed permanently; `retry` queues the job again
  kCancelled,
};

constexpr bool is_final(JobState state) { return state >= JobState::kSucceeded; }

/// Returns "waiting" ... "cancelled".
const char* job_state_name(JobState state);
std::optional<JobState> parse_job_state(const std::string& name);

/// The part of a job that clients set. Each member of this struct and of Job has a row in job_fields.cpp.
struct JobSubmission {
  std::string type;               // a type of job_types.h
  std::string parameters = "{}";  // JSON object, checked against the type
  std::string queue = "default";
  std::string label;                // free text
  int priority = 0;                 // -1000..1000, higher values first
  std::vector<std::int64_t> needs;  // jobs that must succeed first
  int attempt_max = 5;              // 1..100
  std::optional<TimeMs> deadline;   // latest time at which the job may end
  std::int64_t memory_bytes = 0;    // memory that the service reserves for the job
  std::string device;               // "" or a device name of the settings
  std::string output;               // absolute path of the result; "" if none
  std::string key;                  // idempotency key; "" if none
  std::string inputs;               // input_identity() of the files that the key covers
};

struct Job : JobSubmission {
  std::int64_t id = 0;
  JobState state = JobState::kQueued;
  int attempt = 0;     // current or last attempt, from 1
  std::string owner;   // holder of the lease
  int needs_left = 0;  // number of `needs` that have not yet succeeded
  TimeMs created = 0;
  std::optional<TimeMs> not_before, started, finished;
  std::optional<int> exit_code;             // exit code of the last attempt
  std::string message;                      // human-readable reason for its state
  std::optional<std::int64_t> reused_from;  // the job whose result was copied instead of making it again
  int attempts_counted = 0;                 // attempts that count against attempt_max
  std::string result_identity;              // identity of the last published result; "" if none
  std::string stop_asked;  // why the job is cancelled if its attempt ends without a result; "" if it is not to be
                           // cancelled
};

enum class AttemptOutcome {
  kRunning,
  kSucceeded,
  kFailed,     // the exit code allows another attempt
  kRefused,    // usage or input error: another attempt would fail too
  kLost,       // the worker died or hung, or the daemon died
  kCancelled,  // a person or a deadline cancelled it
  kReturned,   // handed back by a daemon that shut down; does not count as an attempt
};

const char* attempt_outcome_name(AttemptOutcome outcome);

/// The owner of leases for jobs that a daemon has sent to Slurm. Such leases outlive the daemon.
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
