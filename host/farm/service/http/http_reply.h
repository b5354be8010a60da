// SPDX-License-Identifier: Apache-2.0
// Makes JSON answers and refusals. Code that must refuse a request throws a Refusal. The answer has the status of this
// Refusal.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/farm/service/dispatch/refusal.h"
#include "host/farm/service/http/http_server.h"
#include "host/foundation/base/error.h"

namespace multum {

HttpResponse json_response(const nlohmann::json& json, int status = 200);
/// Returns {"error": {"code", "message"}}.
HttpResponse refusal_response(const Refusal& refusal);
/// Returns the Content-Disposition of a download of this name (RFC 6266). The header has the ASCII characters of the
/// name and, if the name has other characters, the whole name as UTF-8.
std::string attachment(const std::string& name);
/// Returns 400 for usage and input errors, 507 for a disk without space, 503 for other errors of the environment.
Refusal refusal_of(const Error& error);

}  // namespace multum
