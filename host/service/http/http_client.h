// SPDX-License-Identifier: Apache-2.0
// The client's side of the web interface, for the command line: one question after the other.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace multum {

class HttpClient {
 public:
  /// `server`: http://HOST:PORT or unix:PATH. Throws Error(kUsage) for what is neither.
  HttpClient(std::string server, std::string token);

  /// The answer's JSON, or its text as a JSON string. Throws Error(kEnvironment) when the server is not there, and for
  /// what it refuses what it says: kUsage for a status below 500, kEnvironment from there on.
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
};

}  // namespace multum
