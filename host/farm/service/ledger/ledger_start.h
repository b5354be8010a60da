// SPDX-License-Identifier: Apache-2.0
// Finds the ledger that a start of the daemon goes on with. DATA/instance and the ledger name each other: a folder that
// was used before is not begun anew because its ledger is missing, empty or another's.
#pragma once

#include <string>

#include "host/farm/service/ledger/job_queue.h"
#include "host/farm/service/ledger/queue_thread.h"

namespace multum {

/// DATA/instance; "": it is not there, or holds no name.
std::string read_instance(const std::string& data);

/// Finds the ledger before it is opened. `begins_anew`: by `--new-ledger`, for a folder whose ledger is lost. Throws
/// Error(kEnvironment) for a ledger that is missing or empty where there was one, Error(kUsage) for one that is there
/// and would be forgotten.
LedgerSettings find_ledger(const std::string& data, RetryPolicy retry, bool begins_anew);

/// Takes up an opened ledger: its numbers go on above all that lies in the folder, which takes its name. Returns that
/// name.
std::string take_up_ledger(QueueThread& ledger, const std::string& data);

}  // namespace multum
