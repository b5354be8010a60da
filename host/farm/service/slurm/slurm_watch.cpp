// SPDX-License-Identifier: Apache-2.0
// Handles the results of Slurm. Compares what each check finds (slurm_look.h) with the work that was sent. When a part
// has finished, its job may end, or further parts may be sent.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "host/farm/service/log/service_log.h"
#include "host/farm/service/slurm/slurm_pool.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/work_shard.h"

namespace multum {
namespace {

constexpr int kSubmissionsMax = 10;                     // most submissions of an attempt that Slurm does not begin
constexpr int kIdleFactor = 10;                         // lengthens the pause between checks if nothing is watched
constexpr auto kLingering = std::chrono::seconds(30);   // time for a task to end when all its parts have ended
constexpr auto kRemembered = std::chrono::minutes(10);  // how long finished batches are remembered
constexpr const char* kCompleting = "COMPLETING";       // cancelled, perhaps on a node that does not answer
constexpr int kShareUnits = 1000;                       // units of progress per share

bool is_refusal(int code) { return code == 2 || code == 3 || code == 5; }

}  // namespace

void SlurmPool::look() {
  if (is_closed_ || is_looking_) return;
  is_looking_ = true;
  const std::uint64_t number = ++look_count_;
  std::vector<SlurmWatched> watched;
  for (const auto& [batch, of] : batches_)
    for (const auto& [item, part] : of.parts)
      if (of.stage == Stage::kSent || of.stage == Stage::kUnsure)
        watched.push_back({{batch, item},
                           of.is_array,
                           works_.at(part.row.job).work.order.log,
                           part.kind.is_whole() ? "" : part.kind.log_prefix()});
  const bool asks = !has_asked_array_size_;
  beside(commands_thread_, [this, number, asks, watched = std::move(watched)]() -> std::function<void()> {
    SlurmLook seen;
    try {
      seen = look_at_slurm(commands_, folder_, prefix(), watched);
      if (asks && seen.is_up()) seen.array_size_max = commands_.array_size_max();
    } catch (const std::exception& error) {
      seen.trouble = error.what();
    }
    return [this, number, seen] {
      is_looking_ = false;
      // The timer is set first, so that another check comes even if this one fails.
      timer_.expires_after(batches_.empty() ? kIdleFactor * settings_.slurm.poll : settings_.slurm.poll);
      timer_.async_wait([this](const boost::system::error_code& error) {
        if (!error) look();
      });
      digest(number, seen);
    };
  });
}

void SlurmPool::digest(std::uint64_t look_number, const SlurmLook& look) {
  if (is_closed_) return;
  if (is_up_ != look.is_up() || look_number == 1)
    service_log(look.is_up() ? LogSeverity::kInfo : LogSeverity::kWarning, 0,
                look.is_up() ? "Slurm answers" : "Slurm does not answer: " + look.trouble);
  is_up_ = look.is_up();
  has_asked_array_size_ = has_asked_array_size_ || is_up_;
  if (look.array_size_max) array_size_max_ = std::min(array_size_max_, std::max(1, *look.array_size_max));
  std::map<std::pair<std::int64_t, int>, const SlurmTask*> tasks;
  for (const SlurmTask& task : look.tasks) tasks[{task.job, task.item}] = &task;
  std::vector<SlurmTarget> to_cancel = is_up_ ? compare_lists(look) : std::vector<SlurmTarget>{};
  std::vector<SlurmPart> ended;
  std::vector<std::int64_t> to_send_again;
  for (auto& [number, batch] : batches_) {
    follow_submission(batch);
    bool wants_again = false, has_task = false;
    for (auto& [item, part] : batch.parts) {
      const auto seen = look.parts.find({number, item});
      if (seen == look.parts.end()) continue;  // sent after the check began
      const SlurmTask* task = nullptr;
      if (batch.slurm_job) {
        const auto found = tasks.find({*batch.slurm_job, batch.is_array ? item : -1});
        // Compares names too, because a controller that has lost a job reuses its number.
        if (found != tasks.end() && found->second->name == name_of(number)) task = found->second;
      }
      has_task = has_task || (task != nullptr && !task->is_over());
      const Fate fate = follow(batch, part, seen->second, task, look_number, to_cancel);
      if (fate == Fate::kEnded) ended.push_back(part.row);
      wants_again = wants_again || fate == Fate::kAgain;
    }
    if (wants_again && !has_task) to_send_again.push_back(number);
  }
  cancel_tasks(std::move(to_cancel));
  for (const SlurmPart& part : ended) batches_.at(part.batch).parts.erase(part.item);
  for (const std::int64_t number : to_send_again) send_again(number);
  settle(ended);
  submit_ready();
}

// Records Slurm's numbers for batches whose number was unknown. Returns the Slurm jobs that the ledger does not know.
std::vector<SlurmTarget> SlurmPool::compare_lists(const SlurmLook& look) {
  std::map<std::int64_t, std::int64_t> adopted;
  std::map<std::int64_t, std::string> unknown;  // numbers and names of unknown Slurm jobs
  for (const SlurmTask& task : look.tasks) {
    std::int64_t number = 0;
    const std::string name = task.name.substr(prefix().size());
    const auto [stop, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (error != std::errc() || stop != name.data() + name.size()) continue;
    const auto found = batches_.find(number);
    if (found != batches_.end() && found->second.stage == Stage::kUnsure && !found->second.slurm_job) {
      found->second.slurm_job = adopted[number] = task.job;
      found->second.stage = Stage::kSent;
    }
    const auto done = done_.find(number);
    const bool is_ours = found != batches_.end() && (!found->second.slurm_job || *found->second.slurm_job == task.job);
    const bool lingers = done != done_.end() && Clock::now() - done->second < kLingering;
    if (!task.is_over() && !is_ours && !lingers) unknown[task.job] = task.name;
  }
  if (!adopted.empty())
    note(
        [adopted](JobQueue& queue) {
          for (const auto& [number, job] : adopted) queue.slurm().set_slurm_job(number, job);
        },
        [] {});
  std::vector<SlurmTarget> targets;
  for (const auto& [job, name] : unknown) {
    targets.push_back({name, job});
    if (!cancelled_unknown_.insert(job).second) continue;
    ++counters_.cancelled_unknown;
    service_log(LogSeverity::kWarning, 0, fmt::format("Slurm has job {}, which is not in the ledger", job));
  }
  return targets;
}

// Handles a batch that should have been sent but is not at Slurm.
void SlurmPool::follow_submission(Batch& batch) {
  if (batch.stage != Stage::kUnsure || !is_up_ || batch.is_revoked || batch.refused_with) return;
  if (batch.looks_to_skip > 0) --batch.looks_to_skip;
  else batch.stage = Stage::kReady;
}

SlurmPool::Fate SlurmPool::follow(Batch& batch, Part& part, const SlurmLook::Seen& seen, const SlurmTask* task,
                                  std::uint64_t look_number, std::vector<SlurmTarget>& to_cancel) {
  const Clock::time_point now = Clock::now();
  if (seen.end) {
    const int code = seen.end->result.exit_code;
    part.row.node = seen.end->node;
    batch.has_worked = true;
    return end_part(part,
                    code == 0     ? SlurmPartState::kSucceeded
                    : code == -1  ? SlurmPartState::kLost
                    : code == 130 ? SlurmPartState::kCancelled
                                  : SlurmPartState::kFailed,
                    seen.end->result);
  }
  const auto work = works_.find(part.row.job);
  const bool is_given_up = work != works_.end() && work->second.result && look_number > work->second.given_up_in;
  if (!is_up_) {
    if (seen.status) follow_progress(batch, part, seen);
    return Fate::kGoesOn;
  }
  if (batch.stage == Stage::kUnsure) {
    if (batch.is_revoked) return end_part(part, SlurmPartState::kCancelled, {130, "", false});
    if (batch.refused_with)
      return end_part(part, SlurmPartState::kFailed,
                      {*batch.refused_with, "Slurm refuses it: " + batch.refusal, false});
    part.seen.reason = batch.refusal;
    follow_progress(batch, part, seen);
  }
  if (batch.stage != Stage::kSent) return Fate::kGoesOn;
  part.seen.slurm_state = task != nullptr ? task->state : "";
  part.seen.reason = task != nullptr && task->reason != "None" ? task->reason : "";
  if (task != nullptr && !task->node.empty()) part.seen.node = part.row.node = task->node;
  follow_progress(batch, part, seen);
  const bool is_gone = task == nullptr || task->is_over() || task->is_stuck() ||
                       (task->state == kCompleting && (batch.is_revoked || part.is_cancelled));
  if (is_gone) {
    if (task != nullptr && task->is_stuck())
      to_cancel.push_back({task->name, *batch.slurm_job, batch.is_array ? task->item : -1});
    return follow_absence(batch, part, task, seen);
  }
  part.gone.reset();
  if (batch.is_revoked && is_given_up) {
    to_cancel.push_back({task->name, *batch.slurm_job});  // repeated, because Slurm may have missed it
    return Fate::kGoesOn;
  }
  if (is_given_up && !batch.is_revoked)
    stop_item(part.row.batch, part.row.item);  // repeated, because the folder may have been full
  // A task that was told to stop before this check, and that has not begun, will not begin.
  if (is_given_up && task->state == "PENDING") return end_part(part, SlurmPartState::kCancelled, {130, "", false});
  // A task with several parts works on the first part that has not ended.
  const bool is_at_work = task->state == "RUNNING" && (batch.is_array || &part == &batch.parts.begin()->second);
  if (!is_at_work) part.heard.reset();
  else if (!part.heard) part.heard = now;
  else if (now - *part.heard > settings_.slurm.lease) {
    part.is_cancelled = true;
    part.row.message = fmt::format("its task sent nothing for {} ms and was cancelled", settings_.slurm.lease.count());
    to_cancel.push_back({task->name, *batch.slurm_job, batch.is_array ? task->item : -1});
  }
  return Fate::kGoesOn;
}

void SlurmPool::follow_progress(Batch& batch, Part& part, const SlurmLook::Seen& seen) {
  JobProgress now = part.seen.progress;
  if (seen.status) {
    part.has_begun = batch.has_worked = true;
    if (seen.status->beat != part.beat) part.heard = Clock::now();
    part.beat = seen.status->beat;
    part.row.node = part.seen.node = seen.status->node;
    now = seen.status->progress;
  } else {
    now = {part.seen.reason.empty() ? "waits for Slurm" : fmt::format("waits for Slurm: {}", part.seen.reason), 0, 1};
  }
  if (now.stage == part.seen.progress.stage && now.done == part.seen.progress.done) return;
  part.seen.progress = now;
  if (part.kind.is_whole()) events_.progress(part.row.job, now);
  else tell_progress(part.row.job);
}

// Handles a part whose Slurm task has ended.
SlurmPool::Fate SlurmPool::follow_absence(Batch& batch, Part& part, const SlurmTask* task,
                                          const SlurmLook::Seen& seen) {
  const Clock::time_point now = Clock::now();
  if (!part.gone) part.gone = now;
  if (batch.is_revoked && (task == nullptr || task->state != kCompleting))
    return end_part(part, SlurmPartState::kCancelled, {130, "", false});
  // The last files of the part may not be visible here yet.
  if (now - *part.gone < settings_.slurm.visible) return Fate::kGoesOn;
  if (batch.is_revoked) return end_part(part, SlurmPartState::kCancelled, {130, "", false});
  // No task has begun the part, so the part is not the cause. A merge detects by itself which shares are missing.
  if (!part.has_begun && (task == nullptr || (batch.has_worked && part.kind.is_whole()))) return Fate::kAgain;
  const std::string name = slurm_task_name(*batch.slurm_job, batch.is_array ? part.row.item : -1);
  std::string message = task == nullptr ? fmt::format("Slurm no longer knows its task {}", name)
                                        : fmt::format("its Slurm task {} ended as {}{}", name, task->state,
                                                      task->node.empty() ? "" : " on " + task->node);
  if (!part.row.message.empty()) message = part.row.message + "; " + message;
  if (!seen.last_words.empty()) message += ": " + seen.last_words;
  ++counters_.parts_lost;
  return end_part(part, SlurmPartState::kLost, {-1, message, false});
}

SlurmPool::Fate SlurmPool::end_part(Part& part, SlurmPartState state, const WorkResult& result) {
  ++counters_.parts_ended;
  part.row.state = state;
  part.row.exit_code = result.exit_code;
  part.row.message = result.message;
  results_[{part.row.batch, part.row.item}] = result;
  return Fate::kEnded;
}

// ---- Effects on jobs

void SlurmPool::settle(const std::vector<SlurmPart>& ended) {
  if (!ended.empty())
    note(
        [ended](JobQueue& queue) {
          for (const SlurmPart& part : ended) queue.slurm().update(part);
        },
        [this] { forget_empty_batches(); });
  for (const SlurmPart& part : ended) {
    const auto result = results_.extract({part.batch, part.item});
    const auto found = works_.find(part.job);
    if (found == works_.end() || found->second.work.order.attempt != part.attempt) continue;
    Work& work = found->second;
    work.have_inputs_changed = work.have_inputs_changed || result.mapped().have_inputs_changed;
    if (part.share.empty()) {
      // A job that succeeded before it noticed its cancellation counts as succeeded.
      if (!work.result || result.mapped().exit_code == 0) work.result = result.mapped();
      end_if_idle(part.job);
    } else {
      on_share_ended(work, part, result.mapped());
    }
  }
}

void SlurmPool::on_share_ended(Work& work, const SlurmPart& part, const WorkResult& result) {
  const PartKind kind = parse_part(part.share);
  if (work.result) return end_if_idle(part.job);
  const auto batch = batches_.find(part.batch);
  const bool is_refused = batch != batches_.end() && batch->second.refused_with;  // another round would be refused too
  if (is_refused || is_refusal(result.exit_code) || (kind.is_merge && result.exit_code == 0))
    return give_up(part.job, result);
  if (kind.is_merge) return find_missing(part.job, result.message);
  if (result.exit_code == 0) ++work.shares_done;
  tell_progress(part.job);
}

// Finds the missing shares. First removes the shares that the merge could not use, so that they are made again.
void SlurmPool::find_missing(std::int64_t job, const std::string& message) {
  const Work& work = works_.at(job);
  beside(commands_thread_,
         [this, job, message, made = work.work.made, count = work.share_count,
          attempt = work.work.order.attempt]() -> std::function<void()> {
           std::error_code ignored;
           for (const int index : named_shares(message, count))
             std::filesystem::remove(share_file(made, index, count), ignored);
           std::vector<int> missing;
           for (int index = 0; index <= count; ++index)
             if (!std::filesystem::exists(share_file(made, index, count), ignored)) missing.push_back(index);
           return [this, job, attempt, missing, message] {
             const auto found = works_.find(job);
             if (found != works_.end() && found->second.work.order.attempt == attempt)
               begin_round(job, missing, message);
           };
         });
}

void SlurmPool::begin_round(std::int64_t job, const std::vector<int>& missing, const std::string& message) {
  Work& work = works_.at(job);
  if (work.result) return end_if_idle(job);
  std::vector<std::string> names;
  for (const int index : missing) names.push_back(fmt::format("{}/{}", index, work.share_count));
  if (work.round >= settings_.slurm.rounds) {
    const std::string list = names.empty() ? "" : fmt::format(", shares {} are missing", fmt::join(names, ", "));
    return give_up(job, {4, fmt::format("after {} rounds{}: {}", work.round, list, message), false});
  }
  ++work.round;
  ++counters_.rounds;
  work.shares_done = work.share_count + 1 - static_cast<int>(missing.size());
  service_log(LogSeverity::kWarning, job,
              fmt::format("round {} of {}: requested {} again", work.round, settings_.slurm.rounds,
                          names.empty() ? "the merge" : fmt::format("shares {}", fmt::join(names, ", "))));
  SlurmPart part;
  part.job = job;
  part.attempt = work.work.order.attempt;
  part.round = work.round;
  send(share_batches(part, work.share_count, missing, array_size_max_));
}

void SlurmPool::tell_progress(std::int64_t job) {
  const auto found = works_.find(job);
  if (found == works_.end()) return;
  const Work& work = found->second;
  std::uint64_t done = static_cast<std::uint64_t>(std::max(0, work.shares_done)) * kShareUnits;
  std::string stage = fmt::format("{} of {} shares", std::max(0, work.shares_done), work.share_count + 1);
  for (const auto& [number, batch] : batches_)
    for (const auto& [item, part] : batch.parts) {
      const JobProgress& of = part.seen.progress;
      if (part.row.job != job || !part.has_begun || of.total == 0) continue;
      done += kShareUnits * std::min(of.done, of.total) / of.total;
      if (part.kind.is_merge) stage = of.stage;
    }
  events_.progress(job, {stage, done, static_cast<std::uint64_t>(work.share_count + 2) * kShareUnits});
}

// Sends parts that Slurm does not know, or has not begun, as a new batch.
void SlurmPool::send_again(std::int64_t number) {
  Batch& old = batches_.at(number);
  std::vector<SlurmPart> parts;
  std::set<std::int64_t> jobs;
  for (const auto& [item, part] : old.parts) {
    if (jobs.insert(part.row.job).second) ++works_.at(part.row.job).submissions;
    parts.push_back(part.row);
  }
  const bool is_hopeless = std::any_of(jobs.begin(), jobs.end(),
                                       [&](std::int64_t job) { return works_.at(job).submissions > kSubmissionsMax; });
  if (is_hopeless) {
    for (SlurmPart& row : parts) {
      row.state = SlurmPartState::kLost;
      row.message = fmt::format("Slurm did not start the job, although it was sent {} times", kSubmissionsMax);
      results_[{row.batch, row.item}] = {-1, row.message, false};
    }
    counters_.parts_lost += parts.size();
    old.parts.clear();
    return settle(parts);
  }
  ++counters_.forgotten;
  service_log(LogSeverity::kWarning, parts.front().job,
              fmt::format("Slurm no longer knows its job {}, or did not start it, so the job is sent again",
                          old.slurm_job.value_or(0)));
  replace(number, {std::move(parts)}, "Slurm no longer knew the job, or did not start it, so the job was sent again");
}

// Removes the files of batches once the ledger has recorded how their parts ended.
void SlurmPool::forget_empty_batches() {
  std::vector<std::int64_t> numbers;
  const Clock::time_point now = Clock::now();
  for (const auto& [number, batch] : batches_)
    if (batch.parts.empty() && batch.stage != Stage::kSending && batch.stage != Stage::kNoting)
      numbers.push_back(number);
  std::erase_if(done_, [&](const auto& one) { return now - one.second > kRemembered; });
  for (const std::int64_t number : numbers) {
    batches_.erase(number);
    done_[number] = now;
    beside(commands_thread_, [this, number]() -> std::function<void()> {
      folder_.remove(number);
      return [] {};
    });
  }
}

}  // namespace multum
