// SPDX-License-Identifier: Apache-2.0
// Writes the daemon's log as JSON objects on stderr, one per line. Such lines can be collected by systemd and container
// platforms.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

enum class LogSeverity { kInfo, kWarning, kError };

/// Writes {"time": ..., "level": "info", "job": 12, "message": "..."}. Job 0 means no job. May be called from any
/// thread.
void service_log(LogSeverity severity, std::int64_t job, const std::string& message);

}  // namespace multum
