// SPDX-License-Identifier: Apache-2.0
// Keeps warnings instead of showing them: those of trials are doubts about settings that nobody asked for, and belong
// to the report of what was tried.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// While it lives, it keeps what log_warning() and log_named_warning() are told, by all threads, with its subject. One
/// inside another has its own.
class HeldWarnings {
 public:
  HeldWarnings();
  ~HeldWarnings();
  HeldWarnings(const HeldWarnings&) = delete;
  HeldWarnings& operator=(const HeldWarnings&) = delete;
  /// In their order; none are left.
  std::vector<std::string> take();

  /// True when one was there to keep it.
  static bool keep(const std::string& message);

 private:
  std::vector<std::string> held_;
  HeldWarnings* outer_;
};

}  // namespace multum
