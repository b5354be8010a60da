// SPDX-License-Identifier: Apache-2.0
// Answers the requests of the web interface. docs/reference/openapi.json describes every request and answer. Tests
// check that this description matches the code.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/farm/service/dispatch/data_folder.h"
#include "host/farm/service/dispatch/dispatcher.h"
#include "host/farm/service/files/file_hashes.h"
#include "host/farm/service/files/job_roots.h"
#include "host/farm/service/http/http_server.h"
#include "host/farm/service/http/job_pictures.h"

namespace multum {

class HttpApi {
 public:
  /// `driver_command` is explained in DriverProbe.
  HttpApi(boost::asio::io_context& io, QueueThread& ledger, Dispatcher& dispatcher, EventHub& events, DataFolder& data,
          const JobRoots& roots, std::string token, std::vector<std::string> driver_command);
  ~HttpApi();
  HttpApi(const HttpApi&) = delete;
  HttpApi& operator=(const HttpApi&) = delete;

  /// Checks a request before its body is read. Returns a refusal for clients without permission and for unknown paths.
  std::unique_ptr<HttpResponse> check(const HttpRequest& request) const;
  static bool is_upload(const std::string& method, const std::string& path);
  /// Returns the routes for programs, such as "GET /v1/jobs/{}". The web page is not included.
  static std::vector<std::string> routes();
  boost::asio::awaitable<HttpResponse> answer(HttpRequest request);
  /// Runs `work` on a thread that is allowed to wait for disks. Rethrows its exception.
  boost::asio::awaitable<void> beside(std::function<void()> work);
  /// Sets the server whose counters /metrics shows.
  void set_server(const HttpServer* server);
  bool has_token() const;
  void set_token(std::string token);
  JobPictures& pictures();

  struct State;  // data of the request handlers

 private:
  std::unique_ptr<State> state_;
};

}  // namespace multum
