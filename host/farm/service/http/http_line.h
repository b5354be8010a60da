// SPDX-License-Identifier: Apache-2.0
// Reads requests and writes answers on one connection, within limits of bytes and of time. Faulty input can only end
// the connection of the client that sent it. The read buffer does not grow, and exceptions of the parser are thrown
// here.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/write.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace multum {

/// The reason why a request cannot be read further. A `status` of 0 means that the client has disconnected, so no
/// answer is sent.
struct UnreadableRequest {
  int status;
  const char* code;
  std::string message;
};

class HttpLine {
 public:
  using Socket = boost::asio::generic::stream_protocol::socket;
  using Clock = std::chrono::steady_clock;
  using Parser = boost::beast::http::request_parser<boost::beast::http::buffer_body>;

  /// The size of the buffer for bytes that are read but not yet used. A whole header, a chunk's extension or a trailer
  /// must fit into this buffer.
  static constexpr std::size_t kBufferBytes = 16384;
  /// The approximate memory of a connection without bodies and answers. This is the memory for the buffer, a piece of a
  /// body, and two copies of a header's fields.
  static constexpr std::size_t kBytes = 4 * kBufferBytes;

  explicit HttpLine(Socket socket);
  ~HttpLine();
  HttpLine(const HttpLine&) = delete;
  HttpLine& operator=(const HttpLine&) = delete;

  /// Reads a header. Throws UnreadableRequest if the bytes are not a header, if the header is too large, or if it is
  /// incomplete at the time `until`. Refuses a header that could mean one request or two (RFC 9112, sections 5.2, 6.1
  /// and 11.2).
  boost::asio::awaitable<void> read_header(Parser& parser, Clock::time_point until);
  /// Reads the body after the header, piece by piece, up to `bytes_max`. `silence` is the client's longest pause, and
  /// `until` is the time at which the body must end. Throws UnreadableRequest, and passes on exceptions of `take`.
  boost::asio::awaitable<void> read_body(Parser& parser, std::size_t bytes_max, Clock::duration silence,
                                         Clock::time_point until,
                                         std::function<boost::asio::awaitable<void>(std::string_view)> take);

  /// Writes as much of an answer as fits at once. Throws boost::system::system_error, for example after a pause of
  /// `silence`.
  template <typename Serializer>
  boost::asio::awaitable<void> write_some(Serializer& serializer, Clock::duration silence);

  /// Writes some of the bytes and returns their number.
  boost::asio::awaitable<std::size_t> write_some(boost::asio::const_buffer bytes, Clock::duration silence);

  /// Reads and discards the client's bytes for a while. If the connection were closed while the client still sends, the
  /// system might discard the answer.
  boost::asio::awaitable<void> linger(Clock::duration time, std::size_t bytes_max);

  /// Cancels all pending operations.
  void close();
  /// Gives up the socket, for a stream of events. This object cannot be used afterwards.
  Socket release() { return std::move(socket_); }

 private:
  struct Watch;
  /// A result of 0 bytes means that the client has closed its side. Throws UnreadableRequest after a timeout or on a
  /// broken connection.
  boost::asio::awaitable<std::size_t> read_some(Clock::time_point until);
  void arm(Clock::time_point until);
  bool disarm();

  Socket socket_;
  std::shared_ptr<Watch> watch_;
  boost::beast::flat_buffer buffer_;
};

template <typename Serializer>
boost::asio::awaitable<void> HttpLine::write_some(Serializer& serializer, Clock::duration silence) {
  arm(Clock::now() + silence);
  boost::system::error_code error;
  co_await boost::beast::http::async_write_some(socket_, serializer,
                                                boost::asio::redirect_error(boost::asio::use_awaitable, error));
  if (disarm()) error = boost::asio::error::timed_out;
  if (error) throw boost::system::system_error(error);
}

}  // namespace multum
