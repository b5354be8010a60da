// SPDX-License-Identifier: Apache-2.0
// Writes the answer to GET /metrics in the text format of Prometheus.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "host/farm/service/dispatch/dispatcher.h"
#include "host/farm/service/http/http_server.h"

namespace multum {

std::string metrics_text(const std::map<std::string, std::map<JobState, std::int64_t>>& jobs,
                         const Dispatcher& dispatcher, const HttpServer::Counters& http, std::size_t ledger_pending);

}  // namespace multum
