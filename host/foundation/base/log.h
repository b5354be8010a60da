// SPDX-License-Identifier: Apache-2.0
// Messages for the person who runs the program, on stderr: results go to stdout, so that both can be piped apart.
#pragma once

#include <string>

namespace multum {

enum class LogLevel { kQuiet, kNormal, kVerbose };

void set_log_level(LogLevel level);
LogLevel log_level();

/// Something doubtful that does not stop the work, about `subject`: the file, or else the library that said it. Shown
/// unless quiet, as "warning: SUBJECT: MESSAGE", so that it can be told which of many files is meant.
void log_warning(const std::string& subject, const std::string& message);
/// The same of a text that begins with its subject: one that HeldWarnings kept, or that a report has.
void log_named_warning(const std::string& warning);
/// Logs what was detected or decided. Shown unless quiet.
void log_info(const std::string& message);
/// Plans, caches, timings. Shown with -v.
void log_verbose(const std::string& message);

}  // namespace multum
