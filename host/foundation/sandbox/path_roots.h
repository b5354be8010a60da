// SPDX-License-Identifier: Apache-2.0
// Confines reading and writing to files below certain folders. This works no matter which names and links are used, and
// even if a name changes after its check. A file is opened only beneath its root's descriptor, by a name without links
// (openat2).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/foundation/base/files/open_file.h"

namespace multum {

/// Opens a name below an open folder without following any link. On failure, the result is not open, and errno gives
/// the reason.
OpenFile open_beneath_folder(const OpenFile& folder, const std::string& relative, int flags);

class PathRoots {
 public:
  /// Throws Error(kUsage) for a root that is not a folder. Throws Error(kEnvironment) if the system has no openat2
  /// (Linux before 5.6).
  explicit PathRoots(const std::vector<std::string>& roots);

  /// Returns the file's path without links or dots. Throws Error(kUsage) if the path is not absolute, missing, not a
  /// file, or outside the roots. The message reveals nothing about files outside.
  std::string input(const std::string& path) const;
  /// Works like input() for the path of a result. The folder of the path must exist. The path itself may be a file, a
  /// folder or missing, but not a link.
  std::string output(const std::string& path) const;
  bool is_inside(const std::string& canonical) const;
  const std::vector<std::string>& roots() const { return roots_; }

  /// Opens a path that input() returned, for reading. Throws Error(kUsage) if the path does not name a file below its
  /// root any more, because the file was removed or replaced by a link, or because the root is now another folder.
  OpenFile open_input(const std::string& canonical) const;
  /// Opens the folder of a path returned by output(). Throws like open_input().
  OpenFile open_folder_of(const std::string& canonical) const;

 private:
  [[noreturn]] void refuse(const std::string& path) const;
  OpenFile open_beneath(const std::string& canonical, int flags) const;
  std::vector<std::string> roots_;
  std::vector<std::shared_ptr<const OpenFile>> descriptors_;
};

}  // namespace multum
