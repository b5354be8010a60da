// SPDX-License-Identifier: Apache-2.0
// Serves HTTP/1.1 over TCP or a unix socket, to few trusted or many unknown clients. Uses one thread, a limited number
// of connections, one memory budget for all requests and answers, and time limits for slow clients. The content of
// answers is made elsewhere (http_api.h).
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/dispatch/event_hub.h"
#include "host/farm/service/files/upload_file.h"
#include "host/farm/service/http/memory_budget.h"
#include "host/farm/service/http/task_queue.h"
#include "host/foundation/base/files/open_file.h"

namespace multum {

struct HttpRequest {
  std::string method;  // "GET", also for HEAD
  std::string path;    // decoded path, such as "/v1/jobs/12"
  std::map<std::string, std::string> query;
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
  std::shared_ptr<UploadFile> upload = nullptr;  // holds the body of an upload
  MemoryShare* memory = nullptr;                 // the request's part of the budget; making the answer may need more
};

/// A body that is made while it is sent. Its length is known in advance.
class HttpBody {
 public:
  virtual ~HttpBody() = default;
  virtual std::uint64_t bytes() const = 0;
  /// The bytes of memory that the body uses while it is sent.
  virtual std::size_t memory() const = 0;
  /// Blocks. Returns the next bytes. Their number is the requested number, unless the body ends. Any exception ends the
  /// connection.
  virtual std::size_t read(char* to, std::size_t bytes_max) = 0;
  /// Returns a strong validator, in quotes, if the bytes are the same each time. Otherwise returns "", and ranges are
  /// not available.
  virtual std::string etag() const { return ""; }
  /// Blocks. Skips the next bytes. Call it only for a body with an etag().
  virtual void skip(std::uint64_t) {}
};

/// A range of a body's bytes.
struct HttpBodyPart {
  std::uint64_t first = 0, count = 0;
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::shared_ptr<OpenFile> file = nullptr;  // sent instead of `body`
  std::shared_ptr<HttpBody> made = nullptr;  // also sent instead of `body`
  std::optional<HttpBodyPart> part = {};     // part of `made` to send; nullopt sends all
  bool is_stream = false;                    // server-sent events until the client disconnects
  std::uint64_t after = 0;                   // streams send only events with higher numbers
  std::int64_t job = 0;                      // streams send only events of this job; 0 means all jobs
};

class HttpServer {
 public:
  struct Settings {
    int connections_max = 4096;          // up to three quarters of them may listen to events
    std::size_t memory_max = 256 << 20;  // bytes of all connections, bodies and answers
    std::size_t body_max = 1 << 20;      // bytes per POST body; uploads are the only other requests with a body
    std::size_t upload_max = 64 << 20;   // bytes per request with is_upload
    std::function<bool(const std::string& method, const std::string& path)> is_upload;
    /// Opens the file for an upload of at most `bytes_max` bytes. May block, and may throw Refusal.
    std::function<std::shared_ptr<UploadFile>(std::size_t bytes_max)> open_upload;
    /// Runs a function on a thread that is allowed to wait for disks.
    std::function<boost::asio::awaitable<void>(std::function<void()>)> beside;
    /// Checks a request before its body is read. Returns null to continue, or else the answer to send.
    std::function<std::unique_ptr<HttpResponse>(const HttpRequest& without_body)> check;
    std::function<boost::asio::awaitable<HttpResponse>(HttpRequest request)> answer;
    /// Returns true for the paths that monitoring programs request. Requests for these paths are answered before other
    /// waiting requests, even when all connections are in use.
    std::function<bool(const std::string& path)> is_urgent;
  };
  struct Counters {
    std::uint64_t connections = 0, requests = 0, refused_connections = 0, timeouts = 0, failures = 0;
    std::map<int, std::uint64_t> by_status;
    int open = 0, streams = 0;
    std::size_t memory = 0;  // bytes of the budget in use
  };

  /// Requests that are not urgent wait in `turns`.
  HttpServer(boost::asio::io_context& io, Settings settings, EventHub& events, TaskQueue& turns);
  ~HttpServer();

  /// Throws Error(kEnvironment) when the address is in use or cannot be listened on. Returns the port.
  int listen_tcp(const std::string& host, int port);
  /// Makes a socket that only its owner can read and write. Removes the socket of a dead daemon.
  void listen_unix(const std::string& path);
  /// Accepts no new connections. Ends streams at once, and ends other connections after their answers.
  void close();
  Counters counters() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace multum
