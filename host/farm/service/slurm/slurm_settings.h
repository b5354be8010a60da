// SPDX-License-Identifier: Apache-2.0
// Settings of what is sent to Slurm: [slurm] of serve.toml, which docs/reference/service.md lists.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace multum {

struct SlurmSettings {
  std::string folder;                    // of orders and what comes back, on all nodes by this name; "": no Slurm
  std::string partition, account;        // "": Slurm's own
  std::vector<std::string> arguments;    // more of sbatch's
  std::string program;                   // multum on the nodes; "": by the name that it has here
  std::vector<std::string> queues;       // whose jobs are sent
  std::vector<std::string> types;        // of jobs that are sent; none: all
  int jobs_max = 1000;                   // that Slurm has at a time, 1..100000
  int cpus = 2;                          // of a task, 1..1024
  int nice = 0;                          // of a job of priority 0
  double chunk_seconds = 30.0;           // of a task that does several jobs; 0: each has its own
  double share_seconds = 600.0;          // of processor time, of a share of a large map; 0: maps are not divided
  int rounds = 3;                        // of asking for shares that are missing, 1..100
  double time_factor = 4.0;              // time limits over what is estimated, at least 1
  std::chrono::seconds time_min{600};    // of time limits
  std::chrono::seconds time_max{86400};  // and of jobs of which nothing is known
  std::chrono::milliseconds poll{2000};
  std::chrono::milliseconds visible{10000};  // in which what a node has written is seen here
  std::chrono::milliseconds lease{120000};   // without a word of a task that runs

  bool is_on() const { return !folder.empty(); }
};

}  // namespace multum
