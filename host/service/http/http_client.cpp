// SPDX-License-Identifier: Apache-2.0
#include "host/service/http/http_client.h"

#include <fmt/format.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <optional>

#include "host/base/error.h"

namespace multum {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Json = nlohmann::json;

template <typename Socket>
http::response<http::string_body> exchange(Socket& socket, const http::request<http::string_body>& request) {
  http::write(socket, request);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(std::uint64_t{1} << 32);
  http::read(socket, buffer, parser);
  return parser.release();
}

template <typename Socket>
void read_events(Socket& socket, const http::request<http::string_body>& request, const std::function<bool()>& opened,
                 const std::function<bool(const std::string&, const Json&)>& take) {
  http::write(socket, request);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(boost::none);
  http::read_header(socket, buffer, parser);
  if (parser.get().result() != http::status::ok)
    throw Error(ErrorCode::kUsage, fmt::format("the service answered {}", parser.get().result_int()));
  if (!opened()) return;
  std::string text;
  boost::system::error_code error;
  while (!parser.is_done() && !error) {
    http::read_some(socket, buffer, parser, error);
    text += std::exchange(parser.get().body(), {});
    for (std::size_t end = text.find("\n\n"); end != std::string::npos; end = text.find("\n\n")) {
      std::string kind, data;
      std::size_t begin = 0;
      while (begin < end) {
        const std::size_t line_end = std::min(text.find('\n', begin), end);
        const std::string line = text.substr(begin, line_end - begin);
        if (line.starts_with("event: ")) kind = line.substr(7);
        if (line.starts_with("data: ")) data = line.substr(6);
        begin = line_end + 1;
      }
      text.erase(0, end + 2);
      if (!kind.empty() && !take(kind, Json::parse(data, nullptr, false))) return;
    }
  }
}

}  // namespace

HttpClient::HttpClient(std::string server, std::string token) : token_(std::move(token)) {
  if (server.starts_with("unix:")) {
    unix_path_ = server.substr(5);
    return;
  }
  while (server.ends_with('/')) server.pop_back();
  const bool is_http = server.starts_with("http://");
  const std::string rest = is_http ? server.substr(7) : server;
  const std::size_t colon = rest.rfind(':');
  if ((server.find("://") != std::string::npos && !is_http) || colon == std::string::npos ||
      rest.find('/') != std::string::npos)
    throw Error(ErrorCode::kUsage, fmt::format("server '{}': expected http://HOST:PORT or unix:PATH", server));
  host_ = rest.substr(0, colon);
  port_ = rest.substr(colon + 1);
  if (host_.starts_with('[') && host_.ends_with(']')) host_ = host_.substr(1, host_.size() - 2);
}

namespace {

template <typename Use>
void with_socket(const std::string& host, const std::string& port, const std::string& unix_path, const Use& use) {
  asio::io_context io;
  const std::string where = unix_path.empty() ? host + ":" + port : unix_path;
  try {
    if (unix_path.empty()) {
      asio::ip::tcp::resolver resolver(io);
      asio::ip::tcp::socket socket(io);
      asio::connect(socket, resolver.resolve(host, port));
      use(socket);
    } else {
      asio::local::stream_protocol::socket socket(io);
      socket.connect(unix_path);
      use(socket);
    }
  } catch (const boost::system::system_error& error) {
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: no answer from the service: {}. Is `multum serve` running there?", where,
                            error.code().message()));
  }
}

http::request<http::string_body> request_of(const std::string& method, const std::string& target,
                                            const std::string& host, const std::string& token, const Json& body) {
  http::request<http::string_body> request;
  request.method_string(method);
  request.target(target);
  request.version(11);
  request.set(http::field::host, host);
  request.set(http::field::user_agent, "multum/" MULTUM_VERSION);
  request.keep_alive(false);
  if (!token.empty()) request.set(http::field::authorization, "Bearer " + token);
  if (!body.is_null()) {
    request.set(http::field::content_type, "application/json");
    request.body() = body.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  request.prepare_payload();
  return request;
}

}  // namespace

// As requests name it.
std::string HttpClient::host_name() const {
  if (!unix_path_.empty()) return "localhost";
  return host_.find(':') != std::string::npos ? "[" + host_ + "]" : host_;
}

Json HttpClient::ask(const std::string& method, const std::string& target, const Json& body) {
  const std::string answer = exchange_text(method, target, body);
  Json json = Json::parse(answer, nullptr, false);
  return json.is_discarded() ? Json(answer) : json;
}

std::string HttpClient::text(const std::string& target) { return exchange_text("GET", target, nullptr); }

std::string HttpClient::exchange_text(const std::string& method, const std::string& target, const Json& body) {
  http::response<http::string_body> response;
  const auto request = request_of(method, target, host_name(), token_, body);
  with_socket(host_, port_, unix_path_, [&](auto& socket) { response = exchange(socket, request); });
  const unsigned status = response.result_int();
  if (status >= 400) {
    const Json json = Json::parse(response.body(), nullptr, false);
    const bool has_message = json.is_object() && json.contains("error");
    throw Error(status >= 500 ? ErrorCode::kEnvironment : ErrorCode::kUsage,
                has_message ? json["error"].value("message", "") : fmt::format("the service answered {}", status));
  }
  return response.body();
}

void HttpClient::listen(const std::string& target, const std::function<bool()>& opened,
                        const std::function<bool(const std::string& kind, const Json& data)>& take) {
  const auto request = request_of("GET", target, host_name(), token_, nullptr);
  with_socket(host_, port_, unix_path_, [&](auto& socket) { read_events(socket, request, opened, take); });
}

}  // namespace multum
