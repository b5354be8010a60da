// SPDX-License-Identifier: Apache-2.0
// Reads a path through the parameters of a field that a user recorded in the browser's player (runtime_gl/web,
// recorded_path.js; docs/reference/packed_fields.md, "Recorded paths"):
//
//      { "multumPath": 1, "parameters": ["view", "light"], "positions": [[0, 0.5, 3], ...] }
#pragma once

#include <string>
#include <vector>

namespace multum {

class RecordedPath {
 public:
  /// Parses the text of a file. `names` are the field's parameters, and the path must have the same ones. Throws
  /// Error(kInput) with the value found and the value expected. The caller adds the file's name.
  RecordedPath(const std::string& text, const std::vector<std::string>& names);

  /// Returns the time from the first position to the last, at least 0.
  double seconds() const { return times_.back() - times_.front(); }
  /// Returns the values of all parameters at the time `seconds` after the first position. `seconds` is at least 0. The
  /// path starts again after its end.
  std::vector<double> at(double seconds) const;

 private:
  std::vector<double> times_;  // times of positions, in ascending order
  std::vector<std::vector<double>> positions_;
};

/// Returns whether the value of --path is the file of a recorded path. The name of such a file ends in .json, whereas
/// expressions never do.
bool is_recorded_path(const std::string& path);
/// Throws Error(kInput), which names the file.
RecordedPath read_recorded_path(const std::string& path, const std::vector<std::string>& names);

}  // namespace multum
