// SPDX-License-Identifier: Apache-2.0
// Writes messages for the user to stderr. Results go to stdout, so users can pipe the two separately.
#pragma once

#include <string>

namespace multum {

enum class LogLevel { kQuiet, kNormal, kVerbose };

void set_log_level(LogLevel level);
LogLevel log_level();

/// Warns about a possible problem with `subject`. The work continues. `subject` is a file, or the library that reported
/// the problem. Unless the log is quiet, shows "warning: SUBJECT: MESSAGE", so that users know which of many files the
/// warning is about.
void log_warning(const std::string& subject, const std::string& message);
/// Works like log_warning() for a text that begins with its subject. Such texts come from HeldWarnings or from a
/// report.
void log_named_warning(const std::string& warning);
/// Logs findings and decisions. These messages are shown unless the log is quiet.
void log_info(const std::string& message);
/// Logs plans, caches and timings. These messages are shown only with -v.
void log_verbose(const std::string& message);

}  // namespace multum
