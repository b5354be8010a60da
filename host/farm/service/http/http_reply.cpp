// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/http_reply.h"

#include <fmt/format.h>

#include <cctype>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/farm/service/files/no_space.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

using Json = nlohmann::json;

}  // namespace

HttpResponse json_response(const Json& json, int status) {
  return {status, "application/json", json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"};
}

HttpResponse refusal_response(const Refusal& refusal) {
  HttpResponse response = json_response(
      {{"error", {{"code", refusal.code}, {"message", text_of_message(refusal.message)}}}}, refusal.status);
  response.headers = refusal.headers;
  return response;
}

std::string attachment(const std::string& name) {
  std::string plain, encoded;
  for (const char c : name) {
    const bool is_safe = std::isalnum(static_cast<unsigned char>(c)) != 0 || (c != '\0' && std::strchr("-._", c));
    const bool is_quotable = c >= ' ' && c <= '~' && c != '"' && c != '\\' && c != '%';  // no %, because browsers
                                                                                         // decode %41
    plain += is_quotable ? c : '_';
    encoded += is_safe ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  const std::string header = fmt::format("attachment; filename=\"{}\"", plain);
  return plain == name ? header : fmt::format("{}; filename*=UTF-8''{}", header, encoded);
}

Refusal refusal_of(const Error& error) {
  if (dynamic_cast<const NoSpaceError*>(&error) != nullptr)
    return {507, "no_space", error.what(), {{"Retry-After", "60"}}};
  switch (error.code()) {
    case ErrorCode::kUsage: return {400, "usage", error.what()};
    case ErrorCode::kInput: return {400, "input", error.what()};
    default: return {503, "environment", error.what(), {{"Retry-After", "5"}}};
  }
}

}  // namespace multum
