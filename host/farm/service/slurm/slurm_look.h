// SPDX-License-Identifier: Apache-2.0
// One look at what was sent to Slurm: at Slurm's list of tasks, then at what they have left in the shared folder. It
// blocks.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/farm/service/slurm/slurm_commands.h"
#include "host/farm/service/slurm/slurm_folder.h"

namespace multum {

/// Batch and item.
using SlurmPartKey = std::pair<std::int64_t, int>;

/// A part that is looked after.
struct SlurmWatched {
  SlurmPartKey key;
  bool is_array = false;
  std::string log, log_prefix;  // where what it prints goes, and behind what

  /// The item whose worker does it.
  int work_item() const { return is_array ? key.second : 0; }
};

struct SlurmLook {
  std::string trouble;  // why Slurm did not answer; "": it did
  std::vector<SlurmTask> tasks;
  std::optional<int> array_size_max;  // of its settings, where they were asked for
  struct Seen {
    std::optional<SlurmStatus> status;
    std::optional<SlurmEnd> end;
    std::string last_words;  // of its task, where it has not ended
  };
  std::map<SlurmPartKey, Seen> parts;

  bool is_up() const { return trouble.empty(); }
};

/// `prefix`: of the names of this daemon's jobs at Slurm.
SlurmLook look_at_slurm(const SlurmCommands& commands, const SlurmFolder& folder, const std::string& prefix,
                        const std::vector<SlurmWatched>& watched);

/// Its second half. A batch's folder is listed once, and of its files only those are opened that are there: with
/// thousands of parts that wait, each file that is asked for and not there is a question to the folder's server.
/// `watched` in the order of their keys, or batches are listed more often.
void look_at_files(const SlurmFolder& folder, const std::vector<SlurmWatched>& watched,
                   std::map<SlurmPartKey, SlurmLook::Seen>& parts);

}  // namespace multum
