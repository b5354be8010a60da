// SPDX-License-Identifier: Apache-2.0
// HTTP/1.1 over TCP or a unix socket, for few friends or many strangers: one thread, bounded connections, one budget
// for all that is kept of requests and answers, and a time limit on whoever is slow. What is answered is not its
// business (http_api.h).
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
  std::string method;  // "GET"; HEAD is asked for as GET
  std::string path;    // decoded, "/v1/jobs/12"
  std::map<std::string, std::string> query;
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
  std::shared_ptr<UploadFile> upload = nullptr;  // where the body is, if not there
  MemoryShare* memory = nullptr;  // what it has of the budget; its answer may need more, while it is made
};

/// Body that is made while it is sent; its length is known before.
class HttpBody {
 public:
  virtual ~HttpBody() = default;
  virtual std::uint64_t bytes() const = 0;
  /// Bytes that it holds meanwhile.
  virtual std::size_t memory() const = 0;
  /// Blocks: its next bytes, as many as were asked for unless it ends. Throws what it likes: the line is cut.
  virtual std::size_t read(char* to, std::size_t bytes_max) = 0;
  /// A strong validator, in quotes, of one whose bytes are the same each time; "": parts of it cannot be had.
  virtual std::string etag() const { return ""; }
  /// Blocks: passes over its next bytes. Of one with an etag().
  virtual void skip(std::uint64_t) {}
};

/// Part of a body.
struct HttpBodyPart {
  std::uint64_t first = 0, count = 0;
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::shared_ptr<OpenFile> file = nullptr;  // sent instead of a body
  std::shared_ptr<HttpBody> made = nullptr;  // likewise
  std::optional<HttpBodyPart> part = {};     // of `made`: what of it is sent; nullopt: all
  bool is_stream = false;                    // server-sent events until the client goes
  std::uint64_t after = 0;                   // of a stream: events with higher numbers
  std::int64_t job = 0;                      // of a stream: of this job alone; 0: all
};

class HttpServer {
 public:
  struct Settings {
    int connections_max = 4096;          // three quarters of them may be listeners to events
    std::size_t memory_max = 256 << 20;  // bytes of lines, bodies and answers, all together
    std::size_t body_max = 1 << 20;      // bytes, of POST; others but uploads have none
    std::size_t upload_max = 64 << 20;   // of the requests that is_upload
    std::function<bool(const std::string& method, const std::string& path)> is_upload;
    /// Opens the file that keeps an upload of at most `bytes_max` bytes as it comes. May block, and throw Refusal.
    std::function<std::shared_ptr<UploadFile>(std::size_t bytes_max)> open_upload;
    /// Runs a function on a thread that may wait for disks.
    std::function<boost::asio::awaitable<void>(std::function<void()>)> beside;
    /// Checks a request before its body is read: null to go on, or the answer.
    std::function<std::unique_ptr<HttpResponse>(const HttpRequest& without_body)> check;
    std::function<boost::asio::awaitable<HttpResponse>(HttpRequest request)> answer;
    /// Is this a path that monitors ask for? Those are answered before others that wait, and when all connections are
    /// taken.
    std::function<bool(const std::string& path)> is_urgent;
  };
  struct Counters {
    std::uint64_t connections = 0, requests = 0, refused_connections = 0, timeouts = 0, failures = 0;
    std::map<int, std::uint64_t> by_status;
    int open = 0, streams = 0;
    std::size_t memory = 0;  // bytes of the budget in use
  };

  /// Requests that are not urgent are answered in `turns`.
  HttpServer(boost::asio::io_context& io, Settings settings, EventHub& events, TaskQueue& turns);
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
