// SPDX-License-Identifier: Apache-2.0
// The shared folder by which a daemon and the tasks that it has sent to Slurm speak. Files appear by a rename; no clock
// is looked at, since nodes have their own.
//
//   FOLDER/multum-INSTANCE/batch-17/
//     order.json        what to do; when it is gone, its tasks are nobody's and end
//     stop-3            item 3 is not to be done any more
//     status-3.json     {"beat", "node", "stage", "done", "total"}: the beat grows while the item is worked at
//     ended-3.json      {"exit_code", "message", "inputs_changed", "node"}
//     slurm.out         what the task itself says
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

/// What a task does with its items, as order.json has it.
struct SlurmOrder {
  bool is_array = false;  // each task does the item of its number; else one does all
  std::vector<std::string> roots;
  int threads = 1;
  std::chrono::milliseconds lease{10000}, no_progress{600000}, cancel_grace{10000};
  struct Item {
    int number = 0;
    WorkOrder work;  // but for its log
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

/// One batch's files, seen from either side.
class SlurmBatchFolder {
 public:
  explicit SlurmBatchFolder(std::string path) : path_(std::move(path)) {}
  const std::string& path() const { return path_; }

  /// Makes the folder too. Throws Error(kEnvironment), as all that writes does.
  void write_order(const SlurmOrder& order) const;
  bool has_order() const;
  /// Throws Error(kEnvironment) when it is not there any more.
  SlurmOrder read_order() const;
  void revoke_order() const;

  void stop(int item) const;
  bool is_stopped(int item) const;

  /// Of what is in it now.
  std::set<std::string> names() const;
  static std::string status_name(int item);
  static std::string end_name(int item);
  static std::string output_name(int item, bool is_array);

  void write_status(int item, const SlurmStatus& status) const;
  void write_end(int item, const SlurmEnd& end) const;
  std::optional<SlurmStatus> status(int item) const;
  std::optional<SlurmEnd> end(int item) const;

  /// For a worker whose first item it is: with all folders in it.
  std::string make_work_folder(int item) const;
  std::string log(int work_item, int item) const;
  /// Of what Slurm's tasks print; "%a" is an array's task.
  std::string output(bool is_array) const;
  /// The last line that a task printed; "": none.
  std::string last_words(int item, bool is_array) const;
  /// Adds what an item has logged since the last time to another file, each line behind `prefix`; `is_last`: an
  /// unfinished line too.
  void move_log(int work_item, int item, const std::string& to, const std::string& prefix, bool is_last) const;

 private:
  std::string path_;
};

/// All batches of a daemon.
class SlurmFolder {
 public:
  SlurmFolder(const std::string& folder, const std::string& instance);
  /// Makes the folder and the script that Slurm is given. Throws Error(kEnvironment).
  void prepare() const;
  std::string script() const { return path_ + "/task.sh"; }
  SlurmBatchFolder batch(std::int64_t number) const;
  void remove(std::int64_t number) const;
  std::vector<std::int64_t> batches() const;

 private:
  std::string path_;
};

}  // namespace multum
