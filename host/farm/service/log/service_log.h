// SPDX-License-Identifier: Apache-2.0
// The daemon's log: JSON objects, one a line, on stderr, where systemd and container platforms collect them.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

enum class LogSeverity { kInfo, kWarning, kError };

/// {"time": ..., "level": "info", "job": 12, "message": "..."}; job 0: of none. From any thread.
void service_log(LogSeverity severity, std::int64_t job, const std::string& message);

}  // namespace multum
