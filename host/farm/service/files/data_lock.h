// SPDX-License-Identifier: Apache-2.0
// Locks the daemon's folder DATA for one living process. Also ensures that no other user can put files into the folder,
// because the daemon opens its ledger, uploads, results and logs there by name.
#pragma once

#include <memory>
#include <string>

#include "host/foundation/base/files/open_file.h"

namespace multum {

class DataLock {
 public:
  /// Creates the folder with mode 0700 if it is missing. Follows a link to the folder if this user or root made the
  /// link. Returns null when a living process holds the lock. Throws Error(kEnvironment) when the folder cannot be
  /// created, belongs to a user other than this one and root, or is writable for others.
  static std::unique_ptr<DataLock> take(const std::string& path);

 private:
  explicit DataLock(OpenFile folder) : folder_(std::move(folder)) {}
  OpenFile folder_;
};

}  // namespace multum
