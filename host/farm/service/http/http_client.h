// SPDX-License-Identifier: Apache-2.0
// The client's side of the web interface, for the command line: one question after the other.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace multum {

/// How long a silent service is waited for.
struct HttpPatience {
  std::chrono::milliseconds connecting = std::chrono::seconds(10);
  std::chrono::milliseconds answer = std::chrono::seconds(60);  // to a question; streams of events pulse every 10 s
  std::chrono::milliseconds work = std::chrono::minutes(15);    // to what changes something: inputs are read first
};

class HttpClient {
 public:
  /// `server`: http://HOST:PORT or unix:PATH. Throws Error(kUsage) for what is neither.
  HttpClient(std::string server, std::string token, HttpPatience patience = {});

  /// The answer's JSON, or its text as a JSON string. Throws Error(kEnvironment) when the server is not there or silent
  /// for too long, and for what it refuses what it says: kUsage for a status below 500, kEnvironment from there on.
  nlohmann::json ask(const std::string& method, const std::string& target, const nlohmann::json& body = nullptr);
  /// The answer's body as it is; throws as ask() does.
  std::string text(const std::string& target);
  /// Each event's kind and data until `take` returns false or the line ends. `opened` is called before the first: what
  /// is asked of then is of no earlier moment than the events tell of. False: it was enough.
  void listen(const std::string& target, const std::function<bool()>& opened,
              const std::function<bool(const std::string& kind, const nlohmann::json& data)>& take);

 private:
  std::string host_name() const;
  std::string exchange_text(const std::string& method, const std::string& target, const nlohmann::json& body);

  std::string host_, port_, unix_path_, token_;
  HttpPatience patience_;
};

}  // namespace multum
