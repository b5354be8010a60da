// SPDX-License-Identifier: Apache-2.0
// Runs the event loop of a serving thread. If a handler throws, usually for lack of memory, only its own work is lost.
// The other handlers continue.
#pragma once

#include <boost/asio/io_context.hpp>
#include <string>

#include "host/farm/service/log/service_log.h"

namespace multum {

/// Runs until `io` is stopped or has no work. Logs exceptions with this severity, each after the text `what`.
void run_handlers(boost::asio::io_context& io, LogSeverity severity, const std::string& what);

}  // namespace multum
