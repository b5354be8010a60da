// SPDX-License-Identifier: Apache-2.0
// Collects warnings instead of showing them. For example, warnings of trial runs are about settings that the user did
// not choose, so they belong in the report of the trials.
#pragma once

#include <mutex>
#include <string>
#include <vector>

namespace multum {

/// While an object exists, it collects the warnings of log_warning() and log_named_warning() with their subjects. It
/// collects them from the thread that made it and from threads that work for this thread. A nested object collects its
/// warnings separately.
class HeldWarnings {
 public:
  HeldWarnings();
  ~HeldWarnings();
  HeldWarnings(const HeldWarnings&) = delete;
  HeldWarnings& operator=(const HeldWarnings&) = delete;
  /// Returns the collected warnings in order and empties the collection.
  std::vector<std::string> take();

  /// Passes the message to the innermost object of this thread; returns false if there is no such object.
  static bool keep(const std::string& message);

 private:
  std::mutex mutex_;
  std::vector<std::string> held_;
  HeldWarnings* outer_;
};

}  // namespace multum
