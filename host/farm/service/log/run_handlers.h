// SPDX-License-Identifier: Apache-2.0
// Runs the loop of a thread that serves: a handler that throws, for want of memory as a rule, costs what it was at, and
// the others go on.
#pragma once

#include <boost/asio/io_context.hpp>
#include <string>

#include "host/farm/service/log/service_log.h"

namespace multum {

/// Until `io` is stopped or has nothing to do. An exception is logged so, behind `what`.
void run_handlers(boost::asio::io_context& io, LogSeverity severity, const std::string& what);

}  // namespace multum
