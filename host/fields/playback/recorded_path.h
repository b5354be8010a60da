// SPDX-License-Identifier: Apache-2.0
// A path through the parameters of a field that somebody wandered in the browser's player (runtime_gl/web,
// recorded_path.js), as its file has it (docs/reference/packed_fields.md, "Recorded paths"):
//
//      { "multumPath": 1, "parameters": ["view", "light"], "positions": [[0, 0.5, 3], ...] }
#pragma once

#include <string>
#include <vector>

namespace multum {

class RecordedPath {
 public:
  /// Of a file's text. `names`: the field's parameters, which the path must be through. Throws Error(kInput) saying
  /// what was found and what was expected; the file is not named.
  RecordedPath(const std::string& text, const std::vector<std::string>& names);

  /// From the first position to the last, at least 0.
  double seconds() const { return times_.back() - times_.front(); }
  /// The value of every parameter `seconds`, at least 0, after the first position; from its end it begins again.
  std::vector<double> at(double seconds) const;

 private:
  std::vector<double> times_;  // of positions, not falling
  std::vector<std::vector<double>> positions_;
};

/// Whether --path names a file of a recorded path, not an expression: none ends in .json.
bool is_recorded_path(const std::string& path);
/// Throws Error(kInput) naming the file.
RecordedPath read_recorded_path(const std::string& path, const std::vector<std::string>& names);

}  // namespace multum
