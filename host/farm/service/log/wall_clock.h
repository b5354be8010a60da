// SPDX-License-Identifier: Apache-2.0
// Makes times in the form that the service stores and writes.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

/// Returns the milliseconds since 1970 on the machine's clock, for displayed times, back-off and deadlines. Leases and
/// timeouts of running jobs instead use a monotonic clock in the process that holds them.
using TimeMs = std::int64_t;

TimeMs wall_clock_ms();

/// Returns "2026-11-22T07:30:00.123Z", for example.
std::string time_text(TimeMs time);

}  // namespace multum
