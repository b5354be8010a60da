// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/workers/worker_pool.h"

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

#include "host/farm/service/log/service_log.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/processes/spawn_process.h"

namespace multum {
namespace {

namespace asio = boost::asio;
using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr auto kTick = milliseconds(250);
constexpr int kSocket = 3;                 // descriptor of a worker's socket
constexpr std::size_t kLineMax = 1 << 20;  // bytes per line; a worker that sends more is broken
constexpr char kNonsense[] = "it sent an invalid message";
constexpr int kBackOffDoublingsMax = 4;  // the pause before a worker is restarted begins at 250 ms and doubles at most
                                         // this many times

// A worker inherits no connections or listeners. Otherwise a client would not see that the daemon closes a connection.
// Processes that a worker has started end with it, and Ctrl-C reaches only the daemon.
pid_t spawn_worker(std::vector<std::string> command, int socket) {
  command.push_back(fmt::format("--socket={}", kSocket));
  return spawn_process(command, {.files = {{socket, kSocket}},
                                 .has_own_group = true,
                                 .ends_with_thread = true,
                                 .blocked_signals = std::vector<int>{}});
}

// Truncates a worker's text, because it is stored and sent to all listeners.
std::string text_of(const Json& said, const char* key) {
  constexpr std::size_t kLongest = 8192;  // bytes of the longest text
  std::string text = said.value(key, "");
  if (text.size() <= kLongest) return text;
  std::size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // avoids cutting a character
  text.resize(end);
  return text + " ...";
}

std::string death_of(int status) {
  if (WIFSIGNALED(status)) return fmt::format("its worker was terminated by signal {}", WTERMSIG(status));
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
  int status = 0;  // exit status, once the process has ended
  bool is_ready = false, is_ended = false;
  bool is_ending = false;        // the worker gets no more jobs
  bool is_asked_to_end = false;  // told to end, so the process ends by itself
  std::int64_t job = 0;          // number of the job, 0 if idle
  int attempt = 0;
  int jobs_done = 0;
  JobProgress progress;
  Clock::time_point heard, got_on, kill_at = Clock::time_point::max();
  std::string why_killed;
};

WorkerPool::WorkerPool(asio::io_context& io, WorkerPoolSettings settings, std::string instance, Events events)
    : io_(io), settings_(std::move(settings)), instance_(std::move(instance)), events_(std::move(events)), timer_(io) {}

WorkerPool::~WorkerPool() {
  for (const auto& [owner, worker] : workers_) end_process(*worker);
}

void WorkerPool::start() { tick(); }

void WorkerPool::spawn() {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
    throw Error(ErrorCode::kEnvironment, fmt::format("cannot create a socket for a worker: {}", std::strerror(errno)));
  OpenFile ours(pair[0]);
  const OpenFile theirs(pair[1]);
  const auto worker = std::make_shared<Worker>(io_);
  worker->socket.assign(asio::local::stream_protocol(), ours.descriptor());
  ours.release();
  worker->pid = spawn_worker(settings_.command, theirs.descriptor());
  ++started_;
  try {
    worker->owner = fmt::format("{}:{}:{}", instance_, worker->pid, started_);
    worker->heard = Clock::now();
    workers_[worker->owner] = worker;
    read(worker);
  } catch (...) {  // otherwise the end of the process would not be noticed
    worker->is_ended = true;
    workers_.erase(worker->owner);
    end_process(*worker);
    throw;
  }
}

// Kills the process and waits until it has ended. Later calls have no effect. Processes that it has started end with
// it.
void WorkerPool::end_process(Worker& worker) {
  if (worker.pid <= 0) return;
  ::kill(-worker.pid, SIGKILL);
  while (::waitpid(worker.pid, &worker.status, 0) < 0 && errno == EINTR) {
  }
  worker.pid = -1;
}

// Any error in a worker's message, or in handling it (usually for lack of memory), ends the worker. Its job is tried
// again.
void WorkerPool::read(const std::shared_ptr<Worker>& worker) {
  worker->socket.async_read_some(asio::buffer(worker->bytes),
                                 [this, worker](const boost::system::error_code& error, std::size_t count) {
                                   if (worker->is_ended) return;
                                   try {
                                     arm();
                                     if (error) return reap(worker, "");
                                     worker->received.append(worker->bytes.data(), count);
                                     take_lines(*worker);
                                     if (worker->received.size() > kLineMax) return reap(worker, kNonsense);
                                     if (!worker->is_ended) read(worker);
                                   } catch (const Json::exception&) {
                                     reap_soon(*worker, kNonsense);
                                   } catch (const std::exception& failed) {
                                     reap_soon(*worker, failed.what());
                                   }
                                 });
}

// Leaves the work to the next tick. Ticks retry until it succeeds.
void WorkerPool::reap_soon(Worker& worker, const char* why) {
  worker.is_ending = true;
  worker.kill_at = Clock::time_point::min();
  try {
    worker.why_killed = why;
  } catch (const std::bad_alloc&) {
    worker.why_killed.clear();
  }
}

void WorkerPool::take_lines(Worker& worker) {
  worker.heard = Clock::now();
  std::size_t begin = 0;
  for (std::size_t end = worker.received.find('\n'); end != std::string::npos;
       end = worker.received.find('\n', begin)) {
    const Json said = Json::parse(worker.received.data() + begin, worker.received.data() + end, nullptr, false);
    begin = end + 1;
    if (said.is_object()) take_line(worker, said);
  }
  worker.received.erase(0, begin);
}

// Throws Json::exception for a message that workers do not send.
void WorkerPool::take_line(Worker& worker, const Json& said) {
  if (said.contains("ready")) {
    worker.is_ready = true;
    failures_ = 0;
    events_.ready();
  } else if (said.contains("progress") && worker.job != 0) {
    const Json& progress = said["progress"];
    const JobProgress now = {text_of(progress, "stage"), progress.value("done", std::uint64_t{0}),
                             progress.value("total", std::uint64_t{0})};
    if (now.stage != worker.progress.stage || now.done != worker.progress.done) worker.got_on = worker.heard;
    worker.progress = now;
    events_.progress(worker.job, now);
  } else if (said.contains("ended") && said["ended"] == worker.job && said.value("attempt", 0) == worker.attempt) {
    const WorkResult result = {said.value("exit_code", 4), text_of(said, "message"),
                               said.value("inputs_changed", false)};
    const std::int64_t job = std::exchange(worker.job, 0);
    worker.kill_at = Clock::time_point::max();
    ++worker.jobs_done;
    if (is_closing_ || worker.jobs_done >= settings_.jobs_a_worker) {
      worker.is_ending = worker.is_asked_to_end = true;
      send(workers_.at(worker.owner), R"({"end":true})");
    }
    try {
      events_.ended(job, worker.owner, worker.attempt, result);
    } catch (...) {  // does not report the end, because the job still belongs to this worker
      worker.job = job;
      throw;
    }
    events_.ready();
  }
}

void WorkerPool::send(const std::shared_ptr<Worker>& worker, const std::string& line) {
  worker->to_send.push_back(line + "\n");
  if (worker->to_send.size() == 1) write_next(worker);
}

void WorkerPool::write_next(const std::shared_ptr<Worker>& worker) {
  asio::async_write(worker->socket, asio::buffer(worker->to_send.front()),
                    [this, worker](const boost::system::error_code& error, std::size_t) {
                      if (worker->is_ended || error) return;  // the reader notices errors too
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
  send(found->second, work_json(work).dump());
  return true;
}

bool WorkerPool::cancel(std::int64_t job) {
  for (const auto& [owner, worker] : workers_) {
    if (worker->job != job) continue;
    if (worker->kill_at == Clock::time_point::max()) {
      worker->kill_at = Clock::now() + settings_.cancel_grace;
      worker->why_killed = "its worker did not stop when asked, and was killed";
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
      worker->is_ending = worker->is_asked_to_end = true;
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
  worker->is_ended = worker->is_ending = true;
  worker->kill_at = Clock::time_point::min();  // after a failure below, the next tick tries again
  boost::system::error_code ignored;
  worker->socket.close(ignored);
  const bool is_lost = !worker->is_asked_to_end || worker->job != 0;
  end_process(*worker);
  const std::string end = why.empty() ? death_of(worker->status) : why;
  if (worker->job != 0) events_.ended(worker->job, worker->owner, worker->attempt, {-1, end, false});
  worker->job = 0;
  workers_.erase(std::string(worker->owner));
  if (is_lost) {
    ++lost_;
    if (!worker->is_ready) {
      ++failures_;
      service_log(LogSeverity::kWarning, 0, "before the worker was ready, " + end);
    }
    not_before_ = Clock::now() + (failures_ > 1 ? kTick * (1 << std::min(failures_, kBackOffDoublingsMax)) : kTick * 0);
  }
  if (!is_closing_) asio::post(io_, [this] { tick(); });
}

void WorkerPool::look_after(const std::shared_ptr<Worker>& worker, Clock::time_point now) {
  if (now > worker->kill_at) {
    reap(worker, worker->why_killed);
  } else if (now - worker->heard > settings_.lease) {
    reap(worker, fmt::format("its worker sent nothing for {} ms and was killed", settings_.lease.count()));
  } else if (worker->job != 0 && settings_.no_progress.count() > 0 && now - worker->got_on > settings_.no_progress) {
    reap(worker, fmt::format("its worker made no progress for {} ms and was killed", settings_.no_progress.count()));
  }
}

void WorkerPool::arm() {
  if (is_armed_) return;
  timer_.expires_after(kTick);
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (error == asio::error::operation_aborted) return;
    is_armed_ = false;
    tick();
  });
  is_armed_ = true;
}

void WorkerPool::tick() {
  const Clock::time_point now = Clock::now();
  try {
    arm();
    const auto all = workers_;  // a copy: ended workers leave the list
    for (const auto& [owner, worker] : all) look_after(worker, now);
    while (!is_closing_ && live_count() < settings_.workers && now >= not_before_) spawn();
  } catch (const std::exception& error) {  // too few files or processes, or too little memory
    not_before_ = now + std::chrono::seconds(5);
    service_log(LogSeverity::kError, 0, error.what());
  }
}

}  // namespace multum
