// SPDX-License-Identifier: Apache-2.0
// Locks a folder for one living process.
#pragma once

#include <memory>
#include <string>

namespace multum {

class FolderLock {
 public:
  /// Makes the folder if it is not there. Null when a living process has it. Throws Error(kEnvironment) when it cannot
  /// be made.
  static std::unique_ptr<FolderLock> take(const std::string& path);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace multum
