// SPDX-License-Identifier: Apache-2.0
// Answers in JSON, and refusals: thrown by whoever finds a reason, answered with their status.
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
/// {"error": {"code", "message"}}.
HttpResponse refusal_response(const Refusal& refusal);
/// Content-Disposition of a download of this name (RFC 6266): with what ASCII has of it, and all of it as UTF-8 where
/// that is not the same.
std::string attachment(const std::string& name);
/// 400 for usage and input errors, 507 where the disk takes no more, 503 for others of the environment.
Refusal refusal_of(const Error& error);

}  // namespace multum
