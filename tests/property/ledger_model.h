// SPDX-License-Identifier: Apache-2.0
// Models the ledger in memory by brute force. At each call, the model applies every rule of docs/reference/service.md
// to all jobs again. Its calls and answers are the same as those of JobQueue.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/farm/service/ledger/job_queue.h"

namespace multum::testing {

class LedgerModel {
 public:
  struct ModelJob : JobSubmission {
    JobState state = JobState::kQueued;
    int attempt = 0, counted = 0, successes = 0;
    std::string owner, stop_asked;
    std::optional<TimeMs> not_before, finished;
  };
  using Ids = std::vector<std::int64_t>;

  explicit LedgerModel(RetryPolicy policy) : policy_(policy) {}

  const std::map<std::int64_t, ModelJob>& jobs() const { return jobs_; }
  const std::map<std::int64_t, std::string>& left_overs() const { return left_overs_; }
  std::int64_t highest() const { return highest_; }
  bool knows(std::int64_t id) const { return jobs_.contains(id); }
  int needs_left(std::int64_t id) const;
  std::optional<TimeMs> next_due() const;

  /// If null, the submission is refused.
  std::optional<SubmitResult> submit(const JobSubmission& submission);
  std::optional<std::int64_t> claim(const ClaimLimits& limits, const std::string& owner, TimeMs now);
  bool begin_publishing(std::int64_t id, const std::string& owner, int attempt);
  void published(std::int64_t id, TimeMs now);
  void publishing_failed(std::int64_t id, TimeMs now);
  bool ended(std::int64_t id, const std::string& owner, int attempt, AttemptOutcome outcome, TimeMs now);
  CancelResult cancel(std::int64_t id, const std::string& why, TimeMs now);
  std::set<std::int64_t> retry(std::int64_t id, TimeMs now);
  std::set<std::int64_t> retry_dead(const std::string& queue, TimeMs now);
  std::set<std::int64_t> expire(TimeMs now);
  void forgive_back_offs(TimeMs now);
  Ids purge(const Ids& ids, const std::string& results);
  void restart(TimeMs now);

 private:
  bool has_lease(std::int64_t id, const std::string& owner, int attempt) const;
  void again_or_dead(ModelJob& job, AttemptOutcome outcome, TimeMs now);
  void finish(ModelJob& job, JobState state, TimeMs now);
  void settle(TimeMs now);
  bool lacks(const ModelJob& job) const;

  RetryPolicy policy_;
  std::map<std::int64_t, ModelJob> jobs_;
  std::map<std::int64_t, std::string> left_overs_;
  std::int64_t highest_ = 0;
};

}  // namespace multum::testing
