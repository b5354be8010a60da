// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/http_line.h"

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/string.hpp>
#include <boost/beast/http/error.hpp>
#include <initializer_list>
#include <iterator>

namespace multum {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::use_awaitable;

constexpr long kFieldsMax = 100;
constexpr std::size_t kOverheadBytes = 65536;  // allowance for chunk headers, in addition to the size of the content

UnreadableRequest no_http(const std::string& what) { return {400, "usage", "the request is not HTTP: " + what}; }
UnreadableRequest gone() { return {0, "", ""}; }
UnreadableRequest too_slow() { return {408, "timeout", "the request did not arrive in time"}; }

// "a: b\r\n c" is one field on two lines, which a proxy may read as two fields.
bool is_folded(std::string_view header) {
  return header.find("\r\n ") != std::string_view::npos || header.find("\r\n\t") != std::string_view::npos;
}

// Detects early that bytes are not a header. Such bytes have a line that ends without a carriage return, or begin like
// TLS.
bool is_text(std::string_view header) {
  char before = ' ';
  for (const char c : header) {
    const bool is_control = (static_cast<unsigned char>(c) < 32 && c != '\r' && c != '\n' && c != '\t') || c == 127;
    if (is_control || (c == '\n' && before != '\r')) return false;
    before = c;
  }
  return true;
}

// Refuses fields that two parsers may understand in different ways.
void check_fields(const HttpLine::Parser& parser) {
  const auto& head = parser.get();
  if (std::distance(head.begin(), head.end()) > kFieldsMax)
    throw UnreadableRequest{431, "too_large", "the header has more than " + std::to_string(kFieldsMax) + " fields"};
  for (const http::field once :
       {http::field::host, http::field::content_length, http::field::transfer_encoding, http::field::authorization,
        http::field::origin, http::field::expect, http::field::content_type})
    if (head.count(once) > 1) throw no_http(std::string(http::to_string(once)) + " occurs twice");
  for (const char* once : {"Sec-Fetch-Site", "Sec-Fetch-Mode", "Last-Event-ID"})
    if (head.count(once) > 1) throw no_http(std::string(once) + " occurs twice");
  if (head.version() >= 11 && head.count(http::field::host) == 0) throw no_http("Host is missing");
  if (head.count(http::field::transfer_encoding) == 0) return;
  if (head.version() < 11) throw no_http("HTTP/1.0 has no Transfer-Encoding");
  if (head.count(http::field::content_length) > 0) throw no_http("it has both Transfer-Encoding and Content-Length");
  if (!beast::iequals(head[http::field::transfer_encoding], "chunked"))
    throw UnreadableRequest{501, "usage", "Transfer-Encoding: expected chunked or none"};
}

}  // namespace

// Cancels the socket's operations after a timeout. This object outlives the connection, because the timer may fire
// after the connection has ended.
struct HttpLine::Watch : std::enable_shared_from_this<HttpLine::Watch> {
  explicit Watch(Socket& watched) : socket(&watched), timer(watched.get_executor()) {}

  // At most one wait is pending, so a busy connection does not set its timer for each request.
  void wait(Clock::time_point until) {
    waits_until = until;
    timer.expires_at(until);
    timer.async_wait([self = shared_from_this(), until](const boost::system::error_code& error) {
      if (error || self->waits_until != until) return;
      self->waits_until.reset();
      if (self->socket == nullptr || !self->deadline) return;
      if (Clock::now() < *self->deadline) return self->wait(*self->deadline);
      self->is_over = true;
      boost::system::error_code ignored;
      self->socket->cancel(ignored);
    });
  }

  Socket* socket;
  asio::steady_timer timer;
  std::optional<Clock::time_point> deadline, waits_until;
  bool is_over = false;
};

HttpLine::HttpLine(Socket socket)
    : socket_(std::move(socket)), watch_(std::make_shared<Watch>(socket_)), buffer_(kBufferBytes) {
  buffer_.reserve(4096);
}

HttpLine::~HttpLine() {
  watch_->socket = nullptr;
  watch_->waits_until.reset();
  watch_->timer.cancel();
}

void HttpLine::arm(Clock::time_point until) {
  watch_->deadline = until;
  watch_->is_over = false;
  if (!watch_->waits_until || *watch_->waits_until > until) watch_->wait(until);
}

bool HttpLine::disarm() {
  watch_->deadline.reset();
  return std::exchange(watch_->is_over, false);
}

asio::awaitable<std::size_t> HttpLine::read_some(Clock::time_point until) {
  const std::size_t room = buffer_.max_size() - buffer_.size();
  arm(until);
  boost::system::error_code error;
  const std::size_t count = co_await socket_.async_read_some(buffer_.prepare(std::min<std::size_t>(room, kBufferBytes)),
                                                             asio::redirect_error(use_awaitable, error));
  const bool is_over = disarm();
  buffer_.commit(count);
  if (error == asio::error::eof) co_return 0;
  if (error && is_over) throw too_slow();
  if (error) throw gone();
  co_return count;
}

asio::awaitable<void> HttpLine::read_header(Parser& parser, Clock::time_point until) {
  const auto text = [&] { return std::string_view(static_cast<const char*>(buffer_.cdata().data()), buffer_.size()); };
  std::size_t end = text().find("\r\n\r\n");
  while (end == std::string_view::npos) {
    if (buffer_.size() == buffer_.max_size()) throw UnreadableRequest{431, "too_large", "the header is too large"};
    const std::size_t before = buffer_.size();
    const bool is_silent = before == 0;
    std::size_t count = 0;
    try {
      count = co_await read_some(until);
    } catch (const UnreadableRequest& slow) {
      throw is_silent ? gone() : slow;  // there was no request
    }
    if (count == 0) throw is_silent ? gone() : no_http("the request ends within its header");
    end = text().find("\r\n\r\n", before < 3 ? 0 : before - 3);
    if (!is_text(text().substr(0, end))) throw no_http("expected lines of text that end in CR LF");
  }
  if (is_folded(text().substr(0, end))) throw no_http("a field spans several lines");
  boost::system::error_code error;
  parser.header_limit(kBufferBytes);
  parser.body_limit(boost::none);  // read_body() checks the size
  const std::size_t used = parser.put(asio::buffer(buffer_.cdata().data(), end + 4), error);
  if (error) throw no_http(error.message());
  if (!parser.is_header_done()) throw no_http("it has no header");
  buffer_.consume(used);
  check_fields(parser);
}

asio::awaitable<void> HttpLine::read_body(Parser& parser, std::size_t bytes_max, Clock::duration silence,
                                          Clock::time_point until,
                                          std::function<asio::awaitable<void>(std::string_view)> take) {
  const UnreadableRequest too_large = {413, "too_large", "the body is too large"};
  std::string piece(kBufferBytes, '\0');
  parser.body_limit(bytes_max);
  parser.eager(true);
  std::size_t heard = buffer_.size();
  while (!parser.is_done()) {
    parser.get().body().data = piece.data();
    parser.get().body().size = piece.size();
    boost::system::error_code error;
    const std::size_t used = buffer_.size() > 0 ? parser.put(buffer_.cdata(), error) : 0;
    buffer_.consume(used);
    if (const std::size_t count = piece.size() - parser.get().body().size; count > 0)
      co_await take(std::string_view(piece).substr(0, count));
    if (error == http::error::body_limit) throw too_large;
    if (error == http::error::need_buffer) continue;
    if (error && error != http::error::need_more) throw no_http(error.message());
    if (parser.is_done()) break;
    if (used > 0 && buffer_.size() > 0) continue;
    if (buffer_.size() == buffer_.max_size())
      throw UnreadableRequest{431, "too_large", "a chunk's header is too large"};
    const std::size_t count = co_await read_some(std::min(Clock::now() + silence, until));
    if (count == 0) throw gone();
    heard += count;
    // Limits the overhead of chunks, because a client could send one byte per chunk with a long extension.
    if (heard > 2 * bytes_max + kOverheadBytes) throw too_large;
  }
}

asio::awaitable<std::size_t> HttpLine::write_some(asio::const_buffer bytes, Clock::duration silence) {
  arm(Clock::now() + silence);
  boost::system::error_code error;
  const std::size_t count = co_await socket_.async_write_some(bytes, asio::redirect_error(use_awaitable, error));
  if (disarm()) error = asio::error::timed_out;
  if (error) throw boost::system::system_error(error);
  co_return count;
}

void HttpLine::close() {
  boost::system::error_code ignored;
  socket_.close(ignored);
}

asio::awaitable<void> HttpLine::linger(Clock::duration time, std::size_t bytes_max) {
  boost::system::error_code error;
  socket_.shutdown(asio::socket_base::shutdown_send, error);
  const Clock::time_point until = Clock::now() + time;
  std::array<char, 16384> waste;
  for (std::size_t heard = 0; heard < bytes_max && !error;) {
    arm(until);
    heard += co_await socket_.async_read_some(asio::buffer(waste), asio::redirect_error(use_awaitable, error));
    if (disarm()) break;
  }
}

}  // namespace multum
