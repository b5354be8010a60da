// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/http_client.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <cerrno>
#include <climits>
#include <optional>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Json = nlohmann::json;

using std::chrono::milliseconds;

// A socket with timeouts, because asio's own blocking calls have no time limit. Beast reads from it and writes to it as
// with any stream.
template <typename Protocol>
class PatientSocket {
 public:
  PatientSocket(asio::io_context& io, milliseconds patience) : socket_(io), patience_(patience) {}

  using executor_type = typename Protocol::socket::executor_type;
  executor_type get_executor() { return socket_.get_executor(); }

  void connect(const typename Protocol::endpoint& endpoint, milliseconds patience, boost::system::error_code& error) {
    boost::system::error_code ignored;
    socket_.close(ignored);  // for the previous address
    socket_.open(endpoint.protocol(), error);
    if (!error) socket_.non_blocking(true, error);
    if (error) return;
    socket_.connect(endpoint, error);
    if (error != asio::error::in_progress && error != asio::error::would_block) return;
    if (!wait(POLLOUT, patience, error)) return;
    int failed = 0;
    socklen_t size = sizeof(failed);
    ::getsockopt(socket_.native_handle(), SOL_SOCKET, SO_ERROR, &failed, &size);
    error = boost::system::error_code(failed, boost::system::system_category());
  }

  template <typename Buffers>
  std::size_t read_some(const Buffers& buffers, boost::system::error_code& error) {
    return patiently(POLLIN, error, [&] { return socket_.read_some(buffers, error); });
  }
  template <typename Buffers>
  std::size_t write_some(const Buffers& buffers, boost::system::error_code& error) {
    return patiently(POLLOUT, error, [&] { return socket_.write_some(buffers, error); });
  }
  template <typename Buffers>
  std::size_t read_some(const Buffers& buffers) {
    boost::system::error_code error;
    const std::size_t count = read_some(buffers, error);
    if (error) throw boost::system::system_error(error);
    return count;
  }
  template <typename Buffers>
  std::size_t write_some(const Buffers& buffers) {
    boost::system::error_code error;
    const std::size_t count = write_some(buffers, error);
    if (error) throw boost::system::system_error(error);
    return count;
  }

 private:
  bool wait(short event, milliseconds patience, boost::system::error_code& error) {
    using PatientClock = std::chrono::steady_clock;
    const auto until = PatientClock::now() + patience;
    error = asio::error::timed_out;
    for (auto left = patience; left.count() > 0; left = std::chrono::ceil<milliseconds>(until - PatientClock::now())) {
      pollfd waited = {socket_.native_handle(), event, 0};
      const int ready = ::poll(&waited, 1, static_cast<int>(std::min<std::int64_t>(left.count(), INT_MAX)));
      if (ready > 0) error = {};
      if (ready < 0 && errno != EINTR) error = boost::system::error_code(errno, boost::system::system_category());
      if (ready > 0 || (ready < 0 && errno != EINTR)) break;
    }
    return !error;
  }

  template <typename Move>
  std::size_t patiently(short event, boost::system::error_code& error, const Move& move) {
    for (;;) {
      const std::size_t count = move();
      if (error != asio::error::would_block && error != asio::error::try_again) return count;
      if (!wait(event, patience_, error)) return 0;
    }
  }

  typename Protocol::socket socket_;
  milliseconds patience_;
};

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
    if (error == asio::error::timed_out) throw boost::system::system_error(error);
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

HttpClient::HttpClient(std::string server, std::string token, HttpPatience patience)
    : token_(std::move(token)), patience_(patience) {
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
void with_socket(const std::string& host, const std::string& port, const std::string& unix_path,
                 const HttpPatience& patience, milliseconds silence, const Use& use) {
  asio::io_context io;
  const std::string where = unix_path.empty() ? host + ":" + port : unix_path;
  boost::system::error_code failed = asio::error::host_not_found;
  try {
    if (unix_path.empty()) {
      asio::ip::tcp::resolver resolver(io);
      PatientSocket<asio::ip::tcp> socket(io, silence);
      for (const auto& address : resolver.resolve(host, port)) {
        socket.connect(address.endpoint(), patience.connecting, failed);
        if (!failed) break;
      }
      if (failed) throw boost::system::system_error(failed);
      use(socket);
    } else {
      PatientSocket<asio::local::stream_protocol> socket(io, silence);
      socket.connect(asio::local::stream_protocol::endpoint(unix_path), patience.connecting, failed);
      if (failed) throw boost::system::system_error(failed);
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

// The name of the host in requests.
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
  // The service answers a submission only after reading the files.
  const milliseconds silence = method == "GET" ? patience_.answer : patience_.work;
  with_socket(host_, port_, unix_path_, patience_, silence,
              [&](auto& socket) { response = exchange(socket, request); });
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
  with_socket(host_, port_, unix_path_, patience_, patience_.answer,
              [&](auto& socket) { read_events(socket, request, opened, take); });
}

}  // namespace multum
