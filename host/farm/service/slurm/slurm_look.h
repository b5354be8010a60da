// SPDX-License-Identifier: Apache-2.0
// Checks the work sent to Slurm once. Reads Slurm's list of tasks, and then the tasks' files in the shared folder.
// Blocks.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/farm/service/slurm/slurm_commands.h"
#include "host/farm/service/slurm/slurm_folder.h"

namespace multum {

/// The number of the batch and the number of the item within it.
using SlurmPartKey = std::pair<std::int64_t, int>;

/// A part that the daemon watches.
struct SlurmWatched {
  SlurmPartKey key;
  bool is_array = false;
  std::string log, log_prefix;  // file for the part's output, and the prefix of each line

  /// The item whose work folder holds the part's log.
  int work_item() const { return is_array ? key.second : 0; }
};

struct SlurmLook {
  std::string trouble;  // why Slurm did not answer; "" if it answered
  std::vector<SlurmTask> tasks;
  std::optional<int> array_size_max;  // read from Slurm's settings, if requested
  struct Seen {
    std::optional<SlurmStatus> status;
    std::optional<SlurmEnd> end;
    std::string last_words;  // last line of its task's output, if the part has not ended
  };
  std::map<SlurmPartKey, Seen> parts;

  bool is_up() const { return trouble.empty(); }
};

/// `prefix` begins the names of this daemon's jobs at Slurm.
SlurmLook look_at_slurm(const SlurmCommands& commands, const SlurmFolder& folder, const std::string& prefix,
                        const std::vector<SlurmWatched>& watched);

/// Does the second half of a check. Lists each batch's folder once and opens only existing files. Thousands of parts
/// may wait, and each attempt to open a missing file would be a request to the file server. `watched` should be sorted
/// by key, because otherwise folders are listed more often.
void look_at_files(const SlurmFolder& folder, const std::vector<SlurmWatched>& watched,
                   std::map<SlurmPartKey, SlurmLook::Seen>& parts);

}  // namespace multum
