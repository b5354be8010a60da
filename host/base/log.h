// SPDX-License-Identifier: Apache-2.0
// Messages for the person who runs the program, on stderr: results go to stdout, so that both can be piped apart.
#pragma once

#include <string>

namespace multum {

enum class LogLevel { kQuiet, kNormal, kVerbose };

void set_log_level(LogLevel level);
LogLevel log_level();

/// Something doubtful that does not stop the work. Shown unless quiet.
void log_warning(const std::string& message);
/// Logs what was detected or decided. Shown unless quiet.
void log_info(const std::string& message);
/// Plans, caches, timings. Shown with -v.
void log_verbose(const std::string& message);

}  // namespace multum
