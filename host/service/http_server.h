// SPDX-License-Identifier: Apache-2.0
// HTTP/1.1 over TCP or a unix socket, for few friends or many strangers: one thread, bounded connections, headers and
// bodies, and a time limit on whoever is slow. What is answered is not its business (http_api.h).
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/service/event_hub.h"
#include "host/service/turns.h"

namespace multum {

struct HttpRequest {
  std::string method;  // "GET"; HEAD is asked for as GET
  std::string path;    // decoded, "/v1/jobs/12"
  std::map<std::string, std::string> query;
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::string file = {};    // sent instead of a body, if not empty
  bool is_stream = false;   // server-sent events until the client goes
  std::uint64_t after = 0;  // of a stream: events with higher numbers
  std::int64_t job = 0;     // of a stream: of this job alone; 0: all
};

class HttpServer {
 public:
  struct Settings {
    int connections_max = 4096;
    std::size_t body_max = 1 << 20;     // bytes
    std::size_t upload_max = 64 << 20;  // of the requests that is_upload
    std::function<bool(const std::string& method, const std::string& path)> is_upload;
    /// Before a body is read: null to go on, or what is answered at once.
    std::function<std::unique_ptr<HttpResponse>(const HttpRequest& without_body)> check;
    std::function<boost::asio::awaitable<HttpResponse>(HttpRequest request)> answer;
    /// Answered before others that wait: what monitors ask.
    std::function<bool(const std::string& path)> is_urgent;
  };
  struct Counters {
    std::uint64_t connections = 0, requests = 0, refused_connections = 0, timeouts = 0;
    std::map<int, std::uint64_t> by_status;
    int open = 0, streams = 0;
  };

  /// Requests that are not urgent are answered in `turns`.
  HttpServer(boost::asio::io_context& io, Settings settings, EventHub& events, Turns& turns);
  ~HttpServer();

  /// Throws Error(kEnvironment) when the address is taken or cannot be listened on. Returns the port.
  int listen_tcp(const std::string& host, int port);
  /// Readable and writable by its owner alone; what a dead daemon left there is removed.
  void listen_unix(const std::string& path);
  /// No new connections; streams end; others after their answer.
  void close();
  Counters counters() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace multum
