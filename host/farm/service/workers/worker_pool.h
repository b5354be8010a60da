// SPDX-License-Identifier: Apache-2.0
// Manages the daemon's workers. They are child processes that bake, so that a driver crash ends only one of them. A
// worker is killed if it sends no sign of life within its lease, or makes no progress for too long. The pool waits
// until a lost worker has ended before another worker gets its job.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/farm/service/workers/work_order.h"

namespace multum {

struct WorkerPoolSettings {
  int workers = 1;
  std::vector<std::string> command;               // command line of a worker; "--socket=3" is added
  std::chrono::milliseconds lease{10000};         // longest time without a sign of life
  std::chrono::milliseconds no_progress{600000};  // longest time without progress; 0 means no limit
  std::chrono::milliseconds cancel_grace{10000};  // time between the request to stop and the kill
  int jobs_a_worker = 1000;                       // jobs before the worker is replaced, because drivers leak memory
};

struct WorkResult {
  int exit_code = 0;  // -1 if the worker was lost
  std::string message;
  bool have_inputs_changed = false;  // true if inputs have changed since the job was submitted
};

struct JobProgress {
  std::string stage;
  std::uint64_t done = 0, total = 0;
};

class WorkerPool {
 public:
  struct Events {
    std::function<void()> ready;  // called when a worker may be idle
    std::function<void(std::int64_t job, const JobProgress&)> progress;
    std::function<void(std::int64_t job, const std::string& owner, int attempt, const WorkResult& result)> ended;
  };

  WorkerPool(boost::asio::io_context& io, WorkerPoolSettings settings, std::string instance, Events events);
  /// Kills the remaining workers.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  void start();
  /// Returns the names of idle workers that are not reserved. order() takes such a name.
  std::vector<std::string> idle() const;
  bool is_idle(const std::string& owner) const;
  /// Returns false if that worker is no longer idle.
  bool order(const std::string& owner, const WorkOrder& work);
  /// Tells a running job to stop. After the grace period, its worker is killed. Returns false if no worker has the job.
  bool cancel(std::int64_t job);
  /// Starts no more workers and ends idle workers. Running jobs continue.
  void close();
  bool has_running() const;
  std::vector<std::int64_t> running() const;

  std::uint64_t started_count() const { return started_; }
  std::uint64_t lost_count() const { return lost_; }
  int live_count() const { return static_cast<int>(workers_.size()); }

 private:
  struct Worker;
  void spawn();
  void read(const std::shared_ptr<Worker>& worker);
  void take_lines(Worker& worker);
  void take_line(Worker& worker, const nlohmann::json& said);
  static void end_process(Worker& worker);
  static void reap_soon(Worker& worker, const char* why);
  void look_after(const std::shared_ptr<Worker>& worker, std::chrono::steady_clock::time_point now);
  void arm();
  void send(const std::shared_ptr<Worker>& worker, const std::string& line);
  void write_next(const std::shared_ptr<Worker>& worker);
  void reap(const std::shared_ptr<Worker>& worker, const std::string& why);
  void tick();

  boost::asio::io_context& io_;
  WorkerPoolSettings settings_;
  std::string instance_;
  Events events_;
  boost::asio::steady_timer timer_;
  std::map<std::string, std::shared_ptr<Worker>> workers_;  // workers by owner
  std::uint64_t started_ = 0, lost_ = 0;
  int failures_ = 0;  // consecutive workers that died before they were ready
  std::chrono::steady_clock::time_point not_before_;
  bool is_closing_ = false, is_armed_ = false;
};

}  // namespace multum
