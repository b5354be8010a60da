// SPDX-License-Identifier: Apache-2.0
// Locks DATA, the daemon's folder, for one living process, and makes sure that nobody else can plant files in it: the
// ledger, uploads, results and logs are opened by name.
#pragma once

#include <memory>
#include <string>

#include "host/foundation/base/files/open_file.h"

namespace multum {

class DataLock {
 public:
  /// Makes the folder with mode 0700 if it is missing. A link to it is followed when this user or root made the link.
  /// Null when a living process has it. Throws Error(kEnvironment) when it cannot be made, belongs to somebody else but
  /// root, or when others may write to it.
  static std::unique_ptr<DataLock> take(const std::string& path);

 private:
  explicit DataLock(OpenFile folder) : folder_(std::move(folder)) {}
  OpenFile folder_;
};

}  // namespace multum
