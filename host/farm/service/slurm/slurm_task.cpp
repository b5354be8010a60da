// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/slurm/slurm_task.h"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "host/farm/service/log/run_handlers.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

namespace asio = boost::asio;

constexpr auto kTaskTick = std::chrono::milliseconds(500);
constexpr int kTicksABeat = 2;

std::string node_name() {
  if (const char* name = std::getenv("SLURMD_NODENAME"); name != nullptr) return name;
  char name[256] = "";
  ::gethostname(name, sizeof(name) - 1);
  return name;
}

WorkerPoolSettings pool_settings(const SlurmOrder& order, std::vector<std::string> command) {
  WorkerPoolSettings settings;
  settings.command = std::move(command);
  settings.lease = order.lease;
  settings.no_progress = order.no_progress;
  settings.cancel_grace = order.cancel_grace;
  return settings;
}

class Task {
 public:
  Task(SlurmBatchFolder folder, SlurmOrder order, std::vector<std::string> command)
      : folder_(std::move(folder)),
        order_(std::move(order)),
        node_(node_name()),
        pool_(io_, pool_settings(order_, std::move(command)), "node",
              {[this] { begin_next(); }, [this](std::int64_t, const JobProgress& progress) { progress_ = progress; },
               [this](std::int64_t, const std::string&, int, const WorkResult& result) { on_ended(result); }}),
        timer_(io_),
        signals_(io_, SIGTERM, SIGINT) {}

  int run() {
    signals_.async_wait([this](const boost::system::error_code& error, int) {
      if (error) return;
      is_interrupted_ = true;
      stop();
    });
    pool_.start();
    tick();
    run_handlers(io_, LogSeverity::kError, "unexpected");
    return is_interrupted_ ? 130 : 0;
  }

 private:
  const SlurmOrder::Item& item() const { return order_.items[at_]; }
  bool is_done() const { return at_ == order_.items.size(); }

  void begin_next() {
    if (is_running_ || is_stopping_ || ended_) return;
    // Skips items that ended before Slurm started this task again.
    while (!is_done() && folder_.end(item().number)) ++at_;
    if (is_done()) return io_.stop();
    if (!folder_.has_order()) return stop();
    if (folder_.is_stopped(item().number)) return note_end({130, "", false});
    const std::vector<std::string> idle = pool_.idle();
    if (idle.empty()) return;
    WorkOrder work = item().work;
    work.log = folder_.log(order_.is_array ? item().number : 0, item().number);
    progress_ = {};
    is_running_ = pool_.order(idle.front(), work);
    write_status();
  }

  void on_ended(const WorkResult& result) {
    is_running_ = false;
    // An interrupted item is either started again by another task, or no client waits for it.
    if (is_stopping_) return io_.stop();
    note_end(result);
  }

  // A result counts only when it has been written. If the folder is full, writing is tried again later.
  void note_end(const WorkResult& result) {
    ended_ = result;
    try {
      folder_.write_end(item().number, {result, node_});
    } catch (const Error& error) {
      if (!folder_.has_order()) return stop();
      print_shown(stderr, "multum: %s; trying again\n", error.what());
      return;  // the next tick tries again
    }
    ended_.reset();
    ++at_;
    begin_next();
  }

  // The task ends, because no client waits for unfinished items.
  void stop() {
    is_stopping_ = true;
    if (!is_running_ || !pool_.cancel(item().work.job)) io_.stop();
  }

  void write_status() {
    if (!is_running_) return;
    try {
      folder_.write_status(item().number, {++beat_, node_, progress_});
    } catch (const Error&) {  // the folder is full, but the next write may succeed
    }
  }

  void tick() {
    // The timer is set first, so that another tick comes even if this one fails.
    timer_.expires_after(kTaskTick);
    timer_.async_wait([this](const boost::system::error_code& error) {
      if (!error) tick();
    });
    if (!is_stopping_) {
      if (!folder_.has_order()) stop();
      else if (ended_) note_end(WorkResult(*ended_));
      else look_for_stops();
      if (++ticks_ % kTicksABeat == 0) write_status();
    }
  }

  void look_for_stops() {
    if (is_running_ && folder_.is_stopped(item().number)) pool_.cancel(item().work.job);
    for (std::size_t i = at_ + 1; i < order_.items.size(); ++i) {
      const int number = order_.items[i].number;
      if (!folder_.is_stopped(number) || folder_.end(number)) continue;
      try {
        folder_.write_end(number, {{130, "", false}, node_});
      } catch (const Error&) {  // the next tick tries again
      }
    }
    if (!is_running_) begin_next();
  }

  const SlurmBatchFolder folder_;
  const SlurmOrder order_;
  const std::string node_;
  asio::io_context io_{1};
  WorkerPool pool_;
  asio::steady_timer timer_;
  asio::signal_set signals_;
  std::size_t at_ = 0;
  bool is_running_ = false, is_stopping_ = false, is_interrupted_ = false;
  std::optional<WorkResult> ended_;  // result of item() that has not been written yet
  JobProgress progress_;
  std::uint64_t beat_ = 0;
  int ticks_ = 0;
};

}  // namespace

int run_slurm_task(const std::string& batch_folder, std::optional<int> array_item, const SlurmWorkerCommand& command) {
  const SlurmBatchFolder folder(batch_folder);
  SlurmOrder order = folder.read_order();
  if (order.is_array) {
    if (!array_item)
      throw Error(ErrorCode::kUsage, batch_folder +
                                         ": belongs to an array of tasks, but the variable SLURM_ARRAY_TASK_ID is not "
                                         "set; expected the number of the task");
    std::erase_if(order.items, [&](const SlurmOrder::Item& item) { return item.number != *array_item; });
  }
  const std::string work_folder = folder.make_work_folder(order.is_array ? *array_item : 0);
  std::vector<std::string> words = command(order, work_folder);
  return Task(folder, std::move(order), std::move(words)).run();
}

}  // namespace multum
