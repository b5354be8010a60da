// SPDX-License-Identifier: Apache-2.0
// Tests that a client does not wait forever if the service does not accept connections, sends no answer, stops in the
// middle of its answer, or stops sending events.
#include "host/farm/service/http/http_client.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <thread>

#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;

constexpr HttpPatience kImpatient = {.connecting = 300ms, .answer = 300ms, .work = 300ms};

// Answers one request with this text. Keeps the connection open until this object is destroyed.
class Answering {
 public:
  explicit Answering(std::string text) : acceptor_(io_, {boost::asio::ip::address_v4::loopback(), 0}) {
    thread_ = std::thread([this, text = std::move(text)] {
      tcp::socket socket(io_);
      boost::system::error_code error;
      acceptor_.accept(socket, error);
      std::string request;
      boost::asio::read_until(socket, boost::asio::dynamic_buffer(request), "\r\n\r\n", error);
      boost::asio::write(socket, boost::asio::buffer(text), error);
      char rest = 0;
      while (!error) socket.read_some(boost::asio::buffer(&rest, 1), error);
    });
  }
  ~Answering() { thread_.join(); }
  Answering(const Answering&) = delete;
  Answering& operator=(const Answering&) = delete;
  std::string server() const { return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()); }

 private:
  boost::asio::io_context io_;
  tcp::acceptor acceptor_;
  std::thread thread_;
};

void expect_given_up(const std::function<void()>& ask) {
  testing::expect_error(ErrorCode::kEnvironment, {"127.0.0.1", "no answer"}, ask);
}

TEST(HttpClientTest, AnAnswerIsRead) {
  const Answering service("HTTP/1.1 200 OK\r\nContent-Length: 9\r\nConnection: close\r\n\r\n{\"a\": 17}");
  EXPECT_EQ(HttpClient(service.server(), "", kImpatient).ask("GET", "/")["a"], 17);
}

TEST(HttpClientTest, SilenceIsNotWaitedForEndlessly) {
  for (const char* said : {"", "HTTP/1.1 200 OK\r\nContent-Le", "HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n{\"a\""}) {
    SCOPED_TRACE(said);
    {
      const Answering service(said);
      expect_given_up([&] { HttpClient(service.server(), "", kImpatient).ask("GET", "/"); });
    }
    const Answering service(said);
    expect_given_up([&] { HttpClient(service.server(), "", kImpatient).ask("POST", "/", {{"a", 1}}); });
  }
}

TEST(HttpClientTest, AStreamThatFallsSilentIsGivenUp) {
  const Answering service(
      "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n1b\r\nevent: job\ndata: {\"id\":1}\n\n\r\n");
  int events = 0;
  expect_given_up([&] {
    HttpClient(service.server(), "", kImpatient)
        .listen(
            "/v1/events", [] { return true; },
            [&](const auto&, const auto&) {
              ++events;
              return true;
            });
  });
  EXPECT_EQ(events, 1);
}

}  // namespace
}  // namespace multum
