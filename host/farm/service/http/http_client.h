// SPDX-License-Identifier: Apache-2.0
// The client side of the web interface, for the command line: one request at a time.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace multum {

/// Times to wait for a silent service.
struct HttpPatience {
  std::chrono::milliseconds connecting = std::chrono::seconds(10);
  std::chrono::milliseconds answer = std::chrono::seconds(60);  // wait for answers; event streams pulse every 10 s
  std::chrono::milliseconds work =
      std::chrono::minutes(15);  // longer for requests that change something, because inputs are read first
};

class HttpClient {
 public:
  /// `server`: http://HOST:PORT or unix:PATH. Throws Error(kUsage) for other texts.
  HttpClient(std::string server, std::string token, HttpPatience patience = {});

  /// Returns the answer's JSON, or its text as a JSON string. Throws Error(kEnvironment) when the server cannot be
  /// reached or is silent for too long. For a refusal, throws an Error with its message: kUsage for a status below 500,
  /// otherwise kEnvironment.
  nlohmann::json ask(const std::string& method, const std::string& target, const nlohmann::json& body = nullptr);
  /// Returns the answer's body unchanged; throws like ask().
  std::string text(const std::string& target);
  /// Passes each event's kind and data to `take` until it returns false or the connection ends. Calls `opened` before
  /// the first event, so that answers to requests made in it are not older than the events. Returning false ends the
  /// call.
  void listen(const std::string& target, const std::function<bool()>& opened,
              const std::function<bool(const std::string& kind, const nlohmann::json& data)>& take);

 private:
  std::string host_name() const;
  std::string exchange_text(const std::string& method, const std::string& target, const nlohmann::json& body);

  std::string host_, port_, unix_path_, token_;
  HttpPatience patience_;
};

}  // namespace multum
