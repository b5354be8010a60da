// SPDX-License-Identifier: Apache-2.0
// Jobs touch files below the configured roots alone, by whatever name or link they come.
#pragma once

#include <string>
#include <vector>

namespace multum {

class PathRoots {
 public:
  /// Throws Error(kUsage) for a root that is no folder.
  explicit PathRoots(const std::vector<std::string>& roots);

  /// The file without links or dots. Throws Error(kUsage): not absolute, not there, no file, or outside of the roots;
  /// nothing is told of what lies outside.
  std::string input(const std::string& path) const;
  /// The same of a result to be: its folder must be there, and it may be a file, a folder, or not there; no link.
  std::string output(const std::string& path) const;
  bool is_inside(const std::string& canonical) const;
  const std::vector<std::string>& roots() const { return roots_; }

 private:
  [[noreturn]] void refuse(const std::string& path) const;
  std::vector<std::string> roots_;
};

}  // namespace multum
