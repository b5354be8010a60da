// SPDX-License-Identifier: Apache-2.0
// Sends work to Slurm. slurm_watch.cpp handles the results.
#include "host/farm/service/slurm/slurm_pool.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>

#include "host/farm/service/log/service_log.h"
#include "host/farm/service/slurm/slurm_estimate.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

namespace asio = boost::asio;

constexpr std::size_t kEstimatedAtOnce = kChunkJobsMax;
constexpr int kRefusalsMax = 3;    // refusals by sbatch for unknown reasons, while Slurm answers
constexpr int kSkippedLooks = 32;  // largest number of checks to wait for a busy Slurm

std::int64_t milliseconds_since_1970() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

SlurmPool::SlurmPool(asio::io_context& io, QueueThread& ledger, SlurmPoolSettings settings, Events events)
    : io_(io),
      ledger_(ledger),
      settings_(std::move(settings)),
      folder_(settings_.slurm.folder, settings_.instance),
      events_(std::move(events)),
      commands_(settings_.slurm, [this] { return is_stopped_.load(); }),
      timer_(io),
      gather_timer_(io) {}

SlurmPool::~SlurmPool() {
  is_stopped_ = true;
  for (asio::thread_pool* threads : {&commands_thread_, &estimates_threads_}) {
    threads->stop();
    threads->join();
  }
}

std::string SlurmPool::prefix() const { return fmt::format("multum-{}-", settings_.instance); }
std::string SlurmPool::name_of(std::int64_t batch) const { return prefix() + std::to_string(batch); }

// Runs `work` on `threads`. Then runs, on this thread, the function that `work` returned.
void SlurmPool::beside(asio::thread_pool& threads, std::function<std::function<void()>()> work) {
  asio::post(threads, [this, work = std::move(work)] {
    std::function<void()> done = work();
    if (!is_stopped_) asio::post(io_, std::move(done));
  });
}

// Runs work in the ledger. Repeats it while the disk is full, but not if the ledger is lost.
void SlurmPool::note(QueueThread::Work work, std::function<void()> done) {
  ledger_.run(work, [=, this](const std::exception_ptr& error) {
    if (!error) return done();
    if (ledger_.is_lost()) return;
    const auto timer = std::make_shared<asio::steady_timer>(io_, std::chrono::seconds(2));
    timer->async_wait([=, this](const boost::system::error_code&) {
      (void)timer;
      note(work, done);
    });
  });
}

// ---- Start and end

void SlurmPool::adopt(const std::vector<SlurmWork>& works, const std::vector<SlurmPart>& parts,
                      std::int64_t last_batch) {
  last_batch_ = last_batch;
  for (const SlurmWork& work : works) works_[work.order.job].work = work;
  for (const SlurmPart& row : parts) {
    const auto found = works_.find(row.job);
    if (found == works_.end()) continue;
    Part part;
    part.row = row;
    part.kind = parse_part(row.share);
    found->second.share_count = part.kind.count;
    found->second.round = std::max(found->second.round, row.round);
    Batch& batch = batches_[row.batch];
    batch.is_array = part.kind.is_band();
    batch.slurm_job = row.slurm_job;
    batch.stage = row.slurm_job ? Stage::kSent : Stage::kUnsure;
    batch.time_max = settings_.slurm.time_max;
    batch.parts.emplace(row.item, std::move(part));
  }
  for (auto& [job, work] : works_)
    if (work.share_count > 0) work.shares_done = work.share_count + 1;
  for (const auto& [number, batch] : batches_)
    for (const auto& [item, part] : batch.parts)
      if (!part.kind.is_whole() && !part.kind.is_merge) --works_.at(part.row.job).shares_done;
}

void SlurmPool::start() {
  folder_.prepare();
  for (const std::int64_t number : folder_.batches())
    if (!batches_.contains(number)) folder_.remove(number);
  look();
}

void SlurmPool::close() {
  is_closed_ = true;
  timer_.cancel();
  gather_timer_.cancel();
}

int SlurmPool::room() const {
  return is_closed_ ? 0 : std::max(0, settings_.slurm.jobs_max - static_cast<int>(works_.size()));
}

// ---- From an order to a batch

void SlurmPool::order(SlurmWork work) {
  const std::int64_t job = work.order.job;
  Work& made = works_[job];
  made = Work{};
  made.work = std::move(work);
  new_.push_back(job);
}

void SlurmPool::flush() {
  // When jobs arrive one by one, waits for a while so that they can share a task.
  if (settings_.slurm.chunk_seconds <= 0.0 || new_.size() >= kEstimatedAtOnce) return estimate_new();
  if (new_.empty() || is_gathering_) return;
  is_gathering_ = true;
  gather_timer_.expires_after(settings_.slurm.poll);
  gather_timer_.async_wait([this](const boost::system::error_code& error) {
    is_gathering_ = false;
    if (!error) estimate_new();
  });
}

void SlurmPool::estimate_new() {
  for (std::size_t begin = 0; begin < new_.size(); begin += kEstimatedAtOnce) {
    std::vector<SlurmWork> works;
    for (std::size_t i = begin; i < std::min(new_.size(), begin + kEstimatedAtOnce); ++i)
      if (const auto found = works_.find(new_[i]); found != works_.end()) works.push_back(found->second.work);
    beside(estimates_threads_, [this, works = std::move(works)]() -> std::function<void()> {
      std::vector<SlurmEstimate> estimates;
      for (const SlurmWork& work : works)
        estimates.push_back(is_stopped_ ? SlurmEstimate{}
                                        : estimate_work(work.order, settings_.slurm, settings_.roots));
      return [this, works, estimates] { plan(works, estimates); };
    });
  }
  new_.clear();
}

void SlurmPool::plan(std::vector<SlurmWork> works, std::vector<SlurmEstimate> estimates) {
  if (is_closed_) return;
  std::vector<SlurmPart> whole;
  std::vector<double> seconds;
  for (std::size_t i = 0; i < works.size(); ++i) {
    const WorkOrder& order = works[i].order;
    const auto found = works_.find(order.job);
    // The job was cancelled meanwhile.
    if (found == works_.end() || found->second.work.order.attempt != order.attempt || found->second.result) continue;
    Work& work = found->second;
    work.estimate = estimates[i];
    work.share_count = estimates[i].share_count;
    SlurmPart part;
    part.job = order.job;
    part.attempt = order.attempt;
    if (work.share_count > 0) {
      std::vector<int> all;
      for (int index = 0; index <= work.share_count; ++index) all.push_back(index);
      send(share_batches(part, work.share_count, all, array_size_max_));
      continue;
    }
    whole.push_back(part);
    seconds.push_back(work.estimate.seconds);
  }
  std::vector<std::vector<SlurmPart>> batches;
  for (const std::vector<std::size_t>& chunk : make_chunks(seconds, settings_.slurm.chunk_seconds)) {
    std::vector<SlurmPart>& batch = batches.emplace_back();
    for (const std::size_t place : chunk) {
      batch.push_back(whole[place]);
      batch.back().item = static_cast<int>(batch.size()) - 1;
    }
  }
  send(std::move(batches));
}

void SlurmPool::send(std::vector<std::vector<SlurmPart>> batches) {
  if (batches.empty()) return;
  std::vector<SlurmPart> rows;
  std::vector<std::int64_t> numbers;
  for (std::vector<SlurmPart>& parts : batches) {
    // Uses the clock, so that a number is not used again if the ledger has lost the earlier numbers.
    const std::int64_t number = last_batch_ = std::max(last_batch_ + 1, milliseconds_since_1970());
    Batch& batch = batches_[number];
    numbers.push_back(number);
    double seconds = 0.0;
    int attempt = 1;
    for (SlurmPart& row : parts) {
      Part part;
      part.kind = parse_part(row.share);
      row.batch = number;
      row.slurm_job.reset();
      part.row = row;
      const SlurmEstimate& estimate = works_.at(row.job).estimate;
      const std::size_t kind = part.kind.is_merge ? 2 : part.kind.is_band() ? 1 : 0;
      const double own = part.kind.is_whole()                 ? estimate.seconds
                         : estimate.share_seconds.size() == 3 ? estimate.share_seconds[kind]
                                                              : -1.0;
      batch.is_array = part.kind.is_band();
      if (batch.is_array) seconds = own;
      else seconds = own < 0.0 || seconds < 0.0 ? -1.0 : seconds + own;
      attempt = std::max({attempt, row.attempt, row.round});
      rows.push_back(row);
      batch.parts.emplace(row.item, std::move(part));
    }
    batch.time_max = time_limit(settings_.slurm, seconds, attempt);
  }
  note(
      [rows](JobQueue& queue) {
        for (const SlurmPart& row : rows) queue.slurm().add(row);
      },
      [this, numbers] {
        for (const std::int64_t number : numbers)
          if (const auto found = batches_.find(number); found != batches_.end()) found->second.stage = Stage::kReady;
        submit_ready();
      });
}

SlurmPool::Sending SlurmPool::sending_of(std::int64_t number, const Batch& batch) const {
  Sending sending;
  sending.number = number;
  SlurmOrder& order = sending.order;
  order.is_array = batch.is_array;
  order.roots = settings_.roots;
  order.threads = settings_.slurm.cpus;
  order.lease = settings_.lease;
  order.no_progress = settings_.no_progress;
  order.cancel_grace = settings_.cancel_grace;
  SlurmSubmission& s = sending.submission;
  int priority = -1 << 20;
  for (const auto& [item, part] : batch.parts) {
    const SlurmWork& work = works_.at(part.row.job).work;
    order.items.push_back({item, work.order});
    order.items.back().work.share = part.kind.option();
    if (batch.is_array) s.array.push_back(item);
    s.memory_bytes = std::max(s.memory_bytes, work.memory_bytes);
    priority = std::max(priority, work.priority);
  }
  const SlurmBatchFolder folder = folder_.batch(number);
  const Part& first = batch.parts.begin()->second;
  s.name = name_of(number);
  s.comment = batch.parts.size() == 1 || !first.kind.is_whole()
                  ? fmt::format("multum job {}", first.row.job)
                  : fmt::format("multum jobs {} to {}", first.row.job, batch.parts.rbegin()->second.row.job);
  s.script = folder_.script();
  s.command = {settings_.slurm.program.empty() ? own_program() : settings_.slurm.program, "slurm-task",
               "--batch=" + folder.path()};
  s.output = folder.output(batch.is_array);
  // Slurm lets users raise the nice value, but not lower it.
  s.nice = std::max(0, settings_.slurm.nice - priority);
  s.time_max = batch.time_max;
  for (const auto& [other, of] : batches_) {
    if (other == number || of.parts.empty() || first.kind.is_whole()) continue;
    const Part& part = of.parts.begin()->second;
    if (part.row.job != first.row.job || part.row.attempt != first.row.attempt || !waits_for(first.kind, part.kind))
      continue;
    if (of.slurm_job) s.after.push_back(*of.slurm_job);
    else sending.after.push_back(other);
  }
  return sending;
}

void SlurmPool::submit_ready() {
  if (is_closed_) return;
  std::vector<Sending> sendings;
  std::vector<SlurmPart> unwanted;
  for (auto& [number, batch] : batches_) {
    if (batch.stage != Stage::kReady) continue;
    for (auto& [item, part] : batch.parts) {
      if (!works_.at(part.row.job).result) continue;
      end_part(part, SlurmPartState::kCancelled, {130, "", false});
      unwanted.push_back(part.row);
    }
    std::erase_if(batch.parts, [](const auto& part) { return part.second.row.state != SlurmPartState::kSent; });
    if (batch.parts.empty()) continue;
    batch.stage = Stage::kSending;
    sendings.push_back(sending_of(number, batch));
  }
  settle(unwanted);
  if (sendings.empty()) return;
  beside(commands_thread_, [this, sendings = std::move(sendings)]() -> std::function<void()> {
    const Stopwatch stopwatch;
    std::vector<Sent> sent;
    std::map<std::int64_t, std::int64_t> known;
    std::string array_refusal;  // sbatch's message about an array that was too long, of size refused_size
    std::size_t refused_size = 0;
    for (const Sending& sending : sendings) {
      const std::vector<int>& array = sending.submission.array;
      const std::size_t size = array.empty() ? 0 : static_cast<std::size_t>(array.back()) + 1;
      // Slurm would refuse other arrays of this size too.
      if (refused_size > 0 && size >= refused_size) {
        sent.push_back({sending.number, std::nullopt, array_refusal});
        continue;
      }
      sent.push_back(submit(sending, known));
      if (size > 0 && refusal_of(sent.back().refusal) == SlurmRefusal::kArrayTooLong) {
        refused_size = size;
        array_refusal = sent.back().refusal;
      }
    }
    return [this, sent, seconds = stopwatch.seconds()] {
      counters_.submit_seconds += seconds;
      take_sent(sent);
    };
  });
}

// Runs on the thread of the commands. `known` has Slurm's numbers for the batches that were sent just before.
SlurmPool::Sent SlurmPool::submit(const Sending& sending, std::map<std::int64_t, std::int64_t>& known) {
  Sent one{sending.number, std::nullopt, ""};
  SlurmSubmission submission = sending.submission;
  for (const std::int64_t before : sending.after) {
    const auto found = known.find(before);
    if (found == known.end()) return one;  // depends on a batch that could not be sent
    submission.after.push_back(found->second);
  }
  try {
    folder_.batch(sending.number).write_order(sending.order);
  } catch (const std::exception& unwritten) {
    service_log(LogSeverity::kWarning, 0, std::string("cannot be sent to Slurm yet: ") + unwritten.what());
    return one;
  }
  try {
    one.slurm_job = known[sending.number] = commands_.submit(submission);
  } catch (const Error& refused) {
    known.erase(sending.number);
    one.refusal = refused.what();
  }
  return one;
}

void SlurmPool::take_sent(const std::vector<Sent>& sent) {
  std::vector<std::pair<std::int64_t, std::int64_t>> known;
  std::vector<std::int64_t> too_long;
  for (const Sent& one : sent) {
    const auto found = batches_.find(one.number);
    if (found == batches_.end()) continue;
    Batch& batch = found->second;
    if (one.slurm_job) {
      ++counters_.submitted;
      batch.slurm_job = one.slurm_job;
      batch.stage = Stage::kSent;
      batch.refusals = batch.waits = 0;
      batch.refusal.clear();
      known.emplace_back(one.number, *one.slurm_job);
    } else {
      // Slurm may have accepted the job although its answer was lost.
      ++counters_.submit_failures;
      batch.stage = Stage::kUnsure;
      if (!one.refusal.empty()) take_refusal(batch, one.refusal);
      if (!one.refusal.empty() && !batch.refused_with && takes_smaller_arrays(batch)) too_long.push_back(one.number);
    }
  }
  for (const std::int64_t number : too_long) split_array(number);
  if (known.empty()) return;
  note(
      [known](JobQueue& queue) {
        for (const auto& [number, slurm_job] : known) queue.slurm().set_slurm_job(number, slurm_job);
      },
      [] {});
}

// Decides if and when a refused batch is sent again.
void SlurmPool::take_refusal(Batch& batch, const std::string& refusal) {
  if (refusal != batch.refusal)
    service_log(LogSeverity::kWarning, batch.parts.empty() ? 0 : batch.parts.begin()->second.row.job,
                "not sent to Slurm: " + refusal);
  batch.refusal = refusal;
  switch (refusal_of(refusal)) {
    case SlurmRefusal::kNotNow:
      batch.looks_to_skip = std::min(kSkippedLooks, 1 << std::min(batch.waits++, 5)) - 1;
      break;
    case SlurmRefusal::kNever: batch.refused_with = exit_code(ErrorCode::kUsage); break;
    case SlurmRefusal::kUnknown:
      if (++batch.refusals >= kRefusalsMax) batch.refused_with = exit_code(ErrorCode::kEnvironment);
      break;
    case SlurmRefusal::kArrayTooLong:
      if (!batch.is_array || batch.parts.empty() || batch.parts.rbegin()->first == 0)
        batch.refused_with = exit_code(ErrorCode::kUsage);
      break;
  }
}

// If an array had too many tasks, tries half as many.
bool SlurmPool::takes_smaller_arrays(const Batch& batch) {
  if (refusal_of(batch.refusal) != SlurmRefusal::kArrayTooLong || batch.parts.empty()) return false;
  array_size_max_ = std::min(array_size_max_, (batch.parts.rbegin()->first + 1) / 2);
  return true;
}

void SlurmPool::split_array(std::int64_t number) {
  std::vector<SlurmPart> bands;
  for (const auto& [item, part] : batches_.at(number).parts) bands.push_back(part.row);
  replace(number, in_arrays(std::move(bands), array_size_max_),
          "sbatch refused an array of so many tasks, so the jobs are sent again in a smaller array");
}

// The ledger records the parts of the old batch as lost, for this reason. The old order is removed, so that its tasks
// end if Slurm starts them after all.
void SlurmPool::replace(std::int64_t number, std::vector<std::vector<SlurmPart>> batches, const std::string& why) {
  Batch& old = batches_.at(number);
  std::vector<SlurmPart> lost;
  for (const auto& [item, part] : old.parts) {
    lost.push_back(part.row);
    lost.back().state = SlurmPartState::kLost;
    lost.back().message = why;
  }
  old.parts.clear();
  for (std::vector<SlurmPart>& parts : batches)
    for (SlurmPart& part : parts) {
      part.node.clear();
      part.message.clear();
    }
  note(
      [lost](JobQueue& queue) {
        for (const SlurmPart& part : lost) queue.slurm().update(part);
      },
      [this] { forget_empty_batches(); });
  send(std::move(batches));
}

// ---- Cancelling

bool SlurmPool::has_parts(std::int64_t job) const {
  return std::any_of(batches_.begin(), batches_.end(), [&](const auto& batch) {
    return std::any_of(batch.second.parts.begin(), batch.second.parts.end(),
                       [&](const auto& part) { return part.second.row.job == job; });
  });
}

bool SlurmPool::cancel(std::int64_t job) {
  const auto found = works_.find(job);
  if (found == works_.end()) return false;
  give_up(job, {130, "", false});
  return true;
}

void SlurmPool::give_up(std::int64_t job, const WorkResult& result) {
  Work& work = works_.at(job);
  if (work.result) return;
  work.result = result;
  work.result->have_inputs_changed |= work.have_inputs_changed;
  work.given_up_in = look_count_;
  std::vector<SlurmTarget> targets;
  for (auto& [number, batch] : batches_) {
    const auto is_its = [&](const auto& part) { return part.second.row.job == job; };
    if (std::none_of(batch.parts.begin(), batch.parts.end(), is_its)) continue;
    if (std::all_of(batch.parts.begin(), batch.parts.end(), is_its)) {
      batch.is_revoked = true;
      if (batch.slurm_job) targets.push_back({name_of(number), *batch.slurm_job});
      beside(commands_thread_, [this, batch_number = number]() -> std::function<void()> {
        folder_.batch(batch_number).revoke_order();
        return [] {};
      });
    } else {
      // The task continues with other jobs.
      for (const auto& [item, part] : batch.parts)
        if (part.row.job == job) stop_item(number, item);
    }
  }
  cancel_tasks(std::move(targets));
  end_if_idle(job);
}

void SlurmPool::stop_item(std::int64_t batch, int item) {
  beside(commands_thread_, [this, batch, item]() -> std::function<void()> {
    try {
      folder_.batch(batch).stop(item);
    } catch (const std::exception& error) {
      service_log(LogSeverity::kWarning, 0, error.what());
    }
    return [] {};
  });
}

void SlurmPool::cancel_tasks(std::vector<SlurmTarget> targets) {
  if (targets.empty()) return;
  beside(commands_thread_, [this, targets = std::move(targets)]() -> std::function<void()> {
    try {
      commands_.cancel(targets);
    } catch (const std::exception& error) {  // repeated as long as Slurm lists the tasks
      service_log(LogSeverity::kWarning, 0, error.what());
    }
    return [] {};
  });
}

bool SlurmPool::cancel_part(std::int64_t job, std::int64_t number, int item) {
  const auto found = batches_.find(number);
  if (found == batches_.end() || !found->second.slurm_job) return false;
  const auto part = found->second.parts.find(item);
  if (part == found->second.parts.end() || part->second.row.job != job || part->second.kind.is_whole()) return false;
  part->second.is_cancelled = true;
  part->second.row.message = "cancelled by request";
  cancel_tasks({{name_of(number), *found->second.slurm_job, found->second.is_array ? item : -1}});
  return true;
}

void SlurmPool::end_if_idle(std::int64_t job) {
  const auto found = works_.find(job);
  if (found == works_.end() || !found->second.result || has_parts(job)) return;
  const WorkResult result = *found->second.result;
  const int attempt = found->second.work.order.attempt;
  works_.erase(found);
  // This call is posted instead of being made directly, because the receiver may order more work.
  asio::post(io_, [this, job, attempt, result] { events_.ended(job, attempt, result); });
}

// ---- Looking

std::optional<SlurmPool::PartView> SlurmPool::view(const SlurmPartKey& key) const {
  const auto batch = batches_.find(key.first);
  if (batch == batches_.end()) return std::nullopt;
  const auto part = batch->second.parts.find(key.second);
  return part == batch->second.parts.end() ? std::nullopt : std::optional(part->second.seen);
}

std::map<std::string, int> SlurmPool::states() const {
  std::map<std::string, int> states;
  for (const auto& [number, batch] : batches_)
    for (const auto& [item, part] : batch.parts)
      ++states[part.seen.slurm_state.empty() ? "UNKNOWN" : part.seen.slurm_state];
  return states;
}

}  // namespace multum
