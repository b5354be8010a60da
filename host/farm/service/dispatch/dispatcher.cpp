// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/dispatch/dispatcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/farm/service/ledger/job_json.h"
#include "host/farm/service/log/service_log.h"
#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int kSlurmClaimsMax = 200;  // most claims per commit

// Converts an exit code of multum (docs/reference/service.md) to an outcome, which determines whether another attempt
// is allowed.
AttemptOutcome outcome_of(int code) {
  switch (code) {
    case 0: return AttemptOutcome::kSucceeded;
    case -1: return AttemptOutcome::kLost;
    case 2:
    case 3:
    case 5: return AttemptOutcome::kRefused;
    default: return AttemptOutcome::kFailed;
  }
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

AttemptResult result_of(const Error& error) {
  const int code = exit_code(error.code());
  return {outcome_of(code), code, error.what()};
}

std::string words_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& found) {
    return found.what();
  } catch (...) {
    return "an unknown error";
  }
}

std::vector<Job> jobs_of(JobQueue& queue, const std::set<std::int64_t>& ids) {
  std::vector<Job> jobs;
  for (const std::int64_t id : ids)
    if (std::optional<Job> job = queue.find(id)) jobs.push_back(std::move(*job));
  return jobs;
}

ClaimLimits limits_of(const ServiceSettings& settings) {
  const std::int64_t memory =
      settings.memory_max > 0 ? settings.memory_max : static_cast<std::int64_t>(machine_memory_bytes() / 4 * 3);
  return {settings.queues, settings.devices, memory};
}

}  // namespace

bool is_result_intact(const JobRoots& roots, const Job& job) {
  try {
    return job.output.empty() || is_as_made(roots.outputs, job.output, job.result_identity, roots.seal);
  } catch (const Error&) {  // the file cannot be examined at present
    return false;
  }
}

Dispatcher::Dispatcher(boost::asio::io_context& io, QueueThread& ledger, EventHub& events, DataFolder& data,
                       ServiceSettings settings, const JobRoots& roots, std::string instance,
                       std::vector<std::string> worker_command)
    : io_(io),
      ledger_(ledger),
      events_(events),
      data_(data),
      settings_(std::move(settings)),
      roots_(roots),
      instance_(std::move(instance)),
      limits_(limits_of(settings_)),
      pool_(io,
            {settings_.workers, std::move(worker_command), settings_.lease, settings_.no_progress,
             settings_.cancel_grace},
            instance_,
            {[this] { pump(); }, [this](std::int64_t id, const JobProgress& progress) { on_progress(id, progress); },
             [this](std::int64_t id, const std::string& owner, int attempt, const WorkResult& result) {
               on_ended(id, owner, attempt, result);
             }}),
      due_timer_(io),
      drain_timer_(io) {
  if (!settings_.slurm.is_on()) return;
  std::vector<std::string> on_nodes;
  for (const std::string& root : settings_.roots) on_nodes.push_back(std::filesystem::absolute(root).string());
  slurm_ = std::make_unique<SlurmPool>(
      io_, ledger_,
      SlurmPoolSettings{settings_.slurm, instance_, on_nodes, settings_.lease, settings_.no_progress,
                        settings_.cancel_grace},
      SlurmPool::Events{[this](std::int64_t id, const JobProgress& progress) { on_progress(id, progress); },
                        [this](std::int64_t id, int attempt, const WorkResult& result) {
                          on_ended(id, slurm_owner(instance_), attempt, result);
                        }});
}

std::string Dispatcher::log_path(std::int64_t id) const { return fmt::format("{}/logs/{}.log", settings_.data, id); }

void Dispatcher::remove_logs(const std::vector<std::int64_t>& ids) const {
  for (const std::int64_t id : ids) {
    std::error_code ignored;
    std::filesystem::remove(log_path(id), ignored);
  }
}

// ---- After a start

void Dispatcher::recover() {
  std::vector<std::string> folders;
  JobQueue::Numbers numbers;
  std::vector<Job> with_slurm;
  std::vector<SlurmPart> parts;
  std::int64_t last_batch = 0;
  ledger_.run_now([&](JobQueue& queue) {
    const JobQueue::Recovered recovered = queue.recover(wall_clock_ms(), slurm_ != nullptr);
    with_slurm = recovered.with_slurm;
    parts = queue.slurm().sent();
    last_batch = queue.slurm().last_batch();
    for (const Job& job : recovered.publishing) {
      try {
        publish(job, job.result_identity);
        queue.published(job.id, wall_clock_ms());
        service_log(LogSeverity::kInfo, job.id, "published after a restart: " + job.output);
      } catch (const Error& error) {
        queue.publishing_failed(job.id, result_of(error), wall_clock_ms());
      }
    }
    for (const std::int64_t id : recovered.lost)
      service_log(LogSeverity::kWarning, id, "was running when the daemon ended, and will be tried again");
    folders = queue.files().output_folders();
    numbers = queue.numbers();
    for (const auto& [name, states] : queue.counts())
      for (const auto& [state, count] : states)
        if (!is_final(state) && !limits_.queues.contains(name))
          service_log(
              LogSeverity::kWarning, 0,
              fmt::format("{} jobs are {} in queue {}, which the settings do not define, so they will not start", count,
                          job_state_name(state), name));
  });
  const auto is_finished_with = [&](std::int64_t id) { return numbers.is_finished_with(id); };
  for (const std::string& path : sweep_staging(roots_.outputs, folders, instance_, is_finished_with))
    service_log(LogSeverity::kInfo, 0, "removed a leftover of an earlier daemon: " + path);
  if (slurm_) adopt(with_slurm, parts, last_batch);
}

void Dispatcher::adopt(const std::vector<Job>& jobs, const std::vector<SlurmPart>& parts, std::int64_t last_batch) {
  std::vector<SlurmWork> works;
  for (const Job& job : jobs) {
    running_[job.id] = {job, Clock::now(), std::nullopt};
    try {
      std::string made;
      WorkOrder order = order_of(job, made);
      works.push_back(slurm_work(job, std::move(order), std::move(made)));
      service_log(LogSeverity::kInfo, job.id, "is with Slurm");
    } catch (const std::exception& error) {
      note_end(job.id, job.owner, job.attempt, {AttemptOutcome::kRefused, 2, error.what()});
    }
  }
  slurm_->adopt(works, parts, last_batch);
}

void Dispatcher::start() {
  pool_.start();
  if (slurm_) slurm_->start();
  on_due();
}

// ---- Giving out jobs

void Dispatcher::pump() {
  if (is_draining_) return;
  claims_here_.is_wanted = slurm_claims_.is_wanted = true;
  claim_here();
  claim_for_slurm();
}

void Dispatcher::claim_here() {
  if (is_draining_ || claims_here_.is_under_way) return;
  claim(claims_here_, reserve(pool_.idle()), limits_here(), &Dispatcher::claim_here);
}

void Dispatcher::claim_for_slurm() {
  if (is_draining_ || !slurm_ || slurm_claims_.is_under_way) return;
  const auto room = static_cast<std::size_t>(std::min(slurm_->room(), kSlurmClaimsMax));
  claim(slurm_claims_, std::vector<std::string>(room, slurm_owner(instance_)), limits_of_slurm(),
        &Dispatcher::claim_for_slurm);
}

// A finished claim queues only another claim of its own kind. If it queued both kinds, each kind would find the other
// one waiting, and both would loop.
void Dispatcher::claim(Claims& claims, std::vector<std::string> owners, ClaimLimits limits,
                       void (Dispatcher::*again)()) {
  if (owners.empty()) return;
  claims = {.is_under_way = true, .is_wanted = false};
  const auto outcome = std::make_shared<Outcome>();
  ledger_.run(
      [this, outcome, owners, limits = std::move(limits)](JobQueue& queue) { settle(queue, limits, owners, *outcome); },
      [=, this, &claims](const std::exception_ptr& error) {
        claims.is_under_way = false;
        if (error) {
          if (!ledger_.is_lost()) service_log(LogSeverity::kError, 0, "jobs cannot be claimed: " + words_of(error));
          for (const std::string& owner : owners) reserved_.erase(owner);
          return wake_at(wall_clock_ms() + 5000);
        }
        take(owners, *outcome);
        if (claims.is_wanted || !outcome->claimed.empty()) (this->*again)();
      });
}

bool Dispatcher::uses_slurm(const std::string& queue) const { return slurm_ && has(settings_.slurm.queues, queue); }

bool Dispatcher::goes_to_slurm(const std::string& queue, const std::string& type) const {
  return uses_slurm(queue) && (settings_.slurm.types.empty() || has(settings_.slurm.types, type));
}

bool Dispatcher::bakes_here() const {
  return !settings_.slurm.types.empty() ||
         std::any_of(limits_.queues.begin(), limits_.queues.end(), [&](const auto& q) { return !uses_slurm(q.first); });
}

ClaimLimits Dispatcher::limits_here() const {
  ClaimLimits limits = limits_;
  if (!slurm_) return limits;
  for (const std::string& name : settings_.slurm.queues) {
    const auto queue = limits.queues.find(name);
    if (queue == limits.queues.end()) continue;
    if (settings_.slurm.types.empty()) {
      limits.queues.erase(queue);
    } else {
      queue->second.types = Json(settings_.slurm.types).dump();
      queue->second.are_types_left = true;
    }
  }
  return limits;
}

// This machine's memory does not limit Slurm's nodes.
ClaimLimits Dispatcher::limits_of_slurm() const {
  ClaimLimits limits = limits_;
  limits.memory_max = 0;
  std::erase_if(limits.queues, [&](const auto& queue) { return !uses_slurm(queue.first); });
  for (auto& [name, queue] : limits.queues)
    if (!settings_.slurm.types.empty()) queue.types = Json(settings_.slurm.types).dump();
  return limits;
}

std::vector<std::string> Dispatcher::reserve(const std::vector<std::string>& owners) {
  std::vector<std::string> free;
  for (const std::string& owner : owners)
    if (!is_draining_ && pool_.is_idle(owner) && reserved_.insert(owner).second) free.push_back(owner);
  return free;
}

void Dispatcher::settle(JobQueue& queue, const ClaimLimits& limits, const std::vector<std::string>& owners,
                        Outcome& outcome) const {
  outcome = Outcome{};
  outcome.touched = jobs_of(queue, queue.take_changed());
  for (const std::string& owner : owners) {
    std::optional<Job> job = queue.claim(limits, owner, wall_clock_ms());
    if (!job) break;
    outcome.claimed.push_back(with_reuse(queue, std::move(*job)));
  }
  queue.take_changed();  // reported when the job starts
  outcome.due = queue.next_due();
}

void Dispatcher::take(const std::vector<std::string>& owners, const Outcome& outcome) {
  for (const std::string& owner : owners) reserved_.erase(owner);
  wake_at(outcome.due);
  give_out(outcome.claimed);  // comes first, because nothing else can start a claimed job
  if (slurm_) slurm_->flush();
  for (const Job& job : outcome.touched) events_.publish("job", job.id, job_text(job));
  end_drain_if_idle();
}

void Dispatcher::end_drain_if_idle() {
  if (is_draining_ && drained_ && running_.empty() && unsettled_ == 0) std::exchange(drained_, nullptr)();
}

// If a result with the same key exists, it is copied instead of being made again.
Dispatcher::Claimed Dispatcher::with_reuse(JobQueue& queue, Job job) const {
  Claimed claimed{std::move(job), ""};
  for (const Job& other : queue.succeeded_with_key(claimed.job.key)) {
    if (other.output.empty() || !is_result_intact(roots_, other)) continue;
    claimed.copy_from = other.output;
    queue.set_reused_from(claimed.job.id, other.id);
    break;
  }
  return claimed;
}

void Dispatcher::give_out(const std::vector<Claimed>& claimed) {
  for (const Claimed& one : claimed) {
    running_[one.job.id] = {one.job, Clock::now(), std::nullopt};
    events_.publish("job", one.job.id, job_text(one.job));
    start_job(one);
  }
}

WorkOrder Dispatcher::order_of(const Job& job, std::string& made) const {
  WorkOrder order;
  order.job = job.id;
  order.attempt = job.attempt;
  order.type = job.type;
  order.parameters = Json::parse(job.parameters);
  order.log = log_path(job.id);
  order.inputs = job.inputs;
  if (!job.output.empty()) {
    order.output = job.output;
    order.folder = staging_folder(job.output, instance_, job.id);
    made = staged_path(job.output, instance_, job.id);
  }
  return order;
}

SlurmWork Dispatcher::slurm_work(const Job& job, WorkOrder order, std::string made) const {
  const auto queue = limits_.queues.find(job.queue);
  const int of_queue = queue == limits_.queues.end() ? 0 : queue->second.priority;
  return {std::move(order), std::move(made), job.memory_bytes, of_queue + job.priority};
}

void Dispatcher::start_job(const Claimed& claimed) {
  const Job& job = claimed.job;
  const bool is_for_slurm = is_slurm_owner(job.owner);
  WorkOrder order;
  std::string made;
  if (data_.is_full() && roots_.results.is_inside(job.output))
    return note_end(job.id, job.owner, job.attempt,
                    {AttemptOutcome::kFailed, 4, "data_max is reached, so there is no room for the job's result"});
  try {
    order = order_of(job, made);
    // Slurm's nodes cannot see files in the daemon's data folder.
    if (!claimed.copy_from.empty() && !(is_for_slurm && roots_.results.is_inside(claimed.copy_from))) {
      order.copy_from = claimed.copy_from;
      order.copy_to = made;
      ++counters_.reused;
    }
  } catch (const Error& error) {
    return note_end(job.id, job.owner, job.attempt, result_of(error));
  } catch (const std::exception& error) {
    return note_end(job.id, job.owner, job.attempt, {AttemptOutcome::kRefused, 2, error.what()});
  }
  if (is_for_slurm) return slurm_->order(slurm_work(job, std::move(order), std::move(made)));
  if (!pool_.order(job.owner, order))
    note_end(job.id, job.owner, job.attempt, {AttemptOutcome::kReturned, -1, "its worker ended before the job began"});
}

void Dispatcher::on_progress(std::int64_t id, const JobProgress& progress) {
  progress_[id] = progress;
  events_.publish("progress", id,
                  Json{{"id", id}, {"stage", progress.stage}, {"done", progress.done}, {"total", progress.total}}.dump(
                      -1, ' ', false, Json::error_handler_t::replace));
}

// ---- Results

void Dispatcher::on_ended(std::int64_t id, const std::string& owner, int attempt, const WorkResult& result) {
  const auto found = running_.find(id);
  if (found == running_.end()) return;
  const std::optional<AttemptResult>& stop = found->second.stop;
  const int code = result.exit_code;
  if (code == 0 && !found->second.job.output.empty())
    return publish_result(id, owner, attempt, result.have_inputs_changed);
  if (stop && code != 0) return note_end(id, owner, attempt, *stop);
  if (code == 130) return note_end(id, owner, attempt, {AttemptOutcome::kFailed, code, "it was interrupted"});
  note_end(id, owner, attempt, {outcome_of(code), code, result.message});
}

// First, the ledger records that this attempt counts, and where its result is. Then the result gets its final name.
// Then the ledger records that the result is published. If the daemon crashes in between, the next daemon knows which
// step was reached.
void Dispatcher::publish_result(std::int64_t id, const std::string& owner, int attempt, bool have_inputs_changed) {
  const Job job = running_.at(id).job;
  std::string identity;
  try {
    identity = staged(job).identity();
  } catch (const Error& moved) {
    return note_end(id, owner, attempt, result_of(moved));
  }
  if (identity.empty())
    return note_end(id, owner, attempt, {AttemptOutcome::kFailed, 4, "the command succeeded, but wrote no result"});
  const auto is_mine = std::make_shared<bool>(false);
  note(
      id,
      [=](JobQueue& queue) {
        *is_mine = queue.begin_publishing(id, owner, attempt, identity);
        if (*is_mine && have_inputs_changed && !job.key.empty()) queue.forget_key(id);
      },
      [=, this] {
        if (*is_mine && have_inputs_changed && !job.key.empty())
          service_log(LogSeverity::kInfo, id,
                      "the input has changed since the job was submitted, so other jobs will not reuse the result");
        if (*is_mine) return finish_publishing(job, identity);
        note_end(id, owner, attempt, {AttemptOutcome::kFailed, 4, "another attempt has replaced this one"});
      });
}

void Dispatcher::finish_publishing(const Job& job, const std::string& identity) {
  const auto trouble = std::make_shared<std::optional<AttemptResult>>();
  const auto outcome = std::make_shared<Outcome>();
  const std::vector<std::string> owners = reserve({job.owner});
  note(
      job.id,
      [=, this, limits = limits_here()](JobQueue& queue) {
        queue.take_changed();
        trouble->reset();
        try {
          publish(job, identity);
        } catch (const Error& failed) {
          *trouble = result_of(failed);
        }
        if (*trouble) queue.publishing_failed(job.id, **trouble, wall_clock_ms());
        else queue.published(job.id, wall_clock_ms());
        settle(queue, limits, owners, *outcome);
      },
      [=, this] {
        if (*trouble) service_log(LogSeverity::kError, job.id, (*trouble)->message);
        counters_.published += *trouble ? 0 : 1;
        forget_running(job.id, *trouble ? (*trouble)->outcome : AttemptOutcome::kSucceeded);
        take(owners, *outcome);
        pump();
      });
}

void Dispatcher::note(std::int64_t id, QueueThread::Work work, std::function<void()> done) {
  const auto settled = [this, id, work, done](const std::exception_ptr& error) {
    --unsettled_;
    if (!error) return done();
    if (ledger_.is_lost()) {  // the ledger has reported this; after it is restored, the job counts as interrupted
      running_.erase(id);
      progress_.erase(id);
      return end_drain_if_idle();
    }
    // Usually the disk is full. The result is not in a ledger yet, so this retries until it is recorded.
    service_log(LogSeverity::kError, id, "cannot record the job's result; retrying: " + words_of(error));
    ++unsettled_;
    const auto timer = std::make_shared<boost::asio::steady_timer>(io_, std::chrono::seconds(2));
    timer->async_wait([=, this](const boost::system::error_code&) {
      (void)timer;
      --unsettled_;
      note(id, work, done);
    });
  };
  ledger_.run(work, settled);
  ++unsettled_;  // counted last, because no code would decrement the counter if run() threw an exception
}

StagedResult Dispatcher::staged(const Job& job) const {
  return {roots_.outputs, job.output, instance_, job.id, roots_.seal};
}

void Dispatcher::publish(const Job& job, const std::string& identity) const {
  const std::string kept = staged(job).publish(identity);
  data_.count_result(job.output);
  if (!kept.empty())
    service_log(
        LogSeverity::kWarning, job.id,
        fmt::format("{} contained files that this service did not publish; they were moved to {}", job.output, kept));
}

void Dispatcher::remove_staging(const Job& job) const {
  try {
    staged(job).remove();
  } catch (const Error&) {  // the folder is missing or replaced, so the next start tries again
  }
}

void Dispatcher::forget_running(std::int64_t id, AttemptOutcome outcome) {
  const auto found = running_.find(id);
  if (found != running_.end() && !is_slurm_owner(found->second.job.owner))
    counters_.busy_seconds += std::chrono::duration<double>(Clock::now() - found->second.since).count();
  counters_.succeeded += outcome == AttemptOutcome::kSucceeded ? 1 : 0;
  counters_.lost += outcome == AttemptOutcome::kLost ? 1 : 0;
  counters_.cancelled += outcome == AttemptOutcome::kCancelled ? 1 : 0;
  counters_.failed += outcome == AttemptOutcome::kFailed || outcome == AttemptOutcome::kRefused ? 1 : 0;
  running_.erase(id);
  progress_.erase(id);
}

void Dispatcher::note_end(std::int64_t id, const std::string& owner, int attempt, AttemptResult result) {
  const auto is_final_state = std::make_shared<bool>(false);
  const auto outcome = std::make_shared<Outcome>();
  const std::vector<std::string> owners = reserve({owner});
  note(
      id,
      [=, this, limits = limits_here()](JobQueue& queue) {
        queue.take_changed();
        queue.ended(id, owner, attempt, result, wall_clock_ms());
        const std::optional<Job> job = queue.find(id);
        *is_final_state = !job || is_final(job->state);
        // Claims the worker's next job in the same transaction, which saves a commit per job.
        settle(queue, limits, owners, *outcome);
      },
      [=, this] {
        service_log(result.outcome == AttemptOutcome::kSucceeded ? LogSeverity::kInfo : LogSeverity::kWarning, id,
                    fmt::format("attempt {} {}{}{}", attempt, attempt_outcome_name(result.outcome),
                                result.message.empty() ? "" : ": ", result.message));
        const auto found = running_.find(id);
        // A partial result is kept, and the next attempt continues it.
        if (*is_final_state && found != running_.end() && !found->second.job.output.empty())
          remove_staging(found->second.job);
        forget_running(id, result.outcome);
        take(owners, *outcome);
        pump();
      });
}

void Dispatcher::changed(const std::set<std::int64_t>& ids) {
  const auto jobs = std::make_shared<std::vector<Job>>();
  ledger_.run([=](JobQueue& queue) { *jobs = jobs_of(queue, ids); },
              [=, this](const std::exception_ptr&) {
                for (const Job& job : *jobs) events_.publish("job", job.id, job_text(job));
              });
  end_drain_if_idle();
  pump();
}

void Dispatcher::stop_job(std::int64_t id, const std::string& why, AttemptOutcome outcome) {
  const auto found = running_.find(id);
  if (found == running_.end()) return;
  if (!found->second.stop) found->second.stop = AttemptResult{outcome, 130, why};
  if (!pool_.cancel(id) && slurm_) slurm_->cancel(id);
}

void Dispatcher::set_paused(const std::string& queue, bool is_paused) {
  limits_.queues.at(queue).is_paused = is_paused;
  pump();
}

void Dispatcher::reload(const ServiceSettings& settings) {
  ClaimLimits limits = limits_of(settings);
  // If a request has paused or resumed a queue, the queue stays paused or resumed unless its settings have changed.
  for (auto& [name, of_queue] : limits.queues) {
    const auto before = settings_.queues.find(name);
    if (before != settings_.queues.end() && before->second.is_paused == of_queue.is_paused)
      of_queue.is_paused = limits_.queues.at(name).is_paused;
  }
  settings_.queues = settings.queues;
  settings_.devices = settings.devices;
  settings_.memory_max = settings.memory_max;
  limits_ = std::move(limits);
  pump();
}

// ---- Time

void Dispatcher::wake_at(std::optional<TimeMs> due) {
  // The time is checked at least every minute, so that a clock that is set back cannot cause a wait of years.
  constexpr TimeMs kLongest = 60000;
  const TimeMs pause = due ? std::clamp<TimeMs>(*due - wall_clock_ms(), 1, kLongest) : kLongest;
  due_timer_.expires_after(std::chrono::milliseconds(pause));
  due_timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) on_due();
  });
}

void Dispatcher::on_due() {
  wake_at(wall_clock_ms() + 5000);  // wakes up even if the code below fails
  const auto overdue = std::make_shared<JobQueue::Overdue>();
  const auto due = std::make_shared<std::optional<TimeMs>>();
  ledger_.run(
      [=](JobQueue& queue) {
        *overdue = queue.expire_deadlines(wall_clock_ms());
        queue.forgive_back_offs(wall_clock_ms());
        *due = queue.next_due();
      },
      [=, this](const std::exception_ptr& error) {
        if (error) return wake_at(wall_clock_ms() + 5000);
        for (const std::int64_t id : overdue->running)
          stop_job(id, "its deadline passed while the job ran", AttemptOutcome::kRefused);
        // Running jobs stay overdue from their deadline until they stop.
        wake_at(overdue->running.empty() ? *due : std::optional<TimeMs>(wall_clock_ms() + 1000));
        changed({overdue->dead.begin(), overdue->dead.end()});
      });
}

void Dispatcher::drain(std::function<void()> done) {
  is_draining_ = true;
  drained_ = std::move(done);
  pool_.close();
  if (slurm_) {
    // Slurm's jobs continue, and the next daemon finds them again.
    slurm_->close();
    std::erase_if(running_, [](const auto& one) { return is_slurm_owner(one.second.job.owner); });
  }
  drain_timer_.expires_after(settings_.shutdown_grace);
  drain_timer_.async_wait([this](const boost::system::error_code& error) {
    if (error) return;
    for (const std::int64_t id : pool_.running())
      stop_job(id, "returned to the queue, because the daemon was told to stop", AttemptOutcome::kReturned);
  });
  changed({});
}

}  // namespace multum
