// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/workers/worker_loop.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/farm/service/files/result_copy.h"
#include "host/farm/service/files/staging.h"
#include "host/farm/service/workers/job_types.h"
#include "host/farm/service/workers/work_order.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr auto kBeat = std::chrono::seconds(1);
constexpr auto kProgressPause = std::chrono::milliseconds(100);  // pause between two progress reports

// Makes a job work in its staging folder. Uses the folder's descriptor, so that this works even if the folder is
// renamed meanwhile.
class WorkingFolder {
 public:
  /// If the folder is "", stays in the current folder.
  WorkingFolder(const PathRoots& roots, const std::string& path) {
    if (path.empty()) return;
    before_ = OpenFile(::open(".", O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (!before_.is_open() || ::fchdir(open_staging_folder(roots, path).descriptor()) != 0)
      fail_by_errno(path, "cannot be used as the working folder");
  }
  ~WorkingFolder() {
    if (before_.is_open() && ::fchdir(before_.descriptor()) != 0)
      std::_Exit(4);  // otherwise the next job would run in
                      // this folder
  }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  OpenFile before_;
};

// Redirects a job's output to its log.
class LogRedirection {
 public:
  explicit LogRedirection(const std::string& path) {
    if (path.empty()) return;
    const int log = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (log < 0) fail_by_errno(path, "cannot be written");
    const OpenFile file(log);
    for (const int stream : {1, 2}) {
      OpenFile& kept = kept_[stream - 1];
      kept = OpenFile(::fcntl(stream, F_DUPFD_CLOEXEC, 0));
      if (kept.is_open() && ::dup2(log, stream) == stream) continue;
      const int error = errno;
      put_back();  // the destructor will not run
      errno = error;
      fail_by_errno(path, "cannot write the job's output to it");
    }
  }
  ~LogRedirection() { put_back(); }
  LogRedirection(const LogRedirection&) = delete;
  LogRedirection& operator=(const LogRedirection&) = delete;

 private:
  // A failure could not be handled here, but dup2() does not fail for open descriptors.
  void put_back() {
    std::fflush(stdout);
    for (const int stream : {1, 2})
      if (kept_[stream - 1].is_open()) ::dup2(kept_[stream - 1].descriptor(), stream);
  }
  OpenFile kept_[2];
};

class Worker {
 public:
  Worker(int socket, const std::vector<std::string>& roots, const RunCommand& run)
      : socket_(socket), roots_(roots), run_(run) {}

  int work() {
    std::thread reader([this] { read_commands(); });
    std::thread beater([this] { beat(); });
    reader.detach();  // ends with the process
    beater.detach();
    send({{"ready", true}});
    for (;;) {
      Json command;
      {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [this] { return !commands_.empty(); });
        command = std::move(commands_.front());
        commands_.pop_front();
      }
      if (command.contains("end")) return 0;
      run_job(command);
    }
  }

 private:
  void send(const Json& message) {
    const std::string line = message.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    const std::lock_guard lock(send_mutex_);
    std::size_t sent = 0;
    while (sent < line.size()) {
      const ssize_t count = ::send(socket_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) std::_Exit(0);  // the daemon has ended
      sent += static_cast<std::size_t>(count);
    }
  }

  void read_commands() {
    std::string buffer;
    char bytes[65536];
    for (;;) {
      const ssize_t count = ::recv(socket_, bytes, sizeof(bytes), 0);
      if (count < 0 && errno == EINTR) continue;
      // The daemon has ended, perhaps by kill -9, so no result of this worker would be accepted.
      if (count <= 0) std::_Exit(0);
      buffer.append(bytes, static_cast<std::size_t>(count));
      for (std::size_t end = buffer.find('\n'); end != std::string::npos; end = buffer.find('\n')) {
        Json command = Json::parse(buffer.substr(0, end), nullptr, false);
        buffer.erase(0, end + 1);
        if (command.is_object()) take(std::move(command));
      }
    }
  }

  void take(Json command) {
    const std::lock_guard lock(mutex_);
    if (command.contains("cancel")) {
      cancelled_ = command["cancel"].get<std::int64_t>();
    } else {
      if (command.contains("run")) cancelled_ = 0;  // a retry may be the cancelled job
      commands_.push_back(std::move(command));
      wake_.notify_one();
    }
  }

  void beat() {
    for (;;) {
      std::this_thread::sleep_for(kBeat);
      if (!is_deaf_) send({{"beat", true}});
    }
  }

  void run_job(const Json& command) {
    const auto id = command.at("run").get<std::int64_t>();
    Clock::time_point said;
    const Progress::Callback callback = [&](const ProgressEvent& event) {
      if (Clock::now() - said > kProgressPause) {
        said = Clock::now();
        send({{"progress", {{"stage", event.stage}, {"done", event.units_done}, {"total", event.units_total}}}});
      }
      const std::lock_guard lock(mutex_);
      return cancelled_ != id;
    };
    int code = 4;
    std::string message;
    bool have_inputs_changed = true;
    try {
      const WorkOrder order = work_from(command);
      const LogRedirection log(order.log);
      const JobType& type = find_job_type(order.type);
      // Reports obstacles to publishing before the work begins.
      if (!order.output.empty()) StagedResult(roots_, order.output, "", 0, {}).check_place(type.output_is_folder);
      const WorkingFolder working(roots_, order.folder);
      check_inputs(type, order.parameters);
      // True if the inputs are unchanged since the job was submitted.
      const auto has_inputs = [&] { return input_identity(type, order.parameters) == order.inputs; };
      have_inputs_changed = !has_inputs();
      if (order.copy_from.empty() || have_inputs_changed) {
        code = run_order(type, order, callback);
      } else {
        copy_result(roots_, order.copy_from, order.copy_to);
        code = 0;
      }
      have_inputs_changed = have_inputs_changed || !has_inputs();
    } catch (const Cancelled&) {
      code = 130;
    } catch (const Error& error) {
      code = exit_code(error.code());
      message = error.what();
    } catch (const std::exception& error) {
      message = error.what();
    }
    send({{"ended", id},
          {"attempt", command.at("attempt")},
          {"exit_code", code},
          {"message", text_of_message(message)},
          {"inputs_changed", have_inputs_changed}});
  }

  // An input may name more files than when it was submitted. Files that the confinement (confinement.h) would block are
  // refused here by their names, whether they exist or not.
  void check_inputs(const JobType& type, const Json& parameters) const {
    if (type.input.empty()) return;
    for (const std::string& file : input_files(type, parameters)) roots_.input(file);
  }

  int run_order(const JobType& type, const WorkOrder& order, const Progress::Callback& callback) {
    std::vector<std::string> arguments =
        job_arguments(type, order.parameters, order.output.empty() ? "" : staged_name(order.output));
    if (!order.share.empty()) arguments.insert(arguments.begin() + 1, order.share);
    if (!type.run) return run_(arguments, callback);
    Progress progress(callback);
    return type.run(arguments, progress, is_deaf_);
  }

  int socket_;
  const PathRoots roots_;
  const RunCommand& run_;
  std::mutex mutex_, send_mutex_;
  std::condition_variable wake_;
  std::deque<Json> commands_;
  std::int64_t cancelled_ = 0;
  std::atomic<bool> is_deaf_ = false;
};

}  // namespace

int run_worker(int socket, const std::vector<std::string>& roots, const RunCommand& run) {
  std::signal(SIGINT, SIG_IGN);  // Ctrl-C is for the daemon, which then tells its workers
  std::signal(SIGTERM, SIG_IGN);
  return Worker(socket, roots, run).work();
}

}  // namespace multum
