// SPDX-License-Identifier: Apache-2.0
// Manages a folder for a benchmark's maps and results. The folder is removed when the benchmark ends or is cancelled.
#pragma once

#include <string>

namespace multum::bench {

class ScratchFolder {
 public:
  /// Makes the folder in `parent`, or in the system's temporary folder if `parent` is empty. Throws
  /// Error(kEnvironment).
  explicit ScratchFolder(const std::string& parent);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// Writes a file and its directory entry from the system's cache to the disk. Throws Error(kEnvironment) if this fails.
void sync_file(const std::string& path);

}  // namespace multum::bench
