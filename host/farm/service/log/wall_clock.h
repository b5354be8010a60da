// SPDX-License-Identifier: Apache-2.0
// Times as the service keeps and writes them.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

/// Milliseconds since 1970, by the machine's clock: for people, back-off and deadlines. Leases and timeouts of running
/// jobs are measured by a clock that never goes back, in the process that holds them.
using TimeMs = std::int64_t;

TimeMs wall_clock_ms();

/// "2026-11-22T07:30:00.123Z".
std::string time_text(TimeMs time);

}  // namespace multum
