// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/service.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <systemd/sd-daemon.h>

#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>

#include "host/farm/service/files/data_lock.h"
#include "host/farm/service/files/network_disk.h"
#include "host/farm/service/http/http_api.h"
#include "host/farm/service/ledger/ledger_start.h"
#include "host/farm/service/log/run_handlers.h"
#include "host/farm/service/log/service_log.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/sandbox/confinement.h"

namespace multum {
namespace {

namespace asio = boost::asio;

// Every connection and every worker needs a file descriptor.
void raise_file_limit(const ServiceSettings& settings) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  const rlim_t wanted = static_cast<rlim_t>(settings.connections_max) + 256;
  if (limit.rlim_max < wanted)
    service_log(LogSeverity::kWarning, 0,
                fmt::format("this process can open {} files, but connections_max is {}; expected a limit of {} files "
                            "(LimitNOFILE, ulimit -n)",
                            limit.rlim_max, settings.connections_max, wanted));
}

std::string read_token(const std::string& path) {
  if (path.empty()) return "";
  RegularFileStream file(path);
  std::string token;
  if (!std::getline(file, token) || token.size() < 16)
    throw Error(ErrorCode::kInput, path + ": its first line is too short for a token, expected at least 16 characters");
  struct stat found {};
  if (::stat(path.c_str(), &found) == 0 && (found.st_mode & 077) != 0)
    throw Error(ErrorCode::kInput,
                path + ": other users can read it, expected a file that only its owner can read (chmod 600)");
  return token;
}

class Service {
 public:
  explicit Service(const ServiceOptions& options)
      : options_(options),
        settings_(options.settings),
        lock_(lock()),
        data_(settings_.data, settings_.data_max),
        roots_(roots_of(settings_, data_)),
        work_(asio::make_work_guard(io_)),
        // The event numbers of each daemon are higher than those of earlier daemons.
        events_(static_cast<std::uint64_t>(wall_clock_ms()) * 1000),
        ledger_(std::make_unique<QueueThread>(find_ledger(settings_.data, settings_.retry, options.begins_anew),
                                              [this](std::function<void()> task) {
                                                asio::post(io_,
                                                           [this, task = std::move(task)] { task_queue_.add(task); });
                                              })),
        dispatcher_(io_, *ledger_, events_, data_, settings_, roots_, take_up_ledger(*ledger_, settings_.data),
                    options.worker_command),
        api_(io_, *ledger_, dispatcher_, events_, data_, roots_, read_token(settings_.token_file),
             options.driver_command),
        server_(io_, server_settings(), events_, task_queue_),
        signals_(io_, SIGTERM, SIGINT),
        reload_signal_(io_, SIGHUP),
        watchdog_(io_),
        sweep_(io_) {
    api_.set_server(&server_);
  }

  ~Service() { ledger_.reset(); }  // the ledger posts to other objects, so it must end before them

  void run() {
    dispatcher_.recover();
    listen();
    dispatcher_.start();
    wait_for_signals();
    wait_for_reload();
    notify_watchdog();
    sweep();
    sd_notify(0, "READY=1");
    run_handlers(io_, LogSeverity::kError, "unexpected");
    service_log(LogSeverity::kInfo, 0, "ended");
  }

 private:
  std::unique_ptr<DataLock> lock() const {
    std::unique_ptr<DataLock> lock = DataLock::take(settings_.data);
    check_is_local(settings_.data);
    if (!lock) throw Error(ErrorCode::kEnvironment, settings_.data + ": another daemon is running there");
    return lock;
  }

  static JobRoots roots_of(const ServiceSettings& settings, const DataFolder& data) {
    std::vector<std::string> inputs = settings.roots, outputs = settings.roots;
    inputs.insert(inputs.end(), {data.uploads(), data.results()});
    outputs.push_back(data.results());
    return {PathRoots(inputs), PathRoots(outputs), PathRoots({data.results()}), data.seal()};
  }

  HttpServer::Settings server_settings() {
    HttpServer::Settings settings;
    settings.connections_max = settings_.connections_max;
    settings.memory_max = static_cast<std::size_t>(settings_.request_memory_max);
    settings.upload_max = static_cast<std::size_t>(settings_.upload_bytes_max);
    settings.is_upload = HttpApi::is_upload;
    settings.open_upload = [this](std::size_t bytes) { return data_.begin_upload(static_cast<std::int64_t>(bytes)); };
    settings.beside = [this](std::function<void()> work) { return api_.beside(std::move(work)); };
    settings.is_urgent = [](const std::string& path) {
      return path == "/healthz" || path == "/readyz" || path == "/metrics";
    };
    settings.check = [this](const HttpRequest& request) { return api_.check(request); };
    settings.answer = [this](HttpRequest request) { return api_.answer(std::move(request)); };
    return settings;
  }

  void listen() {
    const ListenAddress address = parse_listen_address(settings_.listen);
    std::string where = "unix:" + address.unix_path;
    if (!address.unix_path.empty()) {
      server_.listen_unix(address.unix_path);
    } else {
      const int port = server_.listen_tcp(address.host, address.port);
      const bool is_v6 = address.host.find(':') != std::string::npos;
      where = fmt::format("http://{}{}{}:{}", is_v6 ? "[" : "", address.host, is_v6 ? "]" : "", port);
    }
    // Writes the address for clients, in case the system chose the port.
    write_text_file(settings_.data + "/address", where + "\n");
    service_log(LogSeverity::kInfo, 0, "listening on " + where);
  }

  void wait_for_signals() {
    signals_.async_wait([this](const boost::system::error_code& error, int number) {
      if (error) return;
      if (is_ending_) {
        service_log(LogSeverity::kWarning, 0, "received a second signal: the daemon exits at once");
        io_.stop();
        return;
      }
      is_ending_ = true;
      service_log(LogSeverity::kInfo, 0, fmt::format("received signal {}: the daemon starts no more jobs", number));
      sd_notify(0, "STOPPING=1");
      dispatcher_.drain([this] {
        server_.close();
        // Leaves time for answers that are being sent.
        const auto last = std::make_shared<asio::steady_timer>(io_, std::chrono::milliseconds(200));
        last->async_wait([this, last](const boost::system::error_code&) { io_.stop(); });
      });
      wait_for_signals();
    });
  }

  void wait_for_reload() {
    reload_signal_.async_wait([this](const boost::system::error_code& error, int) {
      if (error) return;
      sd_notify(0, "RELOADING=1");
      try {
        ServiceSettings settings = options_.read_settings();
        // The new settings are checked together with those old values that stay in use until a restart.
        settings.listen = settings_.listen;
        settings.roots = settings_.roots;
        settings.data = settings_.data;
        check_service_settings(settings, options_.settings_file, options_.system);
        const std::string token = read_token(settings.token_file);
        if (token.empty() && api_.has_token())
          throw Error(ErrorCode::kUsage,
                      "token_file was removed from the settings: restart the service to run without a token");
        api_.set_token(token);
        dispatcher_.reload(settings);
        service_log(LogSeverity::kInfo, 0, "queues, devices, memory and the token were read again from the settings");
        sweep();
      } catch (const std::exception& wrong) {
        service_log(LogSeverity::kError, 0, std::string("the previous settings remain in use: ") + wrong.what());
      }
      sd_notify(0, "READY=1");
      wait_for_reload();
    });
  }

  void notify_watchdog() {
    std::uint64_t interval = 0;  // in microseconds
    if (sd_watchdog_enabled(0, &interval) <= 0) return;
    watchdog_.expires_after(std::chrono::microseconds(interval / 3));
    watchdog_.async_wait([this](const boost::system::error_code& error) {
      if (error) return;
      // Sends the sign of life through the ledger, so that a daemon whose ledger hangs counts as failed.
      ledger_->run([](JobQueue&) {},
                   [this](const std::exception_ptr&) {
                     sd_notify(0, "WATCHDOG=1");
                     notify_watchdog();
                   });
    });
  }

  // Every hour, removes jobs and files whose retention time is over.
  void sweep() {
    sweep_.expires_after(std::chrono::hours(1));
    sweep_.async_wait([this](const boost::system::error_code& error) {
      if (!error) sweep();
    });
    if (settings_.retention_days > 0) {
      const auto purged = std::make_shared<std::vector<std::int64_t>>();
      ledger_->run(
          [this, purged](JobQueue& queue) {
            *purged = queue.purge_finished_before(wall_clock_ms() - 86400000LL * settings_.retention_days, 10000);
            queue.take_changed();
          },
          [this, purged](const std::exception_ptr& error) {
            if (!error) dispatcher_.remove_logs(*purged);  // on error, the jobs still exist
          });
    }
    api_.pictures().sweep(*ledger_);
    constexpr int kForEver = 1000000;  // in days
    data_.sweep(*ledger_, std::chrono::hours(24) * (settings_.upload_days > 0 ? settings_.upload_days : kForEver));
  }

  const ServiceOptions& options_;
  ServiceSettings settings_;
  std::unique_ptr<DataLock> lock_;
  DataFolder data_;
  const JobRoots roots_;
  asio::io_context io_{1};
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  EventHub events_;
  TaskQueue task_queue_{io_};
  std::unique_ptr<QueueThread> ledger_;
  Dispatcher dispatcher_;
  HttpApi api_;
  HttpServer server_;
  asio::signal_set signals_, reload_signal_;
  asio::steady_timer watchdog_, sweep_;
  bool is_ending_ = false;
};

}  // namespace

void run_service(const ServiceOptions& options) {
  raise_file_limit(options.settings);
  check_service_settings(options.settings, options.settings_file, options.system);
  if (!can_confine())
    service_log(LogSeverity::kWarning, 0,
                "this kernel has no Landlock, so workers can open files outside the roots "
                "(docs/contributing/HOSTILE.md, \"The service\")");
  Service(options).run();
}

}  // namespace multum
