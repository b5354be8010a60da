// SPDX-License-Identifier: Apache-2.0
// Reads the daemon's settings from serve.toml, whose keys docs/reference/service.md lists, and from its command line,
// which takes precedence.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "host/farm/service/ledger/job_queue.h"
#include "host/farm/service/slurm/slurm_settings.h"
#include "host/foundation/sandbox/confinement.h"

namespace multum {

struct ServiceSettings {
  std::string data;                       // folder of the ledger, logs and uploads
  std::string listen = "127.0.0.1:8470";  // HOST:PORT, [::1]:PORT or unix:PATH; port 0 means any free port
  std::string token_file;                 // file whose first line is the bearer token; required except on loopback
  std::vector<std::string> roots;         // folders that jobs may read and write, at least one
  int workers = 2;                        // 1..256
  int threads_a_worker = 0;               // 0 divides the cores among the workers
  std::map<std::string, QueueLimits> queues = {{"default", {}}};
  std::map<std::string, int> devices;  // simultaneous jobs per device
  std::int64_t memory_max = 0;         // bytes of all running jobs; 0 means three quarters of the machine's memory
  RetryPolicy retry;
  std::chrono::milliseconds lease{10000};
  std::chrono::milliseconds no_progress{600000};
  std::chrono::milliseconds cancel_grace{10000};
  std::chrono::milliseconds shutdown_grace{30000};  // time for running jobs at shutdown, before they are handed back
  int upload_bytes_max = 64 << 20;
  int retention_days = 30;                         // age at which finished jobs and logs are removed; 0 means never
  std::int64_t data_max = std::int64_t{20} << 30;  // bytes of uploads, results and logs in `data`; 0 means no limit
  int upload_days = 7;                             // age limit of uploads that no job waits for; 0 means no limit
  int connections_max = 4096;
  std::int64_t request_memory_max = 256 << 20;  // bytes of all requests and answers in progress
  SlurmSettings slurm;
};

/// Throws Error(kInput), which names the file, the line, the value found and the value expected.
void read_service_settings(const std::string& path, ServiceSettings& settings);

/// Throws Error(kUsage) for an invalid address, an address that others can reach without a token, or missing roots. A
/// root must not contain the daemon's data, token, settings or socket, because jobs could then write to these. A root
/// must not be inside the data either. The data, token, settings and socket must not be in `system`, which is the part
/// of the machine that every worker sees. `settings_file` may be empty.
void check_service_settings(const ServiceSettings& settings, const std::string& settings_file,
                            const Confinement& system);

/// An address to listen on.
struct ListenAddress {
  std::string unix_path;  // if empty, host and port are used
  std::string host;
  int port = 0;
  bool is_loopback() const { return !unix_path.empty() || host == "127.0.0.1" || host == "::1"; }
};
ListenAddress parse_listen_address(const std::string& text);

}  // namespace multum
