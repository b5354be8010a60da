// SPDX-License-Identifier: Apache-2.0
// Silences the log, for work whose findings another part of the program has already reported.
#pragma once

#include "host/foundation/base/log.h"

namespace multum {

/// Logs nothing while an object exists.
class QuietLog {
 public:
  QuietLog() : level_(log_level()) { set_log_level(LogLevel::kQuiet); }
  ~QuietLog() { set_log_level(level_); }
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;

 private:
  LogLevel level_;
};

}  // namespace multum
