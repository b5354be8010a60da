// SPDX-License-Identifier: Apache-2.0
#include "host/service/http_server.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/version.hpp>
#include <chrono>
#include <deque>
#include <optional>

#include "host/base/error.h"

namespace multum {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::use_awaitable;
using std::chrono::seconds;

constexpr auto kHeaderTime = seconds(10);  // from the first byte that is waited for: also how long a line may idle
constexpr auto kBodyTime = seconds(60);
constexpr auto kAnswerTime = seconds(60);  // to take in an answer
constexpr auto kLingerTime = seconds(5);
constexpr std::size_t kLingerMax = 64 << 20;  // bytes
constexpr auto kStreamPulse = seconds(10);
constexpr std::uint32_t kHeaderMax = 16384;                   // bytes
constexpr auto kStreamPause = std::chrono::milliseconds(50);  // between two words to one listener
constexpr std::size_t kStreamBacklog = 8192;  // events that a slow listener may be behind, before its line is cut

std::optional<std::string> decoded(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+') {
      result += ' ';
    } else if (text[i] == '%') {
      const auto digit = [&](std::size_t at) {
        const char c = at < text.size() ? text[at] : 'x';
        return c >= '0' && c <= '9'   ? c - '0'
               : c >= 'a' && c <= 'f' ? c - 'a' + 10
               : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                      : -1;
      };
      const int high = digit(i + 1), low = digit(i + 2);
      if (high < 0 || low < 0) return std::nullopt;
      result += static_cast<char>(16 * high + low);
      i += 2;
    } else {
      result += text[i];
    }
  }
  return result;
}

// False: the target is none.
bool split_target(std::string_view target, HttpRequest& request) {
  const std::size_t question = target.find('?');
  const std::optional<std::string> path = decoded(target.substr(0, question));
  if (!path || !path->starts_with('/') || path->find('\0') != std::string::npos) return false;
  request.path = *path;
  if (question == std::string_view::npos) return true;
  std::string_view rest = target.substr(question + 1);
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    const std::size_t equals = one.find('=');
    const std::optional<std::string> name = decoded(one.substr(0, equals));
    const std::optional<std::string> value =
        equals == std::string_view::npos ? std::string() : decoded(one.substr(equals + 1));
    if (!name || !value) return false;
    request.query[*name] = *value;
  }
  return true;
}

HttpResponse plain_error(int status, const std::string& code, const std::string& message) {
  return {status, "application/json", fmt::format(R"({{"error":{{"code":"{}","message":"{}"}}}})", code, message)};
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

}  // namespace

struct HttpServer::State : std::enable_shared_from_this<State> {
  State(asio::io_context& context, Settings the_settings, EventHub& hub, Turns& the_turns)
      : io(context), settings(std::move(the_settings)), events(hub), turns(the_turns) {}

  template <typename Protocol>
  asio::awaitable<void> accept(std::shared_ptr<asio::basic_socket_acceptor<Protocol>> acceptor) {
    for (;;) {
      boost::system::error_code error;
      typename Protocol::socket socket(io);
      co_await acceptor->async_accept(socket, asio::redirect_error(use_awaitable, error));
      if (is_closed || error == asio::error::operation_aborted) co_return;
      if (error) {  // too many files, as a rule: those that are open must end first
        asio::steady_timer pause(io, std::chrono::milliseconds(100));
        co_await pause.async_wait(asio::redirect_error(use_awaitable, error));
        continue;
      }
      ++counters.connections;
      if (counters.open + streams >= settings.connections_max) {
        ++counters.refused_connections;
        continue;  // closes it
      }
      asio::co_spawn(io, serve(beast::basic_stream<Protocol>(std::move(socket)), this->shared_from_this()),
                     asio::detached);
    }
  }

  template <typename Protocol>
  static asio::awaitable<void> serve(beast::basic_stream<Protocol> stream, std::shared_ptr<State> self) {
    ++self->counters.open;
    beast::flat_buffer buffer;
    buffer.reserve(4096);
    try {
      while (!self->is_closed && co_await self->serve_one(stream, buffer)) {
      }
    } catch (const boost::system::system_error& error) {
      if (error.code() == beast::error::timeout) ++self->counters.timeouts;
    } catch (const std::exception&) {  // no memory for a request: the next may have more luck
    }
    --self->counters.open;
  }

  // False: the line is to be closed.
  template <typename Stream>
  asio::awaitable<bool> serve_one(Stream& stream, beast::flat_buffer& buffer) {
    http::request_parser<http::string_body> parser;
    parser.header_limit(kHeaderMax);
    parser.body_limit(settings.upload_max);
    stream.expires_after(kHeaderTime);
    boost::system::error_code error;
    co_await http::async_read_header(stream, buffer, parser, asio::redirect_error(use_awaitable, error));
    if (error == http::error::end_of_stream || error == asio::error::eof || error == asio::error::connection_reset)
      co_return false;
    if (error == beast::error::timeout && buffer.size() == 0) co_return false;  // nobody asked anything
    if (error) co_return co_await refuse(stream, error);

    HttpRequest request;
    const auto& head = parser.get();
    const unsigned version = head.version();
    bool is_head = head.method() == http::verb::head;
    request.method = is_head ? "GET" : std::string(head.method_string());
    for (const auto& field : head) request.headers[lower(field.name_string())] = std::string(field.value());
    const bool is_target = split_target(std::string_view(head.target().data(), head.target().size()), request);
    std::unique_ptr<HttpResponse> early;
    if (!is_target) early = std::make_unique<HttpResponse>(plain_error(400, "usage", "the target is no path"));
    else early = settings.check(request);
    if (!early) {
      const std::size_t limit =
          settings.is_upload(request.method, request.path) ? settings.upload_max : settings.body_max;
      if (parser.content_length() && *parser.content_length() > limit)
        early = std::make_unique<HttpResponse>(
            plain_error(413, "too_large", fmt::format("a body of up to {} bytes is taken", limit)));
      parser.body_limit(limit);
    }
    if (early) {
      co_await send(stream, version, false, is_head, *early);
      co_return co_await linger(stream);
    }
    if (lower(request.headers["expect"]) == "100-continue") {
      http::response<http::empty_body> go_on(http::status::continue_, version);
      co_await http::async_write(stream, go_on, use_awaitable);
    }
    stream.expires_after(kBodyTime);
    co_await http::async_read(stream, buffer, parser, asio::redirect_error(use_awaitable, error));
    if (error) co_return co_await refuse(stream, error);
    const bool keep = parser.keep_alive();
    request.body = std::move(parser.get().body());
    stream.expires_never();
    ++counters.requests;
    if (!settings.is_urgent(request.path)) co_await turn();
    const HttpResponse response = co_await settings.answer(std::move(request));
    if (response.is_stream && !is_head) {
      co_await hand_to_hub(stream, version, response);
      co_return false;
    }
    co_return co_await send(stream, version, keep && !is_closed, is_head, response);
  }

  // What could not be read is answered if there is somebody to answer.
  template <typename Stream>
  asio::awaitable<bool> refuse(Stream& stream, boost::system::error_code error) {
    HttpResponse response = plain_error(400, "usage", "the request is no HTTP: " + error.message());
    if (error == http::error::header_limit) response = plain_error(431, "too_large", "the header is too large");
    else if (error == http::error::body_limit) response = plain_error(413, "too_large", "the body is too large");
    else if (error == beast::error::timeout) {
      ++counters.timeouts;  // and the stream has closed itself
      co_return false;
    } else if (error == http::error::partial_message ||
               error.category() != http::make_error_code(http::error::bad_method).category()) {
      co_return false;
    }
    co_await send(stream, 11, false, false, response);
    co_return co_await linger(stream);
  }

  // Somebody who is still talking when the line is closed may never see the answer: the system throws it away. So he is
  // heard for a while, not listened to.
  template <typename Stream>
  asio::awaitable<bool> linger(Stream& stream) {
    boost::system::error_code error;
    stream.socket().shutdown(asio::socket_base::shutdown_send, error);
    stream.expires_after(kLingerTime);
    std::array<char, 16384> waste;
    for (std::size_t heard = 0; heard < kLingerMax && !error;)
      heard += co_await stream.async_read_some(asio::buffer(waste), asio::redirect_error(use_awaitable, error));
    co_return false;
  }

  template <typename Message>
  void fill_header(Message& message, bool keep, const HttpResponse& response) {
    message.set(http::field::server, "multum/" MULTUM_VERSION);
    message.set(http::field::content_type, response.content_type);
    message.set("X-Content-Type-Options", "nosniff");
    for (const auto& [name, value] : response.headers) message.set(name, value);
    message.keep_alive(keep);
    ++counters.by_status[static_cast<int>(message.result_int())];
  }

  template <typename Stream>
  asio::awaitable<bool> send(Stream& stream, unsigned version, bool keep, bool is_head, const HttpResponse& response) {
    const auto status = static_cast<unsigned>(response.status);
    if (!response.file.empty()) {
      http::response<http::file_body> message;
      boost::system::error_code error;
      message.body().open(response.file.c_str(), beast::file_mode::scan, error);
      if (error) {
        const HttpResponse gone = plain_error(404, "not_found", "the file is not there any more");
        co_return co_await send(stream, version, keep, is_head, gone);
      }
      message.result(status);
      message.version(version);
      fill_header(message, keep, response);
      message.prepare_payload();
      co_return co_await finish(stream, message, keep, is_head);
    }
    http::response<http::string_body> message(static_cast<http::status>(status), version);
    message.body() = response.body;
    fill_header(message, keep, response);
    message.prepare_payload();
    co_return co_await finish(stream, message, keep, is_head);
  }

  // However much it is, as long as it moves.
  template <typename Stream, typename Message>
  asio::awaitable<bool> finish(Stream& stream, Message& message, bool keep, bool is_head) {
    http::response_serializer<typename Message::body_type> serializer(message);
    serializer.split(is_head);
    while (is_head ? !serializer.is_header_done() : !serializer.is_done()) {
      stream.expires_after(kAnswerTime);
      co_await http::async_write_some(stream, serializer, use_awaitable);
    }
    co_return keep;
  }

  asio::awaitable<void> turn() {
    const auto initiate = [this](auto handler) {
      const auto shared = std::make_shared<decltype(handler)>(std::move(handler));
      turns.add([shared] { (*shared)(); });
    };
    co_await asio::async_initiate<const asio::use_awaitable_t<>, void()>(initiate, use_awaitable);
  }

  // The line changes hands: from here on it is the hub's thread's.
  template <typename Protocol>
  asio::awaitable<void> hand_to_hub(beast::basic_stream<Protocol>& stream, unsigned version, HttpResponse response) {
    http::response<http::empty_body> message(http::status::ok, version);
    response.content_type = "text/event-stream";
    response.headers.emplace_back("Cache-Control", "no-store");
    fill_header(message, false, response);
    message.chunked(true);
    http::response_serializer<http::empty_body> serializer(message);
    stream.expires_after(kAnswerTime);
    co_await http::async_write_header(stream, serializer, use_awaitable);
    typename Protocol::socket socket = stream.release_socket();
    const Protocol protocol = socket.local_endpoint().protocol();
    typename Protocol::socket moved(events.io(), protocol, socket.release());
    ++streams;
    asio::co_spawn(events.io(),
                   send_events(beast::basic_stream<Protocol>(std::move(moved)), response.after, response.job,
                               this->shared_from_this()),
                   asio::detached);
  }

  // On the hub's thread.
  template <typename Protocol>
  static asio::awaitable<void> send_events(beast::basic_stream<Protocol> stream, std::uint64_t after, std::int64_t job,
                                           std::shared_ptr<State> self) {
    struct Line {
      std::deque<std::shared_ptr<const std::string>> waiting;
      bool is_behind = false, is_asleep = false, is_gone = false;
      asio::steady_timer wake;
    };
    const auto line = std::make_shared<Line>(Line{{}, false, false, false, asio::steady_timer(self->events.io())});
    // A listener has nothing more to say: what comes from there is its leave.
    stream.socket().async_wait(asio::socket_base::wait_read, [line](const boost::system::error_code& error) {
      if (error) return;
      line->is_gone = true;
      line->wake.cancel();
    });
    const std::uint64_t key = self->events.add(after, [line, job](const ServiceEvent& event) {
      if (job != 0 && event.job != job) return;
      if (line->waiting.size() >= kStreamBacklog) line->is_behind = true;
      else line->waiting.push_back(event.text);
      if (std::exchange(line->is_asleep, false)) line->wake.cancel();
    });
    std::string text = ": multum\nretry: 2000\n\n";
    try {
      while (!self->is_closed && !line->is_behind && !line->is_gone) {
        while (!line->waiting.empty()) {
          text += *line->waiting.front();
          line->waiting.pop_front();
        }
        boost::system::error_code error;
        if (!text.empty()) {
          stream.expires_after(kAnswerTime);
          co_await asio::async_write(stream, http::make_chunk(asio::buffer(text)), use_awaitable);
          text.clear();
          // What comes soon after goes together: many listeners to many events cost little more than few.
          line->wake.expires_after(kStreamPause);
          co_await line->wake.async_wait(asio::redirect_error(use_awaitable, error));
        }
        if (!line->waiting.empty() || line->is_gone) continue;
        line->is_asleep = true;
        line->wake.expires_after(kStreamPulse);
        co_await line->wake.async_wait(asio::redirect_error(use_awaitable, error));
        line->is_asleep = false;
        if (!error) text = ": pulse\n\n";  // tells both sides that the line is up
      }
    } catch (const boost::system::system_error&) {
    }
    self->events.remove(key);
    --self->streams;
  }

  asio::io_context& io;
  Settings settings;
  EventHub& events;
  Counters counters;
  Turns& turns;
  std::atomic<bool> is_closed = false;
  std::atomic<int> streams = 0;
  std::vector<std::function<void()>> closers;
  std::string unix_path;
};

HttpServer::HttpServer(asio::io_context& io, Settings settings, EventHub& events, Turns& turns)
    : state_(std::make_shared<State>(io, std::move(settings), events, turns)) {}

HttpServer::~HttpServer() { close(); }

int HttpServer::listen_tcp(const std::string& host, int port) {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(host, error);
  if (error) throw Error(ErrorCode::kUsage, fmt::format("'{}' is no numeric address to listen on", host));
  const asio::ip::tcp::endpoint endpoint(address, static_cast<std::uint16_t>(port));
  const auto acceptor = std::make_shared<asio::basic_socket_acceptor<asio::ip::tcp>>(state_->io);
  try {
    acceptor->open(endpoint.protocol());
    acceptor->set_option(asio::socket_base::reuse_address(true));
    acceptor->bind(endpoint);
    acceptor->listen(4096);
  } catch (const boost::system::system_error& failed) {
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}:{} cannot be listened on: {}", host, port, failed.code().message()));
  }
  state_->closers.push_back([acceptor] {
    boost::system::error_code ignored;
    acceptor->close(ignored);
  });
  asio::co_spawn(state_->io, state_->accept<asio::ip::tcp>(acceptor), asio::detached);
  return acceptor->local_endpoint().port();
}

void HttpServer::listen_unix(const std::string& path) {
  struct stat found {};
  if (::stat(path.c_str(), &found) == 0 && !S_ISSOCK(found.st_mode))
    throw Error(ErrorCode::kEnvironment, path + ": is there already, and is no socket");
  asio::local::stream_protocol::socket probe(state_->io);
  boost::system::error_code error;
  probe.connect(path, error);
  if (!error) throw Error(ErrorCode::kEnvironment, path + ": another program listens there");
  ::unlink(path.c_str());
  const auto acceptor = std::make_shared<asio::basic_socket_acceptor<asio::local::stream_protocol>>(state_->io);
  const mode_t mask = ::umask(0177);
  try {
    acceptor->open();
    acceptor->bind(path);
    acceptor->listen(4096);
  } catch (const boost::system::system_error& failed) {
    ::umask(mask);
    throw Error(ErrorCode::kEnvironment, fmt::format("{}: cannot be listened on: {}", path, failed.code().message()));
  }
  ::umask(mask);
  state_->unix_path = path;
  state_->closers.push_back([acceptor] {
    boost::system::error_code ignored;
    acceptor->close(ignored);
  });
  asio::co_spawn(state_->io, state_->accept<asio::local::stream_protocol>(acceptor), asio::detached);
}

void HttpServer::close() {
  if (state_->is_closed) return;
  state_->is_closed = true;
  for (const auto& closer : state_->closers) closer();
  if (!state_->unix_path.empty()) ::unlink(state_->unix_path.c_str());
}

HttpServer::Counters HttpServer::counters() const {
  Counters counters = state_->counters;
  counters.streams = state_->streams;
  counters.open += counters.streams;
  return counters;
}

}  // namespace multum
