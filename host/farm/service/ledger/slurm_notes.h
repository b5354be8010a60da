// SPDX-License-Identifier: Apache-2.0
// Records the jobs that were sent to Slurm in the ledger. A restarted daemon then knows its jobs at Slurm, including
// those that no client waits for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/ledger/sqlite_database.h"

namespace multum {

enum class SlurmPartState { kSent, kSucceeded, kFailed, kLost, kCancelled };

/// Returns "sent" ... "cancelled".
const char* slurm_part_state_name(SlurmPartState state);

/// A part of a job's attempt that a Slurm task does. Each Slurm job is a batch. A batch is either one task that does
/// parts of many jobs one after the other, or an array of tasks that each do one share of a map.
struct SlurmPart {
  std::int64_t batch = 0;
  int item = 0;  // number within the batch; in an array, the task's number
  std::int64_t job = 0;
  int attempt = 0;
  std::string share;  // "" for the whole job, "3/8" for a share of its map, "merge 8" for the merge of 8 shares
  int round = 1;      // increases when missing shares are requested again
  std::optional<std::int64_t> slurm_job;
  SlurmPartState state = SlurmPartState::kSent;
  std::string node;
  std::optional<int> exit_code;
  std::string message;
};

class SlurmNotes {
 public:
  explicit SlurmNotes(SqliteDatabase& database) : database_(database) {}

  void add(const SlurmPart& part);
  void set_slurm_job(std::int64_t batch, std::int64_t slurm_job);
  /// Updates state, node, exit code and message.
  void update(const SlurmPart& part);
  /// Returns the parts that are at Slurm, in order.
  std::vector<SlurmPart> sent();
  bool has_sent(std::int64_t job, int attempt);
  std::vector<SlurmPart> of_job(std::int64_t job);
  /// Returns the highest number of a batch, or 0 if there is no batch yet.
  std::int64_t last_batch();
  /// Cancels parts of jobs whose attempts have ended.
  void cancel_orphans();

 private:
  std::vector<SlurmPart> rows(SqliteStatement& query);
  SqliteDatabase& database_;
};

}  // namespace multum
