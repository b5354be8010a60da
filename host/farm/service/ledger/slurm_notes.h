// SPDX-License-Identifier: Apache-2.0
// Notes in the ledger of what was sent to Slurm: a daemon that is started again knows what it has there, and what Slurm
// has that nobody waits for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/ledger/sqlite_database.h"

namespace multum {

enum class SlurmPartState { kSent, kSucceeded, kFailed, kLost, kCancelled };

/// "sent" ... "cancelled".
const char* slurm_part_state_name(SlurmPartState state);

/// A part of a job's attempt, done by a task of Slurm. Each job of Slurm's is a batch: of parts of many jobs, one after
/// the other in one task, or of an array of tasks, a share of one map each.
struct SlurmPart {
  std::int64_t batch = 0;
  int item = 0;  // within the batch; of an array the task's number
  std::int64_t job = 0;
  int attempt = 0;
  std::string share;  // "": all of the job; "3/8": a share of its map; "merge 8": their merge
  int round = 1;      // shares that are missing are asked for again
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
  /// State, node, exit code and message.
  void update(const SlurmPart& part);
  /// Parts that are with Slurm, in order.
  std::vector<SlurmPart> sent();
  bool has_sent(std::int64_t job, int attempt);
  std::vector<SlurmPart> of_job(std::int64_t job);
  /// Highest number of a batch; 0: there is none.
  std::int64_t last_batch();
  /// Parts of jobs whose attempt has ended are cancelled.
  void cancel_orphans();

 private:
  std::vector<SlurmPart> rows(SqliteStatement& query);
  SqliteDatabase& database_;
};

}  // namespace multum
