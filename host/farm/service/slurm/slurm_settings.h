// SPDX-License-Identifier: Apache-2.0
// The settings for Slurm, which are in the table [slurm] of serve.toml. docs/reference/service.md lists its keys.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace multum {

struct SlurmSettings {
  std::string folder;                    // folder for orders and results, same path on all nodes; "" disables Slurm
  std::string partition, account;        // "" means Slurm's default
  std::vector<std::string> arguments;    // further arguments of sbatch
  std::string program;                   // path of multum on the nodes; "" means the same path as on this machine
  std::vector<std::string> queues;       // queues whose jobs are sent
  std::vector<std::string> types;        // types of jobs that are sent; empty means all
  int jobs_max = 1000;                   // jobs at Slurm at the same time, 1..100000
  int cpus = 2;                          // processors per task, 1..1024
  int nice = 0;                          // nice value of a job of priority 0
  double chunk_seconds = 30.0;           // seconds per task with several jobs; 0 means one job per task
  double share_seconds = 600.0;          // processor time per share of a large map; with 0, maps are not divided
  int rounds = 3;                        // number of times that missing shares are requested, 1..100
  double time_factor = 4.0;              // ratio of a time limit to the estimated time, at least 1
  std::chrono::seconds time_min{600};    // smallest time limit
  std::chrono::seconds time_max{86400};  // largest time limit; also used for jobs of unknown cost
  std::chrono::milliseconds poll{2000};
  std::chrono::milliseconds visible{10000};  // longest delay until a node's files are visible to the daemon
  std::chrono::milliseconds lease{120000};   // longest silence of a running task

  bool is_on() const { return !folder.empty(); }
};

}  // namespace multum
