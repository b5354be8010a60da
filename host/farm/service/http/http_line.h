// SPDX-License-Identifier: Apache-2.0
// One connection: reads requests and writes answers, within limits of bytes and of time. Whatever a client sends, it
// costs its own connection at most: what is read lies in a buffer that does not grow, and a parser that throws throws
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

/// Why a request cannot be read on; `status` 0: there is nobody to tell.
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

  /// Bytes that are read and not yet used: a whole header, the extension of a chunk or a trailer must fit in.
  static constexpr std::size_t kBufferBytes = 16384;
  /// Bytes that a line takes, about, but for bodies and answers: the buffer, a piece of a body, and a header's fields
  /// twice.
  static constexpr std::size_t kBytes = 4 * kBufferBytes;

  explicit HttpLine(Socket socket);
  ~HttpLine();
  HttpLine(const HttpLine&) = delete;
  HttpLine& operator=(const HttpLine&) = delete;

  /// Reads a header. Throws UnreadableRequest: it is none, it is too large, it is not here `until` then, or whether it
  /// is one request or two is not for sure (RFC 9112, sections 5.2, 6.1 and 11.2).
  boost::asio::awaitable<void> read_header(Parser& parser, Clock::time_point until);
  /// Reads the body behind it, piece by piece, up to `bytes_max`. `silence`: how long a client may say nothing;
  /// `until`: when all of it must be here. Throws UnreadableRequest, and whatever `take` throws.
  boost::asio::awaitable<void> read_body(Parser& parser, std::size_t bytes_max, Clock::duration silence,
                                         Clock::time_point until,
                                         std::function<boost::asio::awaitable<void>(std::string_view)> take);

  /// A piece of an answer, as far as it goes at once. Throws boost::system::system_error, also when `silence` is over.
  template <typename Serializer>
  boost::asio::awaitable<void> write_some(Serializer& serializer, Clock::duration silence);

  /// Writes some of the bytes; returns how many.
  boost::asio::awaitable<std::size_t> write_some(boost::asio::const_buffer bytes, Clock::duration silence);

  /// Hears the client for a while, and listens to nothing: somebody who still talks when the line is closed may never
  /// see the answer, since the system throws it away.
  boost::asio::awaitable<void> linger(Clock::duration time, std::size_t bytes_max);

  /// Ends whatever waits here.
  void close();
  /// For a listener's stream. The line is of no use any more.
  Socket release() { return std::move(socket_); }

 private:
  struct Watch;
  /// 0 bytes: the client has closed its side. Throws UnreadableRequest when the time is over or the line broken.
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
