// SPDX-License-Identifier: Apache-2.0
#include "host/service/http_reply.h"

#include <nlohmann/json.hpp>

namespace multum {

using Json = nlohmann::json;

HttpResponse json_response(const Json& json, int status) {
  return {status, "application/json", json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"};
}

HttpResponse refusal_response(const Refusal& refusal) {
  HttpResponse response =
      json_response({{"error", {{"code", refusal.code}, {"message", refusal.message}}}}, refusal.status);
  response.headers = refusal.headers;
  return response;
}

Refusal refusal_of(const Error& error) {
  switch (error.code()) {
    case ErrorCode::kUsage: return {400, "usage", error.what()};
    case ErrorCode::kInput: return {400, "input", error.what()};
    default: return {503, "environment", error.what(), {{"Retry-After", "5"}}};
  }
}

}  // namespace multum
