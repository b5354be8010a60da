// SPDX-License-Identifier: Apache-2.0
// Confines whoever reads and writes to files below some folders, by whatever name or link they come, and whatever
// becomes of a name after it was looked at: a file is opened beneath its root's descriptor by a name without links
// (openat2), or not at all.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/foundation/base/files/open_file.h"

namespace multum {

/// Opens a name below an open folder, by no link anywhere. Not open, with errno, where that fails.
OpenFile open_beneath_folder(const OpenFile& folder, const std::string& relative, int flags);

class PathRoots {
 public:
  /// Throws Error(kUsage) for a root that is no folder; Error(kEnvironment) where the system has no openat2 (Linux
  /// before 5.6).
  explicit PathRoots(const std::vector<std::string>& roots);

  /// The file without links or dots. Throws Error(kUsage): not absolute, not there, no file, or outside of the roots;
  /// nothing is told of what lies outside.
  std::string input(const std::string& path) const;
  /// The same for a result to be written: its folder must be there, and it may be a file, a folder, or not there; no
  /// link.
  std::string output(const std::string& path) const;
  bool is_inside(const std::string& canonical) const;
  const std::vector<std::string>& roots() const { return roots_; }

  /// Opens for reading what input() named. Throws Error(kUsage) when it is no file below its root any more: taken away,
  /// a link by now, or its root another folder.
  OpenFile open_input(const std::string& canonical) const;
  /// The folder that a result of output() lies in. Throws likewise.
  OpenFile open_folder_of(const std::string& canonical) const;

 private:
  [[noreturn]] void refuse(const std::string& path) const;
  OpenFile open_beneath(const std::string& canonical, int flags) const;
  std::vector<std::string> roots_;
  std::vector<std::shared_ptr<const OpenFile>> descriptors_;
};

}  // namespace multum
