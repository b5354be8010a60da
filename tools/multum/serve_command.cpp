// SPDX-License-Identifier: Apache-2.0
// multum serve: the daemon. multum worker: what it starts, for it alone. multum rescue: its damaged ledger.
#include <sys/prctl.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "host/base/error.h"
#include "host/base/machine.h"
#include "host/service/ledger_rescue.h"
#include "host/service/service.h"
#include "host/service/worker_loop.h"
#include "tools/multum/commands.h"

namespace multum {
namespace {

struct ServeOptions {
  ServiceSettings settings;
  std::string config;
  std::string listen, token_file;
  std::vector<std::string> roots;
  int workers = 0;
  bool begins_anew = false;
};

std::string own_program() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).string();
}

int run_serve(ServeOptions& o) {
  if (!o.config.empty()) read_service_settings(o.config, o.settings);
  if (!o.listen.empty()) o.settings.listen = o.listen;
  if (!o.token_file.empty()) o.settings.token_file = o.token_file;
  if (!o.roots.empty()) o.settings.roots = o.roots;
  if (o.settings.roots.empty()) o.settings.roots = {std::filesystem::current_path().string()};
  if (o.workers > 0) o.settings.workers = o.workers;
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const int threads =
      o.settings.threads_a_worker > 0 ? o.settings.threads_a_worker : std::max(1, cores / o.settings.workers);
  o.settings.data = std::filesystem::absolute(o.settings.data).string();
  run_service({o.settings, o.config, {own_program(), "worker", "--threads=" + std::to_string(threads)}, o.begins_anew});
  return 0;
}

int run_rescue(const std::string& data) {
  const RescueReport report = rescue_ledger(std::filesystem::absolute(data).lexically_normal().string());
  for (const RescueReport::Table& table : report.tables)
    std::printf("%-10s %lld rows saved, %lld were damaged\n", table.name.c_str(), static_cast<long long>(table.saved),
                static_cast<long long>(table.damaged));
  std::printf("the ledger before is %s\n", report.kept.c_str());
  return 0;
}

int run_worker_process(int socket, int threads) {
  // The daemon's end is this process's, also when it comes by kill -9 while a driver hangs here.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  // When memory runs out, a worker goes before the daemon does.
  std::ofstream("/proc/self/oom_score_adj") << 500;
  keep_freed_memory();
  return run_worker(socket, [threads](std::vector<std::string> arguments, const Progress::Callback& callback) {
    arguments.insert(arguments.begin() + 1, "--threads=" + std::to_string(threads));
    return run_command(arguments, callback);
  });
}

}  // namespace

void add_serve_commands(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* serve = app.add_subcommand("serve", "a service that bakes what clients submit (docs/SERVICE.md)");
  serve->add_option("--data", options->settings.data, "folder of its ledger, logs and uploads; made if need be")
      ->required();
  serve->add_option("--listen", options->listen, "HOST:PORT, [::1]:PORT or unix:PATH (default: 127.0.0.1:8470)");
  serve
      ->add_option("--root", options->roots,
                   "folder that jobs may read and write below; may be repeated (default: the current folder)")
      ->allow_extra_args(false);
  serve->add_option("--workers", options->workers, "bakes at once (default: 2)")->check(CLI::Range(1, 256));
  serve->add_option("--token-file", options->token_file, "file whose first line clients must know");
  serve->add_option("--config", options->config, "settings file, TOML; options here go before it");
  serve->add_flag("--new-ledger", options->begins_anew,
                  "begin a new ledger in a folder whose own is lost; nothing that lies there is removed");
  serve->callback([options, exit_code] { *exit_code = run_serve(*options); });

  auto data = std::make_shared<std::string>();
  CLI::App* rescue = app.add_subcommand(
      "rescue", "save what can be read of a service's damaged ledger into a new one (docs/SERVICE.md)");
  rescue->add_option("data", *data, "folder of the service, which must not run")->required();
  rescue->callback([data, exit_code] { *exit_code = run_rescue(*data); });

  auto socket = std::make_shared<int>(-1);
  auto threads = std::make_shared<int>(1);
  CLI::App* worker = app.add_subcommand("worker", "");
  worker->group("");  // not in the help: it is started by serve
  worker->add_option("--socket", *socket)->required();
  worker->add_option("--threads", *threads);
  worker->callback([socket, threads, exit_code] { *exit_code = run_worker_process(*socket, *threads); });
}

}  // namespace multum
