// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/http_server.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
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

#include "host/farm/service/http/http_line.h"
#include "host/farm/service/http/http_range.h"
#include "host/farm/service/http/http_reply.h"
#include "host/farm/service/log/service_log.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::use_awaitable;
using std::chrono::seconds;
using Clock = HttpLine::Clock;

constexpr auto kHeaderTime = seconds(10);  // time for a header, counted from the start of the wait; also the longest
                                           // idle time
constexpr auto kSpareTime = seconds(2);    // time for a header on a spare connection
constexpr auto kSilence = seconds(30);     // longest pause of a client that sends a body or receives an answer
constexpr auto kBodyTime = seconds(60);    // time for a body; uploads have no limit while they progress
constexpr auto kUploadTime = std::chrono::hours(24);
constexpr auto kLingerTime = seconds(5);
constexpr std::size_t kLingerMax = 64 << 20;  // most bytes to read and discard
constexpr auto kStreamPulse = seconds(10);
constexpr auto kStreamPause = std::chrono::milliseconds(50);  // pause between two writes to one listener
constexpr std::size_t kStreamBacklog = 8192;     // events waiting for a slow listener, before it is disconnected
constexpr std::size_t kStreamMemory = 64 << 20;  // bytes of all events; above this limit, slow listeners are
                                                 // disconnected
constexpr std::size_t kStreamText = 16384;       // approximate bytes per write
constexpr std::size_t kQueryMax = 32;            // most parameters of a query
constexpr std::size_t kPiece = 64 << 10;         // bytes of a body that is made while it is sent
constexpr std::size_t kSpareLines = 16;  // lines beyond connections_max, for monitors and for telling clients to wait

// A plus means a space only in queries (URL Standard, application/x-www-form-urlencoded). Returns nullopt for invalid
// text, and for a NUL, which no valid name or text contains.
std::optional<std::string> decoded(std::string_view text, bool is_query) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+' && is_query) {
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
      if (high < 0 || low < 0 || high + low == 0) return std::nullopt;
      result += static_cast<char>(16 * high + low);
      i += 2;
    } else {
      result += text[i];
    }
  }
  return result;
}

// Returns false if the target is invalid.
bool split_target(std::string_view target, HttpRequest& request) {
  const std::size_t question = target.find('?');
  const std::optional<std::string> path = decoded(target.substr(0, question), false);
  if (!path || !path->starts_with('/')) return false;
  request.path = *path;
  if (question == std::string_view::npos) return true;
  std::string_view rest = target.substr(question + 1);
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    const std::size_t equals = one.find('=');
    const std::optional<std::string> name = decoded(one.substr(0, equals), true);
    const std::optional<std::string> value =
        equals == std::string_view::npos ? std::string() : decoded(one.substr(equals + 1), true);
    if (!name || !value || request.query.size() >= kQueryMax) return false;
    request.query[*name] = *value;
  }
  return true;
}

HttpResponse busy(const std::string& message) {
  return refusal_response({503, "busy", message, {{"Retry-After", "1"}}});
}

// Increments a counter for as long as this object exists.
class Counted {
 public:
  explicit Counted(int& count) : count_(count) { ++count_; }
  ~Counted() { --count_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  int& count_;
};

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

}  // namespace

struct HttpServer::State : std::enable_shared_from_this<State> {
  State(asio::io_context& context, Settings the_settings, EventHub& hub, TaskQueue& the_tasks)
      : io(context),
        settings(std::move(the_settings)),
        events(hub),
        turns(the_tasks),
        budget(settings.memory_max),
        streams_max(std::max(1, settings.connections_max / 4 * 3)) {}

  // Counts as one listener for as long as this object exists.
  class Listener {
   public:
    static std::optional<Listener> one_more(std::shared_ptr<State> state) {
      if (state->streams >= state->streams_max) return std::nullopt;
      return Listener(std::move(state));
    }
    Listener(Listener&&) noexcept = default;
    Listener& operator=(Listener&&) = delete;
    ~Listener() {
      if (state_) --state_->streams;
    }
    State& state() const { return *state_; }

   private:
    explicit Listener(std::shared_ptr<State> state) : state_(std::move(state)) { ++state_->streams; }
    std::shared_ptr<State> state_;
  };

  template <typename Protocol>
  asio::awaitable<void> accept(std::shared_ptr<asio::basic_socket_acceptor<Protocol>> acceptor) {
    for (;;) {
      bool is_short = false;  // usually too few file descriptors or too little memory, so other connections must end
                              // first
      try {
        boost::system::error_code error;
        typename Protocol::socket socket(io);
        co_await acceptor->async_accept(socket, asio::redirect_error(use_awaitable, error));
        if (is_closed || error == asio::error::operation_aborted) co_return;
        is_short = error.failed();
        if (!is_short) {
          ++counters.connections;
          start(HttpLine::Socket(std::move(socket)));
        }
      } catch (const std::exception&) {
        ++counters.failures;
        is_short = true;
      }
      try {
        asio::steady_timer pause(io, std::chrono::milliseconds(100));
        if (is_short) co_await pause.async_wait(use_awaitable);
      } catch (const std::exception&) {  // no memory even for a pause
      }
    }
  }

  void start(HttpLine::Socket socket) {
    MemoryShare share(budget);
    const bool has_room = open + streams < settings.connections_max && share.resize(HttpLine::kBytes);
    const auto line = std::make_shared<HttpLine>(std::move(socket));
    if (has_room) {
      asio::co_spawn(io, serve(this->shared_from_this(), line, std::move(share)), asio::detached);
      return;
    }
    // The latest connections get the spare connections, because silent clients must not keep monitors out.
    ++counters.refused_connections;
    spare_lines.push_back(line);
    if (spare_lines.size() > kSpareLines) {
      if (const std::shared_ptr<HttpLine> oldest = spare_lines.front().lock()) oldest->close();
      spare_lines.pop_front();
    }
    asio::co_spawn(io, serve_spare(line, this->shared_from_this()), asio::detached);
  }

  // Arguments are destroyed in reverse order, so the budget still exists when the share is returned to it.
  static asio::awaitable<void> serve(std::shared_ptr<State> self, std::shared_ptr<HttpLine> line,
                                     [[maybe_unused]] MemoryShare its_own) {
    const Counted counted(self->open);
    try {
      while (!self->is_closed && co_await self->serve_one(*line, false)) {
      }
    } catch (const boost::system::system_error& error) {
      if (error.code() == asio::error::timed_out) ++self->counters.timeouts;
    } catch (const std::exception& error) {  // no memory for a request, so the connection ends
      ++self->counters.failures;
      service_log(LogSeverity::kWarning, 0, std::string("dropped a connection: ") + error.what());
    }
  }

  // Reads the header of one request. Answers monitors, and tells other clients to try again.
  static asio::awaitable<void> serve_spare(std::shared_ptr<HttpLine> line, std::shared_ptr<State> self) {
    const Counted counted(self->spare);
    try {
      co_await self->serve_one(*line, true);
    } catch (const std::exception&) {  // the connection is closed anyway
    }
  }

  // Returns false if the connection must be closed.
  asio::awaitable<bool> serve_one(HttpLine& line, bool is_spare) {
    HttpLine::Parser parser;
    HttpRequest request;
    MemoryShare share(budget);
    std::optional<HttpResponse> early;
    bool is_head = false, has_header = false, is_urgent = false;
    unsigned version = 11;
    try {
      co_await line.read_header(parser, Clock::now() + (is_spare ? kSpareTime : kHeaderTime));
      has_header = true;
      version = parser.get().version();
      is_head = parser.get().method() == http::verb::head;
      early = take_header(parser, request);
      is_urgent = settings.is_urgent(request.path);
      if (!early && is_spare && !(is_urgent && parser.is_done())) early = busy("all connections are in use");
      if (!early) co_await read_body(line, parser, request, share);
    } catch (const UnreadableRequest& unreadable) {
      if (unreadable.status == 408) ++counters.timeouts;
      if (unreadable.status == 0) co_return false;
      early = refusal_response({unreadable.status, unreadable.code, unreadable.message});
    } catch (const Refusal& refusal) {
      early = refusal_response(refusal);
    } catch (const Error& error) {
      early = refusal_response(refusal_of(error));
    }
    if (early) {
      co_await send(line, version, false, has_header && is_head, std::move(*early));
      co_await line.linger(is_spare ? kSpareTime : kLingerTime, kLingerMax);
      co_return false;
    }
    bool keep = parser.keep_alive() && !is_spare;
    ++counters.requests;
    if (!is_urgent) co_await turn();
    request.memory = &share;
    const RangeRequest range = range_request(request);
    HttpResponse response = co_await settings.answer(std::move(request));
    share.resize(0);
    serve_range(response, range, is_head);
    if (response.is_stream && !is_head) {
      std::optional<Listener> listener = Listener::one_more(this->shared_from_this());
      if (listener) {
        co_await hand_to_hub(line, version, std::move(response), std::move(*listener));
        co_return false;
      }
      keep = false;
      response = busy("too many clients are listening to events");
    } else if (!is_urgent && !share.resize(response.made ? response.made->memory() + kPiece : response.body.size())) {
      keep = false;
      response = busy("there is not enough memory for the answer");
    }
    co_return co_await send(line, version, keep && !is_closed, is_head, std::move(response));
  }

  // Returns the answer if it can be given at once.
  std::optional<HttpResponse> take_header(const HttpLine::Parser& parser, HttpRequest& request) {
    const auto& head = parser.get();
    request.method = head.method() == http::verb::head ? "GET" : std::string(head.method_string());
    for (const auto& field : head) request.headers[lower(field.name_string())] = std::string(field.value());
    if (!split_target(std::string_view(head.target().data(), head.target().size()), request))
      return refusal_response({400, "usage", "the target is not a path"});
    if (const std::unique_ptr<HttpResponse> refused = settings.check(request)) return *refused;
    const std::size_t limit = body_limit(request);
    if (limit == 0 && !parser.is_done())
      return refusal_response({413, "too_large", fmt::format("a {} request must not have a body", request.method)});
    if (parser.content_length() && *parser.content_length() > limit)
      return refusal_response({413, "too_large", fmt::format("the body may have at most {} bytes", limit)});
    return std::nullopt;
  }

  std::size_t body_limit(const HttpRequest& request) const {
    if (settings.is_upload(request.method, request.path)) return settings.upload_max;
    return request.method == "POST" ? settings.body_max : 0;
  }

  asio::awaitable<void> read_body(HttpLine& line, HttpLine::Parser& parser, HttpRequest& request, MemoryShare& share) {
    const bool is_upload = settings.is_upload(request.method, request.path);
    if (is_upload) {
      const std::size_t bytes = parser.content_length() ? *parser.content_length() : settings.upload_max;
      co_await settings.beside([&] { request.upload = settings.open_upload(bytes); });
    }
    if (parser.is_done()) co_return;
    if (lower(request.headers["expect"]) == "100-continue") {
      http::response<http::empty_body> go_on(http::status::continue_, parser.get().version());
      http::response_serializer<http::empty_body> serializer(go_on);
      while (!serializer.is_done()) co_await line.write_some(serializer, kSilence);
    }
    const auto until = Clock::now() + (is_upload ? Clock::duration(kUploadTime) : Clock::duration(kBodyTime));
    const auto keep = [&](std::string_view piece) -> asio::awaitable<void> {
      if (is_upload) {
        co_await settings.beside([&] { request.upload->write(piece); });
        co_return;
      }
      // Reserves twice the size, because moving a growing string needs memory for both copies.
      if (!share.resize(2 * (request.body.size() + piece.size())))
        throw Refusal{503, "busy", "there is not enough memory for the request", {{"Retry-After", "1"}}};
      request.body += piece;
    };
    co_await line.read_body(parser, body_limit(request), kSilence, until, keep);
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

  asio::awaitable<bool> send(HttpLine& line, unsigned version, bool keep, bool is_head, HttpResponse response) {
    const auto status = static_cast<http::status>(response.status);
    if (response.file) {
      http::response<http::file_body> message(status, version);
      boost::system::error_code error;
      beast::file_posix file;
      file.native_handle(::dup(response.file->descriptor()));
      message.body().reset(std::move(file), error);
      if (error) throw boost::system::system_error(error);
      fill_header(message, keep, response);
      message.prepare_payload();
      co_return co_await finish(line, message, keep, is_head);
    }
    if (response.made) co_return co_await send_made(line, version, keep, is_head, std::move(response));
    http::response<http::string_body> message(status, version);
    message.body() = std::move(response.body);
    fill_header(message, keep, response);
    message.prepare_payload();
    co_return co_await finish(line, message, keep, is_head);
  }

  // Sends any number of bytes, as long as the client continues to receive them.
  template <typename Message>
  static asio::awaitable<bool> finish(HttpLine& line, Message& message, bool keep, bool is_head) {
    http::response_serializer<typename Message::body_type> serializer(message);
    serializer.split(is_head);
    while (is_head ? !serializer.is_header_done() : !serializer.is_done())
      co_await line.write_some(serializer, kSilence);
    co_return keep;
  }

  asio::awaitable<bool> send_made(HttpLine& line, unsigned version, bool keep, bool is_head, HttpResponse response) {
    http::response<http::empty_body> message(static_cast<http::status>(response.status), version);
    fill_header(message, keep, response);
    const HttpBodyPart part = response.part.value_or(HttpBodyPart{0, response.made->bytes()});
    message.content_length(part.count);
    http::response_serializer<http::empty_body> serializer(message);
    serializer.split(true);
    while (!serializer.is_header_done()) co_await line.write_some(serializer, kSilence);
    std::vector<char> piece(is_head ? 0 : kPiece);
    if (!is_head && part.first > 0) co_await settings.beside([&] { response.made->skip(part.first); });
    for (std::uint64_t left = is_head ? 0 : part.count; left > 0;) {
      std::size_t count = 0;
      const std::size_t wanted = std::min<std::uint64_t>(piece.size(), left);
      co_await settings.beside([&] { count = response.made->read(piece.data(), wanted); });
      if (count == 0 || count > left)
        throw Error(ErrorCode::kEnvironment, "the length of the answer differs from the announced length");
      for (asio::const_buffer rest(piece.data(), count); rest.size() > 0;)
        rest += co_await line.write_some(rest, kSilence);
      left -= count;
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

  // Hands the connection to the hub's thread, which owns it from now on.
  asio::awaitable<void> hand_to_hub(HttpLine& line, unsigned version, HttpResponse response, Listener listener) {
    http::response<http::empty_body> message(http::status::ok, version);
    response.content_type = "text/event-stream";
    response.headers.emplace_back("Cache-Control", "no-store");
    fill_header(message, false, response);
    message.chunked(true);
    http::response_serializer<http::empty_body> serializer(message);
    serializer.split(true);
    while (!serializer.is_header_done()) co_await line.write_some(serializer, kSilence);
    HttpLine::Socket socket = line.release();
    const auto protocol = socket.local_endpoint().protocol();
    HttpLine::Socket moved(events.io(), protocol, socket.release());
    asio::co_spawn(
        events.io(),
        send_events(std::move(listener), beast::basic_stream<asio::generic::stream_protocol>(std::move(moved)),
                    response.after, response.job),
        asio::detached);
  }

  // Runs on the hub's thread. All listeners share the texts of events.
  static asio::awaitable<void> send_events(Listener listener,
                                           beast::basic_stream<asio::generic::stream_protocol> stream,
                                           std::uint64_t after, std::int64_t job) {
    using Text = std::shared_ptr<const std::string>;
    struct Line {
      std::deque<Text> waiting;
      bool is_behind = false, is_asleep = false, is_gone = false;
      asio::steady_timer wake;
    };
    State& self = listener.state();
    const auto line = std::make_shared<Line>(Line{{}, false, false, false, asio::steady_timer(self.events.io())});
    // A listener sends no more data, so a readable socket means that the listener has disconnected.
    stream.socket().async_wait(asio::socket_base::wait_read, [line](const boost::system::error_code& error) {
      if (error) return;
      line->is_gone = true;
      line->wake.cancel();
    });
    EventHub& events = self.events;
    const std::uint64_t key = events.add(after, [line, job, &events](const ServiceEvent& event) {
      if (job != 0 && event.job != 0 && event.job != job) return;
      const bool is_too_much = !line->waiting.empty() && events.bytes() > kStreamMemory;
      if (line->waiting.size() >= kStreamBacklog || is_too_much) line->is_behind = true;
      else line->waiting.push_back(event.text);
      if (std::exchange(line->is_asleep, false)) line->wake.cancel();
    });
    std::string text = ": multum\nretry: 2000\n\n";
    try {
      while (!self.is_closed && !line->is_behind && !line->is_gone) {
        for (; !line->waiting.empty() && text.size() < kStreamText; line->waiting.pop_front())
          text += *line->waiting.front();
        boost::system::error_code error;
        if (!text.empty()) {
          stream.expires_after(kSilence);
          co_await asio::async_write(stream, http::make_chunk(asio::buffer(text)), use_awaitable);
          text.clear();
          if (!line->waiting.empty()) continue;
          // Sends all events that arrive within the pause together. Many listeners then cost little more than a few.
          line->wake.expires_after(kStreamPause);
          co_await line->wake.async_wait(asio::redirect_error(use_awaitable, error));
        }
        if (!line->waiting.empty() || line->is_gone) continue;
        text.shrink_to_fit();
        line->is_asleep = true;
        line->wake.expires_after(kStreamPulse);
        co_await line->wake.async_wait(asio::redirect_error(use_awaitable, error));
        line->is_asleep = false;
        if (!error) text = ": pulse\n\n";  // shows both sides that the connection works
      }
    } catch (const std::exception&) {  // the client has disconnected, or reconnects because there was no memory
    }
    events.remove(key);
  }

  asio::io_context& io;
  Settings settings;
  EventHub& events;
  Counters counters;
  TaskQueue& turns;
  MemoryBudget budget;
  const int streams_max;
  int open = 0, spare = 0;  // number of lines
  std::deque<std::weak_ptr<HttpLine>> spare_lines;
  std::atomic<bool> is_closed = false;
  std::atomic<int> streams = 0;
  std::vector<std::function<void()>> closers;
  std::string unix_path;
};

HttpServer::HttpServer(asio::io_context& io, Settings settings, EventHub& events, TaskQueue& turns)
    : state_(std::make_shared<State>(io, std::move(settings), events, turns)) {}

HttpServer::~HttpServer() { close(); }

int HttpServer::listen_tcp(const std::string& host, int port) {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(host, error);
  if (error) throw Error(ErrorCode::kUsage, fmt::format("'{}' is not a numeric address to listen on", host));
  const asio::ip::tcp::endpoint endpoint(address, static_cast<std::uint16_t>(port));
  const auto acceptor = std::make_shared<asio::basic_socket_acceptor<asio::ip::tcp>>(state_->io);
  try {
    acceptor->open(endpoint.protocol());
    acceptor->set_option(asio::socket_base::reuse_address(true));
    acceptor->bind(endpoint);
    acceptor->listen(4096);
  } catch (const boost::system::system_error& failed) {
    throw Error(ErrorCode::kEnvironment,
                fmt::format("cannot listen on {}:{}: {}", host, port, failed.code().message()));
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
    throw Error(ErrorCode::kEnvironment, path + ": exists already and is not a socket");
  asio::local::stream_protocol::socket probe(state_->io);
  boost::system::error_code error;
  probe.connect(path, error);
  if (!error) throw Error(ErrorCode::kEnvironment, path + ": another program is listening on this socket");
  ::unlink(path.c_str());
  const auto acceptor = std::make_shared<asio::basic_socket_acceptor<asio::local::stream_protocol>>(state_->io);
  const mode_t mask = ::umask(0177);
  try {
    acceptor->open();
    acceptor->bind(path);
    acceptor->listen(4096);
  } catch (const boost::system::system_error& failed) {
    ::umask(mask);
    throw Error(ErrorCode::kEnvironment, fmt::format("cannot listen on {}: {}", path, failed.code().message()));
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
  counters.open = state_->open + state_->spare + counters.streams;
  counters.memory = state_->budget.used();
  return counters;
}

}  // namespace multum
