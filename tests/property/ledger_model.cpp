// SPDX-License-Identifier: Apache-2.0
#include "tests/property/ledger_model.h"

#include <algorithm>
#include <tuple>

namespace multum::testing {

int LedgerModel::needs_left(std::int64_t id) const {
  int left = 0;
  for (const std::int64_t need : jobs_.at(id).needs)
    left += knows(need) && jobs_.at(need).state == JobState::kSucceeded ? 0 : 1;
  return left;
}

std::optional<TimeMs> LedgerModel::next_due() const {
  std::optional<TimeMs> due;
  for (const auto& [id, job] : jobs_) {
    if (job.state == JobState::kQueued && job.not_before)
      due = std::min(due.value_or(*job.not_before), *job.not_before);
    if (job.state <= JobState::kRunning && job.deadline) due = std::min(due.value_or(*job.deadline), *job.deadline);
  }
  return due;
}

std::optional<SubmitResult> LedgerModel::submit(const JobSubmission& submission) {
  if (!submission.key.empty())
    for (auto same = jobs_.rbegin(); same != jobs_.rend(); ++same) {
      const ModelJob& job = same->second;
      if (job.key != submission.key || job.output != submission.output) continue;
      if (job.state == JobState::kDead || job.state == JobState::kCancelled) continue;
      if (job.state != JobState::kSucceeded && !job.stop_asked.empty()) continue;
      return SubmitResult{same->first, false};
    }
  for (const std::int64_t need : submission.needs)
    if (!knows(need) || jobs_.at(need).state > JobState::kSucceeded) return std::nullopt;
  ModelJob job;
  static_cast<JobSubmission&>(job) = submission;
  const std::set<std::int64_t> needs(job.needs.begin(), job.needs.end());
  job.needs.assign(needs.begin(), needs.end());
  jobs_[++highest_] = job;
  if (needs_left(highest_) > 0) jobs_[highest_].state = JobState::kWaiting;
  return SubmitResult{highest_, true};
}

std::optional<std::int64_t> LedgerModel::claim(const ClaimLimits& limits, const std::string& owner, TimeMs now) {
  const auto used = [&](const std::string* queue, const std::string* device) {
    std::pair<int, std::int64_t> use;
    for (const auto& [id, job] : jobs_)
      if ((job.state == JobState::kRunning || job.state == JobState::kPublishing) &&
          (queue == nullptr || job.queue == *queue) && (device == nullptr || job.device == *device)) {
        ++use.first;
        use.second += job.memory_bytes;
      }
    return use;
  };
  const auto fits = [](std::pair<int, std::int64_t> use, const ModelJob& job, std::int64_t most) {
    return most <= 0 || use.first == 0 || use.second + job.memory_bytes <= most;
  };
  // For each queue with a free device, holds the queue's priority, and the priority and age of the first job that may
  // run.
  std::vector<std::tuple<int, int, std::int64_t>> firsts;
  for (const auto& [name, of_queue] : limits.queues) {
    if (of_queue.is_paused || used(&name, nullptr).first >= of_queue.jobs_max) continue;
    std::vector<std::tuple<int, int, std::int64_t>> ranks;
    for (const auto& [id, job] : jobs_) {
      if (job.queue != name || job.state != JobState::kQueued || job.not_before.value_or(now) > now) continue;
      const auto device = limits.device_jobs_max.find(job.device);
      if (device != limits.device_jobs_max.end() && used(nullptr, &job.device).first >= device->second) continue;
      ranks.emplace_back(-of_queue.priority, -job.priority, id);
    }
    if (ranks.empty()) continue;
    const auto first = *std::min_element(ranks.begin(), ranks.end());
    if (fits(used(&name, nullptr), jobs_.at(std::get<2>(first)), of_queue.memory_max)) firsts.push_back(first);
  }
  if (firsts.empty()) return std::nullopt;
  const std::int64_t id = std::get<2>(*std::min_element(firsts.begin(), firsts.end()));
  ModelJob& job = jobs_.at(id);
  if (!fits(used(nullptr, nullptr), job, limits.memory_max)) return std::nullopt;
  job.state = JobState::kRunning;
  job.owner = owner;
  ++job.attempt;
  ++job.counted;
  job.not_before.reset();
  return id;
}

bool LedgerModel::has_lease(std::int64_t id, const std::string& owner, int attempt) const {
  if (!knows(id)) return false;
  const ModelJob& job = jobs_.at(id);
  return job.state == JobState::kRunning && job.owner == owner && job.attempt == attempt;
}

bool LedgerModel::begin_publishing(std::int64_t id, const std::string& owner, int attempt) {
  if (!has_lease(id, owner, attempt)) return false;
  jobs_.at(id).state = JobState::kPublishing;
  return true;
}

void LedgerModel::finish(ModelJob& job, JobState state, TimeMs now) {
  job.state = state;
  job.owner.clear();
  job.finished = now;
  job.not_before.reset();
  job.successes += state == JobState::kSucceeded ? 1 : 0;
  settle(now);
}

// A job that waits for a failed job is dead; a job that waits for nothing may run.
void LedgerModel::settle(TimeMs now) {
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (auto& [id, job] : jobs_) {
      if (job.state != JobState::kWaiting) continue;
      if (lacks(job)) {
        job.state = JobState::kDead;
        job.finished = now;
        is_changed = true;
      } else if (needs_left(id) == 0) {
        job.state = JobState::kQueued;
        is_changed = true;
      }
    }
  }
}

bool LedgerModel::lacks(const ModelJob& job) const {
  return std::any_of(job.needs.begin(), job.needs.end(), [&](std::int64_t need) {
    return !knows(need) || jobs_.at(need).state == JobState::kDead || jobs_.at(need).state == JobState::kCancelled;
  });
}

void LedgerModel::published(std::int64_t id, TimeMs now) { finish(jobs_.at(id), JobState::kSucceeded, now); }

void LedgerModel::publishing_failed(std::int64_t id, TimeMs now) {
  again_or_dead(jobs_.at(id), AttemptOutcome::kFailed, now);
}

bool LedgerModel::ended(std::int64_t id, const std::string& owner, int attempt, AttemptOutcome outcome, TimeMs now) {
  if (!has_lease(id, owner, attempt)) return false;
  ModelJob& job = jobs_.at(id);
  if (outcome == AttemptOutcome::kSucceeded) finish(job, JobState::kSucceeded, now);
  else if (outcome == AttemptOutcome::kCancelled) finish(job, JobState::kCancelled, now);
  else again_or_dead(job, outcome, now);
  return true;
}

void LedgerModel::again_or_dead(ModelJob& job, AttemptOutcome outcome, TimeMs now) {
  if (!job.stop_asked.empty()) return finish(job, JobState::kCancelled, now);
  if (outcome == AttemptOutcome::kReturned) --job.counted;
  if (outcome == AttemptOutcome::kRefused || job.counted >= job.attempt_max) return finish(job, JobState::kDead, now);
  job.state = JobState::kQueued;
  job.owner.clear();
  job.not_before.reset();
  if (outcome == AttemptOutcome::kReturned) return;
  TimeMs back_off = policy_.back_off_first;
  for (int i = 1; i < job.counted; ++i) back_off = std::min(2 * back_off, policy_.back_off_max);
  job.not_before = now + std::min(back_off, policy_.back_off_max);
}

CancelResult LedgerModel::cancel(std::int64_t id, const std::string& why, TimeMs now) {
  if (!knows(id)) return CancelResult::kUnknown;
  ModelJob& job = jobs_.at(id);
  if (job.state == JobState::kRunning) {
    job.stop_asked = why;
    return CancelResult::kStopWorker;
  }
  if (job.state >= JobState::kPublishing) return CancelResult::kTooLate;
  finish(job, JobState::kCancelled, now);
  return CancelResult::kCancelled;
}

std::set<std::int64_t> LedgerModel::retry(std::int64_t id, TimeMs now) {
  const auto is_failed = [&](std::int64_t job) {
    return knows(job) && (jobs_.at(job).state == JobState::kDead || jobs_.at(job).state == JobState::kCancelled);
  };
  if (!is_failed(id)) return {};
  std::set<std::int64_t> again = {id};
  for (std::size_t before = 0; before != again.size();) {
    before = again.size();
    for (const std::int64_t job : std::set<std::int64_t>(again))
      for (const std::int64_t need : jobs_.at(job).needs) {
        if (!knows(need)) return {};
        if (is_failed(need)) again.insert(need);
      }
  }
  for (std::size_t before = 0; before != again.size();) {
    before = again.size();
    for (const auto& [other, job] : jobs_) {
      if (job.state != JobState::kDead || job.counted != 0) continue;
      if (job.deadline && *job.deadline <= now) continue;  // its own time limit has passed
      const auto is_again = [&](std::int64_t need) { return again.contains(need); };
      const auto is_well = [&](std::int64_t need) { return is_again(need) || (knows(need) && !is_failed(need)); };
      if (std::any_of(job.needs.begin(), job.needs.end(), is_again) &&
          std::all_of(job.needs.begin(), job.needs.end(), is_well))
        again.insert(other);
    }
  }
  for (const std::int64_t job : again) {
    ModelJob& one = jobs_.at(job);
    one.state = JobState::kWaiting;
    one.counted = 0;
    one.not_before.reset();
    one.finished.reset();
    one.stop_asked.clear();
    if (one.deadline.value_or(now + 1) <= now) one.deadline.reset();
  }
  settle(now);
  return again;
}

std::set<std::int64_t> LedgerModel::retry_dead(const std::string& queue, TimeMs now) {
  std::set<std::int64_t> dead, again;
  for (const auto& [id, job] : jobs_)
    if (job.state == JobState::kDead && (queue.empty() || job.queue == queue)) dead.insert(id);
  for (const std::int64_t id : dead)
    if (jobs_.at(id).state == JobState::kDead) again.merge(retry(id, now));
  return again;
}

std::set<std::int64_t> LedgerModel::expire(TimeMs now) {
  std::set<std::int64_t> overdue;
  for (const auto& [id, job] : jobs_)
    if (job.state <= JobState::kQueued && job.deadline.value_or(now + 1) <= now) overdue.insert(id);
  for (const std::int64_t id : overdue) {
    ModelJob& job = jobs_.at(id);
    if (is_final(job.state)) continue;
    finish(job, JobState::kDead, now);
  }
  return overdue;
}

void LedgerModel::forgive_back_offs(TimeMs now) {
  for (auto& [id, job] : jobs_)
    if (job.state == JobState::kQueued && job.not_before.value_or(now) > now + policy_.back_off_max)
      job.not_before = now;
}

LedgerModel::Ids LedgerModel::purge(const Ids& ids, const std::string& results) {
  Ids purged;
  for (const std::int64_t id : ids) {
    if (!knows(id) || !is_final(jobs_.at(id).state)) continue;
    const bool is_needed = std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& other) {
      const Ids& needs = other.second.needs;
      return !is_final(other.second.state) && std::find(needs.begin(), needs.end(), id) != needs.end();
    });
    if (is_needed) continue;
    const std::string& output = jobs_.at(id).output;
    left_overs_[id] = output.starts_with(results + "/") ? output : "";
    jobs_.erase(id);
    purged.push_back(id);
  }
  return purged;
}

void LedgerModel::restart(TimeMs now) {
  std::vector<std::int64_t> running;
  for (const auto& [id, job] : jobs_)
    if (job.state == JobState::kRunning) running.push_back(id);
  for (const std::int64_t id : running) again_or_dead(jobs_.at(id), AttemptOutcome::kLost, now);
}

}  // namespace multum::testing
