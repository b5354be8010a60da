// SPDX-License-Identifier: Apache-2.0
// Uses Slurm through its commands sbatch, squeue and scancel, found in PATH and started without a shell. All functions
// block.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/slurm/slurm_settings.h"
#include "host/foundation/base/processes/child_process.h"

namespace multum {

struct SlurmSubmission {
  std::string name, comment;
  std::string script;                // runs the words that follow it
  std::vector<std::string> command;  // the words that the script runs
  std::string output;                // file for a task's output, with Slurm's placeholders
  std::vector<int> array;            // numbers of its tasks; if empty, one task without a number
  std::vector<std::int64_t> after;   // starts when these jobs have ended in any way
  std::int64_t memory_bytes = 0;     // 0 means Slurm's default
  int nice = 0;
  std::chrono::seconds time_max{0};
};

/// A task in Slurm's list.
struct SlurmTask {
  std::int64_t job = 0;
  int item = -1;  // the task's number in the array; -1 if it is not in an array
  std::string name, state, reason, node;

  /// Returns whether the task will not run again.
  bool is_over() const;
  /// Returns whether the task needs an intervention by a person before it can run.
  bool is_stuck() const;
};

/// Returns the name of a task for scancel and scontrol, such as "12" or "12_3".
std::string slurm_task_name(std::int64_t job, int item);

/// The reason why sbatch refused an order, according to its error message.
enum class SlurmRefusal {
  kNotNow,        // the controller does not answer, or accepts nothing at present; the same order may succeed later
  kNever,         // a wrong partition or account, or a limit; the order fails until the settings are changed
  kArrayTooLong,  // task numbers reach MaxArraySize; smaller arrays may succeed
  kUnknown,       // the message is not known; the cause may be any of the above
};
/// Compares the message with the texts of slurm_strerror(), which are not translated.
SlurmRefusal refusal_of(const std::string& said);

/// A job to cancel, given by name and number, or one of its tasks. Item -1 means the whole job. The name is needed
/// because a controller that has lost a job reuses its number.
struct SlurmTarget {
  std::string name;
  std::int64_t job = 0;
  int item = -1;
};

class SlurmCommands {
 public:
  /// `is_stopped` is called while a command runs. If it returns true, the command is killed.
  SlurmCommands(SlurmSettings settings, std::function<bool()> is_stopped);

  /// Returns the number of the Slurm job. Throws Error(kEnvironment) with sbatch's message (refusal_of()).
  std::int64_t submit(const SlurmSubmission& submission) const;
  /// Returns Slurm's MaxArraySize, which is above all task numbers, or nullopt if scontrol does not print it.
  std::optional<int> array_size_max() const;
  /// Returns this user's tasks whose names begin with `prefix`, including tasks that ended some minutes ago. Throws
  /// Error(kEnvironment) when Slurm does not answer.
  std::vector<SlurmTask> list(const std::string& prefix) const;
  /// Skips tasks that do not exist, or have another name. Throws Error(kEnvironment) when scancel prints anything.
  void cancel(const std::vector<SlurmTarget>& targets) const;

 private:
  ChildResult run_to_end(const std::vector<std::string>& words) const;
  std::string run(const std::vector<std::string>& words) const;
  SlurmSettings settings_;
  std::function<bool()> is_stopped_;
};

/// Reads MaxArraySize from the output of `scontrol show config`.
std::optional<int> parse_array_size_max(const std::string& text);

/// Parses the output of `squeue --format=%F|%K|%T|%N|%j|%r`, which has one task per line. Skips other lines.
std::vector<SlurmTask> parse_squeue(const std::string& text);

}  // namespace multum
