// SPDX-License-Identifier: Apache-2.0
// Speaks with Slurm by its commands, sbatch, squeue and scancel, as they are found in PATH: words, no shell. All of it
// blocks.
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
  std::string script;                // that runs the words behind it
  std::vector<std::string> command;  // these words
  std::string output;                // file of what a task prints, with Slurm's marks
  std::vector<int> array;            // numbers of its tasks; none: one task without a number
  std::vector<std::int64_t> after;   // begins when these jobs have ended, however
  std::int64_t memory_bytes = 0;     // 0: Slurm's default
  int nice = 0;
  std::chrono::seconds time_max{0};
};

/// A task as Slurm has it.
struct SlurmTask {
  std::int64_t job = 0;
  int item = -1;  // its number in the array; -1: none
  std::string name, state, reason, node;

  /// It will run no more.
  bool is_over() const;
  /// It will not run unless somebody intervenes.
  bool is_stuck() const;
};

/// How scancel and scontrol name it: "12" or "12_3".
std::string slurm_task_name(std::int64_t job, int item);

/// What sbatch's words mean for who wants to send.
enum class SlurmRefusal {
  kNotNow,        // the controller does not answer, or takes nothing at the moment: later the same will do
  kNever,         // a partition, an account, a limit: until somebody changes settings, the same will be refused
  kArrayTooLong,  // numbers of tasks reach MaxArraySize; smaller arrays may do
  kUnknown,       // it may be any of them
};
/// By the texts of slurm_strerror(), which are the same in every language.
SlurmRefusal refusal_of(const std::string& said);

/// What is to be cancelled: a job of this name and number, or a task of it; item -1: all of it. A controller that has
/// forgotten a job gives its number to the next, which has another name.
struct SlurmTarget {
  std::string name;
  std::int64_t job = 0;
  int item = -1;
};

class SlurmCommands {
 public:
  /// `is_stopped`: asked while a command runs, which is killed then.
  SlurmCommands(SlurmSettings settings, std::function<bool()> is_stopped);

  /// Number of Slurm's job. Throws Error(kEnvironment) with what sbatch says (refusal_of()).
  std::int64_t submit(const SlurmSubmission& submission) const;
  /// Slurm's MaxArraySize, which numbers of an array's tasks stay below. Nothing where scontrol does not say.
  std::optional<int> array_size_max() const;
  /// Tasks of this user whose names begin so, those that have ended some minutes ago too. Throws Error(kEnvironment)
  /// when Slurm does not answer.
  std::vector<SlurmTask> list(const std::string& prefix) const;
  /// Those that are not there, or of another name, are passed over. Throws Error(kEnvironment) when scancel says
  /// anything.
  void cancel(const std::vector<SlurmTarget>& targets) const;

 private:
  ChildResult run_to_end(const std::vector<std::string>& words) const;
  std::string run(const std::vector<std::string>& words) const;
  SlurmSettings settings_;
  std::function<bool()> is_stopped_;
};

/// MaxArraySize of `scontrol show config`.
std::optional<int> parse_array_size_max(const std::string& text);

/// Of `squeue --format=%F|%K|%T|%N|%j|%r`, a line a task; lines of other kinds are passed over.
std::vector<SlurmTask> parse_squeue(const std::string& text);

}  // namespace multum
