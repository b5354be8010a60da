// SPDX-License-Identifier: Apache-2.0
// The daemon: ledger, workers, web interface, signals.
//   SIGTERM, SIGINT   no more jobs are started; those that run may end within the grace, then they are handed back
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
  std::string settings_file;                       // empty: none
  std::function<ServiceSettings()> read_settings;  // the same again, as the file is by then: at SIGHUP
  std::vector<std::string> worker_command;         // of a worker, without its socket
  std::vector<std::string> driver_command;         // ends with exit code 0 where a worker finds an OpenCL device
  Confinement system;                              // what of the machine every worker sees
  bool begins_anew = false;                        // a new ledger, where the folder's is lost
};

/// Until it is asked to end. Throws Error for what keeps it from starting.
void run_service(const ServiceOptions& options);

}  // namespace multum
