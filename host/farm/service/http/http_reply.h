// SPDX-License-Identifier: Apache-2.0
// Makes JSON answers and refusals. If code must refuse a request, it throws a Refusal, whose status becomes the status
// of the answer.
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
/// Returns the Content-Disposition header for a download of this name (RFC 6266). The header has the ASCII characters
/// of the name. If the name has other characters, the header also has the whole name as UTF-8.
std::string attachment(const std::string& name);
/// Returns 400 for usage and input errors, 507 for a disk without space, and 503 for other errors of the environment.
Refusal refusal_of(const Error& error);

}  // namespace multum
