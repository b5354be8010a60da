// SPDX-License-Identifier: Apache-2.0
// The hidden folder beside an output, .multum-partial-NAME, for what is done of it so far, so that work that was
// stopped is resumed. Locked for one living process.
#pragma once

#include <memory>
#include <string>

#include "host/base/files/folder_lock.h"

namespace multum {

class PartialFolder {
 public:
  /// Makes it if it is not there. Null while another process has it. Throws Error(kEnvironment).
  static std::unique_ptr<PartialFolder> take(const std::string& output);
  /// Removes what stopped work left, if there is any and no other process has it.
  static void drop(const std::string& output);
  /// Removes the folder, unless leave() was called.
  ~PartialFolder();
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  const std::string& path() const { return path_; }
  /// Removes what is in it; what cannot go is written over, or cannot be.
  void clear() const;
  /// The folder stays when this is destroyed: the work was stopped and may go on.
  void leave() { stays_ = true; }

 private:
  PartialFolder(std::string path, std::unique_ptr<FolderLock> lock) : path_(std::move(path)), lock_(std::move(lock)) {}

  std::string path_;
  std::unique_ptr<FolderLock> lock_;
  bool stays_ = false;
};

}  // namespace multum
