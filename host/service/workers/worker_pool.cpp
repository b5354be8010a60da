// SPDX-License-Identifier: Apache-2.0
#include "host/service/workers/worker_pool.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/processes/spawn_process.h"
#include "host/service/service_log.h"

namespace multum {
namespace {

namespace asio = boost::asio;
using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr auto kTick = milliseconds(250);
constexpr int kSocket = 3;                 // of a worker
constexpr std::size_t kLineMax = 1 << 20;  // bytes: a worker that says more in one breath has lost its mind
constexpr int kBackOffDoublingsMax = 4;    // of the pause before another worker is started, from 250 ms on

// It has no connections and listeners: a line that the daemon closes must be closed for its client. What a worker has
// started ends with it, and Ctrl-C is the daemon's alone.
pid_t spawn_worker(std::vector<std::string> command, int socket) {
  command.push_back(fmt::format("--socket={}", kSocket));
  return spawn_process(command,
                       {.files = {{socket, kSocket}},
                        .has_own_group = true,
                        .ends_with_thread = true,
                        .blocked_signals = std::vector<int>{}});
}

// Of a worker's words: they are kept, and told to everybody.
std::string text_of(const Json& said, const char* key) {
  constexpr std::size_t kLongest = 8192;  // bytes
  std::string text = said.value(key, "");
  if (text.size() <= kLongest) return text;
  std::size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not within a character
  text.resize(end);
  return text + " ...";
}

std::string death_of(int status) {
  if (WIFSIGNALED(status)) return fmt::format("its worker was ended by signal {}", WTERMSIG(status));
  return fmt::format("its worker ended with exit code {}", WEXITSTATUS(status));
}

}  // namespace

struct WorkerPool::Worker {
  explicit Worker(asio::io_context& io) : socket(io) {}
  std::string owner;
  pid_t pid = -1;
  asio::local::stream_protocol::socket socket;
  std::string received;
  std::array<char, 16384> bytes;
  std::deque<std::string> to_send;
  bool is_ready = false, is_ended = false, is_ending = false;
  std::int64_t job = 0;  // 0: idle
  int attempt = 0;
  int jobs_done = 0;
  JobProgress progress;
  Clock::time_point heard, got_on, kill_at = Clock::time_point::max();
  std::string why_killed;
};

WorkerPool::WorkerPool(asio::io_context& io, WorkerPoolSettings settings, std::string instance, Events events)
    : io_(io), settings_(std::move(settings)), instance_(std::move(instance)), events_(std::move(events)), timer_(io) {}

WorkerPool::~WorkerPool() {
  for (const auto& [owner, worker] : workers_) {
    ::kill(-worker->pid, SIGKILL);
    ::waitpid(worker->pid, nullptr, 0);
  }
}

void WorkerPool::start() { tick(); }

void WorkerPool::spawn() {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
    throw Error(ErrorCode::kEnvironment, fmt::format("no socket for a worker: {}", std::strerror(errno)));
  const auto worker = std::make_shared<Worker>(io_);
  worker->socket.assign(asio::local::stream_protocol(), pair[0]);
  try {
    worker->pid = spawn_worker(settings_.command, pair[1]);
  } catch (...) {
    ::close(pair[1]);
    throw;
  }
  ::close(pair[1]);
  ++started_;
  worker->owner = fmt::format("{}:{}:{}", instance_, worker->pid, started_);
  worker->heard = Clock::now();
  workers_[worker->owner] = worker;
  read(worker);
}

void WorkerPool::read(const std::shared_ptr<Worker>& worker) {
  worker->socket.async_read_some(asio::buffer(worker->bytes),
                                 [this, worker](const boost::system::error_code& error, std::size_t count) {
                                   if (worker->is_ended) return;
                                   if (error) return reap(worker, "");
                                   worker->received.append(worker->bytes.data(), count);
                                   take_lines(*worker);
                                   if (worker->received.size() > kLineMax) return reap(worker, "it talks nonsense");
                                   if (!worker->is_ended) read(worker);
                                 });
}

void WorkerPool::take_lines(Worker& worker) {
  worker.heard = Clock::now();
  std::size_t begin = 0;
  for (std::size_t end = worker.received.find('\n'); end != std::string::npos;
       end = worker.received.find('\n', begin)) {
    const Json said = Json::parse(worker.received.data() + begin, worker.received.data() + end, nullptr, false);
    begin = end + 1;
    if (!said.is_object()) continue;
    if (said.contains("ready")) {
      worker.is_ready = true;
      failures_ = 0;
      events_.ready();
    } else if (said.contains("progress") && worker.job != 0) {
      const JobProgress now = {text_of(said["progress"], "stage"), said["progress"].value("done", std::uint64_t{0}),
                               said["progress"].value("total", std::uint64_t{0})};
      if (now.stage != worker.progress.stage || now.done != worker.progress.done) worker.got_on = worker.heard;
      worker.progress = now;
      events_.progress(worker.job, now);
    } else if (said.contains("ended") && said["ended"] == worker.job && said.value("attempt", 0) == worker.attempt) {
      const std::int64_t job = std::exchange(worker.job, 0);
      worker.kill_at = Clock::time_point::max();
      ++worker.jobs_done;
      if (is_closing_ || worker.jobs_done >= settings_.jobs_a_worker) {
        worker.is_ending = true;
        send(workers_.at(worker.owner), R"({"end":true})");
      }
      events_.ended(job, worker.owner, worker.attempt,
                    {said.value("exit_code", 4), text_of(said, "message"), said.value("inputs_changed", false)});
      events_.ready();
    }
  }
  worker.received.erase(0, begin);
}

void WorkerPool::send(const std::shared_ptr<Worker>& worker, const std::string& line) {
  worker->to_send.push_back(line + "\n");
  if (worker->to_send.size() == 1) write_next(worker);
}

void WorkerPool::write_next(const std::shared_ptr<Worker>& worker) {
  asio::async_write(worker->socket, asio::buffer(worker->to_send.front()),
                    [this, worker](const boost::system::error_code& error, std::size_t) {
                      if (worker->is_ended || error) return;  // reading hears of it too
                      worker->to_send.pop_front();
                      if (!worker->to_send.empty()) write_next(worker);
                    });
}

std::vector<std::string> WorkerPool::idle() const {
  std::vector<std::string> owners;
  for (const auto& [owner, worker] : workers_)
    if (is_idle(owner)) owners.push_back(owner);
  return owners;
}

bool WorkerPool::is_idle(const std::string& owner) const {
  const auto found = workers_.find(owner);
  return found != workers_.end() && found->second->is_ready && !found->second->is_ending && found->second->job == 0;
}

bool WorkerPool::order(const std::string& owner, const WorkOrder& work) {
  const auto found = workers_.find(owner);
  if (found == workers_.end() || found->second->is_ending || found->second->job != 0) return false;
  Worker& worker = *found->second;
  worker.job = work.job;
  worker.attempt = work.attempt;
  worker.progress = {};
  worker.heard = worker.got_on = Clock::now();
  const Json command = {{"run", work.job},
                        {"attempt", work.attempt},
                        {"arguments", work.arguments},
                        {"output", work.output},
                        {"folder", work.folder},
                        {"log", work.log},
                        {"type", work.type},
                        {"parameters", work.parameters},
                        {"inputs", work.inputs},
                        {"copy_from", work.copy_from},
                        {"copy_to", work.copy_to}};
  send(found->second, command.dump(-1, ' ', false, Json::error_handler_t::replace));
  return true;
}

bool WorkerPool::cancel(std::int64_t job) {
  for (const auto& [owner, worker] : workers_) {
    if (worker->job != job) continue;
    if (worker->kill_at == Clock::time_point::max()) {
      worker->kill_at = Clock::now() + settings_.cancel_grace;
      worker->why_killed = "it did not stop when asked to, and was killed";
      send(worker, Json{{"cancel", job}}.dump());
    }
    return true;
  }
  return false;
}

void WorkerPool::close() {
  is_closing_ = true;
  for (const auto& [owner, worker] : workers_)
    if (worker->job == 0 && !worker->is_ending) {
      worker->is_ending = true;
      send(worker, R"({"end":true})");
    }
}

bool WorkerPool::has_running() const { return !running().empty(); }

std::vector<std::int64_t> WorkerPool::running() const {
  std::vector<std::int64_t> jobs;
  for (const auto& [owner, worker] : workers_)
    if (worker->job != 0) jobs.push_back(worker->job);
  return jobs;
}

void WorkerPool::reap(const std::shared_ptr<Worker>& worker, const std::string& why) {
  worker->is_ended = true;
  boost::system::error_code ignored;
  worker->socket.close(ignored);
  ::kill(-worker->pid, SIGKILL);
  int status = 0;
  while (::waitpid(worker->pid, &status, 0) < 0 && errno == EINTR) {
  }
  workers_.erase(worker->owner);
  if (!worker->is_ending || worker->job != 0) {
    ++lost_;
    if (!worker->is_ready) {
      ++failures_;
      service_log(LogSeverity::kWarning, 0, "before it was ready, " + (why.empty() ? death_of(status) : why));
    }
    not_before_ = Clock::now() + (failures_ > 1 ? kTick * (1 << std::min(failures_, kBackOffDoublingsMax)) : kTick * 0);
  }
  if (worker->job != 0)
    events_.ended(worker->job, worker->owner, worker->attempt, {-1, why.empty() ? death_of(status) : why, false});
  if (!is_closing_) asio::post(io_, [this] { tick(); });
}

void WorkerPool::tick() {
  const Clock::time_point now = Clock::now();
  const auto all = workers_;  // those that are buried leave the list
  for (const auto& [owner, worker] : all) {
    if (now - worker->heard > settings_.lease) {
      reap(worker, fmt::format("its worker was silent for {} ms and was killed", settings_.lease.count()));
    } else if (now > worker->kill_at) {
      reap(worker, worker->why_killed);
    } else if (worker->job != 0 && settings_.no_progress.count() > 0 && now - worker->got_on > settings_.no_progress) {
      reap(worker, fmt::format("it made no progress for {} ms and was killed", settings_.no_progress.count()));
    }
  }
  try {
    while (!is_closing_ && live_count() < settings_.workers && now >= not_before_) spawn();
  } catch (const Error& error) {
    service_log(LogSeverity::kError, 0, error.what());
    not_before_ = now + std::chrono::seconds(5);
  }
  timer_.expires_after(kTick);
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) tick();
  });
}

}  // namespace multum
