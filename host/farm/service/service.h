// SPDX-License-Identifier: Apache-2.0
// Runs the daemon with its ledger, workers and web interface. It handles these signals:
//   SIGTERM, SIGINT   starts no more jobs, and hands back running jobs that do not end within the grace period
//   SIGHUP            reads the settings file again
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/farm/service/dispatch/service_settings.h"
#include "host/foundation/sandbox/confinement.h"

namespace multum {

struct ServiceOptions {
  ServiceSettings settings;
  std::string settings_file;                       // empty if none
  std::function<ServiceSettings()> read_settings;  // reads the settings file again, at SIGHUP
  std::vector<std::string> worker_command;         // command line of a worker, without its socket
  std::vector<std::string> driver_command;         // its exit code is 0 if workers find an OpenCL device
  Confinement system;                              // the part of the machine that every worker sees
  bool begins_anew = false;                        // makes a new ledger if the folder's ledger is lost
};

/// Runs until the daemon is told to stop. Throws Error if it cannot start.
void run_service(const ServiceOptions& options);

}  // namespace multum
