// SPDX-License-Identifier: Apache-2.0
// Defines the shared folder through which a daemon and its Slurm tasks communicate. Each file is written under a
// temporary name and then renamed. No times are compared, because nodes have their own clocks.
//
//   FOLDER/multum-INSTANCE/batch-17/
//     order.json        the work; if the file is removed, the batch's tasks end
//     stop-3            item 3 is cancelled
//     status-3.json     {"beat", "node", "stage", "done", "total"}: the beat grows while the item is being done
//     ended-3.json      {"exit_code", "message", "inputs_changed", "node"}
//     slurm.out         output of the task itself
//     work-3/           the only folder here that workers may write: logs/3.log, scratch/
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/farm/service/workers/worker_pool.h"

namespace multum {

/// The work of a task, as in order.json.
struct SlurmOrder {
  bool is_array = false;  // each task does the item with its number; otherwise one task does all items
  std::vector<std::string> roots;
  int threads = 1;
  std::chrono::milliseconds lease{10000}, no_progress{600000}, cancel_grace{10000};
  struct Item {
    int number = 0;
    WorkOrder work;  // without its log
  };
  std::vector<Item> items;
};

struct SlurmStatus {
  std::uint64_t beat = 0;
  std::string node;
  JobProgress progress;
};

struct SlurmEnd {
  WorkResult result;
  std::string node;
};

/// The files of one batch, for the daemon and for the tasks.
class SlurmBatchFolder {
 public:
  explicit SlurmBatchFolder(std::string path) : path_(std::move(path)) {}
  const std::string& path() const { return path_; }

  /// Also creates the folder. Throws Error(kEnvironment), like all functions that write.
  void write_order(const SlurmOrder& order) const;
  bool has_order() const;
  /// Throws Error(kEnvironment) when the order no longer exists.
  SlurmOrder read_order() const;
  void revoke_order() const;

  void stop(int item) const;
  bool is_stopped(int item) const;

  /// Returns the names of the files that the folder contains at present.
  std::set<std::string> names() const;
  static std::string status_name(int item);
  static std::string end_name(int item);
  static std::string output_name(int item, bool is_array);

  void write_status(int item, const SlurmStatus& status) const;
  void write_end(int item, const SlurmEnd& end) const;
  std::optional<SlurmStatus> status(int item) const;
  std::optional<SlurmEnd> end(int item) const;

  /// Creates the work folder, with all its subfolders, for a worker whose first item is `item`.
  std::string make_work_folder(int item) const;
  std::string log(int work_item, int item) const;
  /// Returns the path for the output of Slurm's tasks. "%a" stands for a task's number in an array.
  std::string output(bool is_array) const;
  /// Returns the last line that a task printed, or "" if there is none.
  std::string last_words(int item, bool is_array) const;
  /// Appends an item's new log lines to another file, each after `prefix`. If `is_last`, also appends the unfinished
  /// last line.
  void move_log(int work_item, int item, const std::string& to, const std::string& prefix, bool is_last) const;

 private:
  std::string path_;
};

/// The folder of all batches of a daemon.
class SlurmFolder {
 public:
  SlurmFolder(const std::string& folder, const std::string& instance);
  /// Creates the folder and the script for Slurm. Throws Error(kEnvironment).
  void prepare() const;
  std::string script() const { return path_ + "/task.sh"; }
  SlurmBatchFolder batch(std::int64_t number) const;
  void remove(std::int64_t number) const;
  std::vector<std::int64_t> batches() const;

 private:
  std::string path_;
};

}  // namespace multum
