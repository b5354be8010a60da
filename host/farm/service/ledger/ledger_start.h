// SPDX-License-Identifier: Apache-2.0
// Finds the ledger that the daemon continues. DATA/instance and the ledger contain the same name. If a folder has been
// used before and its ledger is missing, empty or from another folder, the daemon does not start a new one by itself.
#pragma once

#include <string>

#include "host/farm/service/ledger/job_queue.h"
#include "host/farm/service/ledger/queue_thread.h"

namespace multum {

/// Reads DATA/instance. Returns "" if the file is missing or contains no name.
std::string read_instance(const std::string& data);

/// Finds the ledger before it is opened. `begins_anew` means that `--new-ledger` was given, for a folder whose ledger
/// is lost. Throws Error(kEnvironment) if a used folder's ledger is missing or empty, and Error(kUsage) if a new one
/// would replace an existing one.
LedgerSettings find_ledger(const std::string& data, RetryPolicy retry, bool begins_anew);

/// Continues an opened ledger. New numbers begin above all numbers in the folder, and the folder gets the ledger's
/// name. Returns this name.
std::string take_up_ledger(QueueThread& ledger, const std::string& data);

}  // namespace multum
