// SPDX-License-Identifier: Apache-2.0
// The client side of the web interface, for the command line. It sends one request at a time.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace multum {

/// The longest times to wait for a service that sends nothing.
struct HttpPatience {
  std::chrono::milliseconds connecting = std::chrono::seconds(10);
  std::chrono::milliseconds answer = std::chrono::seconds(60);  // longest wait for an answer; event streams send a
                                                                // pulse every 10 s
  std::chrono::milliseconds work =
      std::chrono::minutes(15);  // longer if a request changes something, because inputs are read first
};

class HttpClient {
 public:
  /// `server` is http://HOST:PORT or unix:PATH. Throws Error(kUsage) for other texts.
  HttpClient(std::string server, std::string token, HttpPatience patience = {});

  /// Returns the answer's JSON, or its text as a JSON string. Throws Error(kEnvironment) when the server cannot be
  /// reached or is silent for too long. For a refusal, throws an Error with the message of the refusal. The error is
  /// kUsage for a status below 500, and otherwise kEnvironment.
  nlohmann::json ask(const std::string& method, const std::string& target, const nlohmann::json& body = nullptr);
  /// Returns the answer's body unchanged. Throws like ask().
  std::string text(const std::string& target);
  /// Passes each event's kind and data to `take` until `take` returns false or the connection ends. Calls `opened`
  /// before the first event, so that answers to requests made in `opened` are not older than the events. If `opened`
  /// returns false, the call ends.
  void listen(const std::string& target, const std::function<bool()>& opened,
              const std::function<bool(const std::string& kind, const nlohmann::json& data)>& take);

 private:
  std::string host_name() const;
  std::string exchange_text(const std::string& method, const std::string& target, const nlohmann::json& body);

  std::string host_, port_, unix_path_, token_;
  HttpPatience patience_;
};

}  // namespace multum
